"""Readings over UDP and serial give the estimates of an offline replay; what goes wrong on the way is counted."""

import os
import time
from types import SimpleNamespace

import numpy as np
import pytest
from live_links import feed, pseudo_terminal, udp
from pydrake.math import RollPitchYaw
from refusals import refused
from waiting import LONG

from soft_gripper.diagrams.simulation import run_station
from soft_gripper.diagrams.station import make_station
from soft_gripper.extras.bench.bench import Bench
from soft_gripper.extras.bench.bench_driver import BenchDriver, Pace, _RecentChanges
from soft_gripper.extras.bench.endpoints import Endpoints, LineSource
from soft_gripper.extras.bench.messages import MalformedError, decoded, encoded
from soft_gripper.extras.bench.plausible import check_plausible
from soft_gripper.extras.bench.tally import Tally
from soft_gripper.extras.hardware.bench_schema import bench_from_inputs
from soft_gripper.scenario.scenario_file import load_scenario

SCENARIO = load_scenario(
    "tip_distance_steps", ["estimator.type=gaussian", "control.set_points=[0.06, 0.04]", "control.hold=1.0"]
)
TIP, STD = "left_finger.tip_pose", "left_finger.position_std"
COMMAND = "left_finger.pressure_command"


@pytest.fixture(scope="module")
def messages():
    """What the sensors of a run read, sample by sample."""
    recording, inputs = run_station(make_station(SCENARIO)), Bench(SCENARIO).inputs
    signals = {name: name.replace(".pressure", ".sampled_pressure") for name in inputs}
    return [
        {"count": float(i), "time": 0.01 * i} | {n: np.ravel(recording[s].values[i]) for n, s in signals.items()}
        for i in range(1, recording.data.sizes["time"])
    ]


@pytest.fixture(scope="module")
def offline(messages):
    """The results of these readings, by number."""
    live = made(lambda timeout: [])
    for message in messages:
        live.driver._take(encoded(message, "json"), time.monotonic())
    return by_count(live.results)


def made(receive, is_live=False, clock=time.monotonic, **changes):
    """A driver, what it has sent, and what it has said."""
    bench, results, said = Bench(SCENARIO), [], []
    config = bench_from_inputs(bench.inputs, "test")
    for name, value in changes.items():
        setattr(config, name, value)
    source = receive if hasattr(receive, "receive") else SimpleNamespace(receive=receive, is_over=False)
    driver = BenchDriver(bench, config, source, lambda _, found: results.append(found), is_live, clock, said.append)
    return SimpleNamespace(driver=driver, results=results, bench=bench, said=said)


def by_count(results):
    return {int(found["count"]): found for found in results if TIP in found and found["age"] == 0}


def assert_as_offline(live, offline, counts, names=(TIP, STD, COMMAND)):
    found = by_count(live.results)
    assert found.keys() >= set(counts)
    for count in counts:
        for name in names:
            np.testing.assert_array_equal(found[count][name], offline[count][name])


@pytest.mark.parametrize("link", [udp, pseudo_terminal])
def test_links_that_lose_nothing(link, messages, offline):
    with link() as (source, send):
        live = made(source, is_live=True, stale_after=LONG)  # however busy the machine, no reading is passed over
        feed(live.driver, send, messages, 0.01)
    is_busy = live.driver.counts.silences > 1  # of this machine, so that control began anew; the last one is the end
    assert_as_offline(live, offline, range(1, len(messages) + 1), (TIP, STD) if is_busy else (TIP, STD, COMMAND))
    assert live.driver.counts.used == len(messages)
    assert live.driver.counts.lost == 0


PRESSURES = "left_finger.pressure", "right_finger.pressure"


