"""What a bad link does to estimates and to a grip: bands widen, errors hardly grow, and nothing goes uncounted."""

import numpy as np
import pytest
from simulated_hardware import SimulatedHardware

from soft_gripper.diagrams.simulation import run_station
from soft_gripper.diagrams.station import make_station
from soft_gripper.extras.bench.bench import Bench
from soft_gripper.extras.bench.bench_driver import BenchDriver
from soft_gripper.extras.bench.messages import encoded
from soft_gripper.extras.hardware.bench_schema import described
from soft_gripper.scenario.scenario_file import load_scenario

PERIOD = 0.01
WORST = 1.1  # times the error over a good link
DROPPED = DELAYED = 0.1
TIP, STD = "left_finger.tip_pose", "left_finger.position_std"
LIMIT, MOST = 0.65, 0.9  # N
SILENCE = (3.0, 4.0)  # s
CLOSING = [
    *("sensor.sections=2", "sensor.errors.preset=realistic", "estimator.type=recursive"),
    *("control.set_points=[0.01]", f"control.force_limit={LIMIT}"),
    *("control.force_gains={kp: 2.0e4, ki: 4.0e5}", "control.gains={kp: 1.0e5, ki: 5.7e6, kd: 17}"),
]


class Link:
    """Messages, one every period of a clock that runs while somebody waits.

    On a bad link a tenth is dropped, another tenth comes one period late, after that of the period if there is one,
    and in the `silence`, from its begin to its end in s, nothing comes.
    """

    is_over = False

    def __init__(self, messages, is_bad, silence=(np.inf, np.inf)):
        self.messages, self.now, self.sent = iter(messages), 0.0, 0
        self.dropped, self.delayed = 0, []
        self._random, self._is_bad, self._silence = np.random.default_rng(4), is_bad, silence

    def receive(self, timeout):
        due = (self.sent + 1) * PERIOD
        if due > self.now + timeout:
            self.now += timeout
            return []
        self.now, self.sent = max(self.now, due), self.sent + 1
        return self._delivered(encoded(next(self.messages), "json"))

    def _delivered(self, message):
        late, self.delayed, chance = self.delayed, [], self._random.uniform()
        if self._silence[0] <= self.now < self._silence[1] or (self._is_bad and chance < DROPPED):
            self.dropped += 1
            return late
        if self._is_bad and chance < DROPPED + DELAYED:
            self.delayed = [message]
            return late
        return [message, *late]


def live(link, bench, send, take=lambda found: None):
    """A driver over a link, which takes each result by name."""
    config = described(bench.inputs, "test")
    config.send = send
    return BenchDriver(bench, config, link, lambda _, found: take(found), True, lambda: link.now)


@pytest.mark.slow
@pytest.mark.parametrize("estimator", ["gaussian", "recursive"])
def test_shape_error_over_a_bad_link(estimator):
    """Realistic sensors, exact model: the mean tip error of all results that came with a reading."""
    changes = [f"estimator.type={estimator}", "control.set_points=[0.06, 0.04, 0.05]", "control.hold=1.5"]
    scenario = load_scenario("tip_distance_steps", [*changes, "sensor.errors.preset=realistic"])
    recording = run_station(make_station(scenario))
    true = recording["left_finger.true_tip_position"].values[:, [0, 2]]
    errors, bands, counts = {}, {}, {}
    for is_bad in (False, True):
        bench, found = Bench(scenario), []
        link = Link(messages_of(recording, bench), is_bad, (2.0, 3.0) if is_bad else (np.inf, np.inf))
        driver = live(link, bench, [TIP, STD], found.append)
        while link.sent < recording.data.sizes["time"] - 1:
            driver.advance()
        known = {int(each["count"]): each for each in found if each["age"] == 0}
        errors[is_bad] = {n: np.linalg.norm(each[TIP][:2] - true[n]) for n, each in known.items()}
        bands[is_bad] = [each[STD][-1] for each in found if each["age"] > 0.5]
        counts[is_bad] = driver.counts, link
    both = sorted(errors[True])
    assert np.mean([errors[True][n] for n in both]) < WORST * np.mean([errors[False][n] for n in both])
    assert not bands[False]
    assert min(bands[True]) > 5 * np.median([each[STD][-1] for each in found if each["age"] == 0])
    seen, link = counts[True]
    assert seen.lost == link.dropped
    assert seen.used + seen.late == link.sent - link.dropped - len(link.delayed)
    assert seen.silences >= 1
    assert seen.late > 0.05 * link.sent


def messages_of(recording, bench):
    """What the sensors read in a run, sample by sample."""
    signals = {name: name.replace(".pressure", ".sampled_pressure") for name in bench.inputs}
    for i in range(1, recording.data.sizes["time"]):
        read = {name: np.ravel(recording[signal].values[i]) for name, signal in signals.items()}
        yield {"count": float(i), "time": PERIOD * i, **read}


@pytest.mark.slow
def test_a_grip_over_a_bad_link():
    """A box held at 0.65 N of estimated force; the true one counts, in the mean over three random sensor errors."""
    errors = []
    for seed in range(3):
        good, bad = held_box(7.0, False, seed), held_box(7.0, True, seed, SILENCE)
        begin, end = (round(time / PERIOD) for time in SILENCE)
        assert good.counts.silences == 0
        assert bad.counts.silences == 1
        assert np.all(bad.commands[begin - 50 : begin] > 0.0)
        assert np.all(bad.commands[begin + round(0.05 / PERIOD) : end - 1] == 0.0)
        held = np.r_[begin - 150 : begin, end + 150 : len(good.forces)]  # gripped for a while
        errors.append([np.abs(grip.forces[held].mean(axis=1) - LIMIT).mean() for grip in (good, bad)])
        assert bad.forces.max() < MOST
    over_good, over_bad = np.mean(errors, axis=0)
    assert over_bad < WORST * over_good


def held_box(seconds, is_bad, seed, silence=(np.inf, np.inf)):
    """Closed loop between simulated hardware and its bench: true forces (T, 2) N, commands (T) Pa, by sample."""
    scenario = load_scenario("box_grasp", [*CLOSING, f"sensor.seed={seed}"])
    hardware, bench = SimulatedHardware(scenario), Bench(scenario)
    forces, commands, last = [], [], [np.nan]
    names = [f"{side}_finger.normal_force" for side in ("left", "right")]

    def messages():
        while True:
            yield hardware.message()
            forces.append(np.ravel([*hardware.read(names).values()]))
            commands.append(last[0])

    def obey(found):
        last[0] = found["left_finger.pressure_command"][0]
        hardware.command(found)

    link = Link(messages(), is_bad, silence)
    driver = live(link, bench, ["grip.opening"], obey)
    while link.now < seconds:
        driver.advance()
    driver.forces, driver.commands = np.array(forces), np.array(commands)
    return driver