@pytest.mark.parametrize(
    ("ambient", "read", "asks"),
    [(None, 101.3e3, True), (0.0, 101.3e3, False), (101.3e3, 101.3e3, False), (None, 0.0, False)],
    ids=["not given", "relative", "absolute", "near zero"],
)
def test_pressures_measured_against_vacuum(ambient, read, asks, messages, offline):
    """They are questioned once, after the first second, unless the bench says what open air has."""
    live = made(lambda timeout: [], pressure_ambient=ambient)
    for message in messages:
        absolute = {name: read + message[name] for name in PRESSURES}
        live.driver._take(encoded(message | absolute, "json"), time.monotonic())
        assert len(live.said) == (len(PRESSURES) if asks and len(live.results) >= 100 else 0)
    if asks:
        assert "left_finger.pressure[0]" in live.said[0]
        assert "measured against vacuum" in live.said[0]
    if ambient:
        found = by_count(live.results)
        for count, known in offline.items():
            np.testing.assert_allclose(found[count][TIP], known[TIP], rtol=1e-9, atol=1e-12)


def test_losses_and_disorder_are_counted_and_harmless(messages, offline):
    """10 % lost and 10 % swapped with the next."""
    random = np.random.default_rng(3)
    order = [message for message in messages if random.uniform() > 0.1]
    for i in range(5, len(order) - 5, 10):
        order[i], order[i + 1] = order[i + 1], order[i]
    live = made(lambda timeout: [])
    for message in order:
        live.driver._take(encoded(message, "json"), time.monotonic())
    counts, sent = live.driver.counts, {int(message["count"]) for message in order}
    assert counts.late > 5
    assert counts.used == len(order) - counts.late
    assert counts.lost == max(sent) - min(sent) + 1 - len(sent)
    for count, found in by_count(live.results).items():
        np.testing.assert_array_equal(found[TIP], offline[count][TIP])


class Scripted:
    """Messages that arrive at given times of a clock, which runs while somebody waits."""

    is_over = False

    def __init__(self, arrivals):
        self.arrivals, self.now = list(arrivals), 0.0

    def receive(self, timeout):
        if self.arrivals and self.arrivals[0][0] <= self.now + timeout:
            self.now, message = max(self.now, self.arrivals[0][0]), self.arrivals.pop(0)[1]
            return [message]
        self.now += timeout
        return []


def test_silence_widens_bands_and_makes_commands_safe(messages, offline):
    """0.4 s of it, in the middle of a motion: the true tip stays within three standard deviations."""
    silent, last = range(105, 145), 105
    sent = [(0.01 * i, encoded(m, "json")) for i, m in enumerate(messages[:160]) if i not in silent]
    source = Scripted(sent)
    live = made(source, is_live=True, clock=lambda: source.now, safe_command=-100.0)
    while source.now < 2.0:
        live.driver.advance()
    aged = [found for found in live.results if found["age"] > 0 and found["count"] == last]
    ages = np.array([found["age"] for found in aged])
    expected = [0.015, 0.025, 0.035, *(0.04 + 0.01 * np.arange(37))]  # a period apart, but when commands become safe
    np.testing.assert_allclose(ages, expected, atol=1e-9)
    safe = np.array([found[COMMAND][0] == -100.0 for found in aged])
    np.testing.assert_array_equal(safe, np.arange(len(aged)) >= 3)
    np.testing.assert_array_equal(safe, [found["stale"] for found in aged])
    for found, true in zip(aged, range(last + 1, last + 41), strict=True):
        apart = np.linalg.norm(offline[true][TIP][:2] - found[TIP][:2])
        assert apart < 3 * found[STD][-1]
    widths = [found[STD][-1] for found in aged]
    assert widths[-1] > 10 * offline[last][STD][-1]
    again = by_count(live.results)[146]
    assert (again["lost"], again[STD][-1]) == (40, offline[146][STD][-1])
    assert live.driver.counts.silences == 2  # the other one at the end


def test_a_flood_only_counts(messages):
    """A thousand readings at once, where a bunch of half a second is allowed."""
    live = made(lambda timeout: [], is_live=True)
    live.driver._pace = Pace(0.01, clock=lambda: 0.0)
    for i in range(1000):
        live.driver._take(encoded(messages[0] | {"count": float(i)}, "json"), time.monotonic())
    assert (live.driver.counts.used, live.driver.counts.excess) == (50, 950)


def test_a_machine_that_is_too_slow_stays_close_behind(messages):
    """An estimate takes three periods: readings that cannot be used are counted, and the last is hardly late."""
    source = Waiting(encoded(messages[0] | {"count": float(i)}, "json") for i in range(1000))
    live = made(source, is_live=True, clock=lambda: source.now)
    step = live.bench.step
    live.bench.step = lambda measured: (step(measured), source.pass_time())
    while source.arrived < 1000:
        live.driver.advance()
    counts = live.driver.counts
    assert counts.used + counts.lost == 1000
    assert counts.used == pytest.approx(333, abs=30)
    assert counts.excess == counts.lost
    assert max(live.driver.latencies) < 0.04
    assert live.bench._context.get_time() == pytest.approx(9.99, abs=0.03)  # the time of set points, and of recordings


class Waiting:
    """Messages that arrive every period of a clock, which runs while an estimate is computed."""

    is_over = False

    def __init__(self, messages):
        self.messages, self.now, self.arrived = list(messages), 0.0, 0

    def receive(self, timeout):
        self.now += 1e-9
        found = self.messages[self.arrived : int(self.now / 0.01) + 1]
        self.arrived += len(found)
        if not found:
            self.now += timeout
        return found

    def pass_time(self):
        self.now += 0.03


@pytest.mark.parametrize("estimator", ["gaussian", "recursive"])
def test_zeroed_sensors_are_known_as_well_as_at_first(estimator):
    """Sensors of a free finger have drifted for 200 s, of which `recursive` has learned a part."""
    errors = "sensor.errors={drift: 0.01, noise: 0.002}", "sensor.period=4.0"
    bench, results = Bench(load_scenario("free_bending", [f"estimator.type={estimator}", *errors])), []
    config, source = bench_from_inputs(bench.inputs, "test"), SimpleNamespace(receive=lambda timeout: [], is_over=False)
    driver = BenchDriver(bench, config, source, lambda _, found: results.append(found), is_live=False)
    bench.step({name: np.zeros(size) for name, size in bench.inputs.items()})
    free = bench.free_readings()

    def feed(samples, shift):
        for _ in range(samples):
            values = {name: free.get(name, np.zeros(size)) for name, size in bench.inputs.items()}
            read = {name: value + shift * (name in free) for name, value in values.items()}
            driver._take(encoded({"count": float(len(results)), "time": 0.0} | read, "json"), 0.0)
        return {name: results[-1][name].copy() for name in (TIP, STD)}

    first = feed(2, 0.0)
    feed(50, 0.02)
    driver.zero(60.0)
    feed(3, 0.02)
    driver.end_zeroing()
    again = feed(2, 0.02)
    np.testing.assert_allclose(again[STD], first[STD], rtol=1e-3)
    np.testing.assert_allclose(again[TIP], first[TIP], atol=2e-4)


def test_zeroing_without_readings():
    live = made(lambda timeout: [])
    live.driver.zero(60.0)
    with refused("--zero", "no reading"):
        live.driver.end_zeroing()


def test_lines_of_any_length():
    read, write = os.pipe()
    source = LineSource(read)
    os.write(write, b'{"a": 1}\n\n{"a": 2}\n{"a"')
    assert source.receive(0.1) == [b'{"a": 1}', b'{"a": 2}']
    os.write(write, b": 3}\n")
    assert source.receive(0.1) == [b'{"a": 3}']
    os.close(write)
    assert source.receive(0.1) == []
    assert source.is_over
    assert decoded(b'{"a": 3}', "json", ()) == {"a": 3.0}


def test_the_rest_of_a_line_without_end_is_no_reading():
    read, write = os.pipe()
    source, found = LineSource(read), []
    for piece in (b"x" * 60_000, b"x" * 60_000, b"1, 2", b"3, 4\n5, 6\n"):
        os.write(write, piece)
        found += source.receive(0.1)
    os.close(write)
    os.close(read)
    assert [len(line) for line in found] == [120_000, 4]
    assert found[1] == b"5, 6"


def test_a_file_with_a_line_without_end_is_refused_by_its_line(tmp_path):
    (tmp_path / "a.csv").write_bytes(b"1, 2\n" + b"3, 4" * 100_000)
    with Endpoints("bench.yaml") as endpoints:
        source = endpoints.source(f"file:{tmp_path}/a.csv")
        assert source.receive(0.1) == [b"1, 2\n"]
        with refused("line", 2):
            source.receive(0.1)


@pytest.mark.parametrize(
    "address", ["udp://127.0.0.1", "udp://127.0.0.1:99999", "file:/no/such/file.csv", "nowhere", "tcp://:5"]
)
def test_addresses_that_cannot_be_opened(address):
    with Endpoints("bench.yaml") as endpoints, refused("source", address):
        endpoints.source(address)


@pytest.mark.parametrize(
    ("pressures", "said"),
    [
        (np.full(60, 50e3), "while its drive rested 1 contact, at most 0.60 ± 0.10 N, at 80 mm; while that changed no"),
        (np.linspace(0, 60e3, 60), "while its drive rested no contact; while that changed 1 contact, at most 0.60 ±"),
        (np.linspace(0, 0.9e3, 60), "while its drive rested 1 contact"),
    ],
    ids=["rests", "moves", "drifts"],
)
def test_contacts_are_told_apart_by_whether_the_drive_rested(pressures, said):
    """The drive rests if it changes by a hundredth of the range of its supply at most; three readings are a contact."""
    supply = SimpleNamespace(minimum=0.0, maximum=100e3)
    bench = SimpleNamespace(
        quantities=["finger"], inputs=["finger.pressure"], scenario=SimpleNamespace(pressure=supply), period=0.02
    )
    tally, forces = Tally(bench), np.zeros(60)
    forces[10:12] = 2.0  # in too few readings
    forces[40:] = np.linspace(0.2, 0.6, 20)
    for pressure, force in zip(pressures, forces, strict=True):
        found = {"transverse_force": force, "transverse_force_std": 0.1, "contact_arc_length": 0.08}
        sent = {f"finger.{name}": np.array([value]) for name, value in found.items()}
        tally.note({"finger.pressure": np.array([pressure])}, sent)
    (line,) = tally.lines()
    assert said in line


def test_a_band_widens_by_how_far_its_own_estimate_moved_of_late():
    """By 0.3 N from sample to sample of the one force; the other rests."""
    values = iter([0.0, 0.3, 0.3])
    bench = SimpleNamespace(period=0.1, signals={"f.transverse_force": None, "f.contact_force": None})

    def read(names):
        force = next(values) if "f.transverse_force" in names else 0.5
        return {name: np.array([force]) for name in names}

    bench.read = read
    stds = {"f.transverse_force_std": np.array([0.4]), "f.contact_force_std": np.array([0.1])}
    changes = _RecentChanges(bench, list(stds))
    for _ in range(3):
        changes.note()
    wider = changes.widened(stds, 0.1)
    assert wider["f.transverse_force_std"] == pytest.approx(0.5)
    assert wider["f.contact_force_std"] == pytest.approx(0.1)


def test_a_pose_that_is_no_rotation_is_malformed():
    """Rounded rotations pass; mirrored, sheared and scaled axes do not, nor do places out of this world."""
    ranges, turned = {"finger.X_WB": (-1e3, 1e3)}, RollPitchYaw(0.4, -1.1, 2.0).ToRotationMatrix().matrix()
    place = np.array([[0.1], [-3.0], [0.5]])

    def check(rotation, place=place):
        check_plausible({"finger.X_WB": np.hstack([rotation, place]).ravel()}, ranges, set())

    check(turned.round(3))
    sheared = np.eye(3) + 0.1 * np.eye(3, k=1)
    for wrong in (turned @ np.diag([1, 1, -1]), turned @ sheared, 1.1 * turned, 0 * turned):
        with pytest.raises(MalformedError, match=r"has no rotation in finger.X_WB"):
            check(wrong)
    with pytest.raises(MalformedError, match=r"has 5000 as entry 3 of finger.X_WB, which is not within -1000 to 1000"):
        check(turned, np.array([[5e3], [0.0], [0.0]]))
