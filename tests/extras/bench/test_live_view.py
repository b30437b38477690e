"""The live view, and fingers drawn as they are estimated."""

from types import SimpleNamespace

import numpy as np
import pytest
from live_links import by_entry
from pydrake.math import RigidTransform, RollPitchYaw
from simulated_hardware import SimulatedHardware

from soft_gripper.diagrams.recording import Recording
from soft_gripper.diagrams.view.meshcat_view import hidden_meshcat
from soft_gripper.extras.bench import live_view
from soft_gripper.extras.bench.bench import Bench
from soft_gripper.extras.bench.estimate_scene import EstimateScene
from soft_gripper.extras.bench.live_view import LiveView
from soft_gripper.extras.hardware.bench_schema import bench_from_inputs
from soft_gripper.extras.page.session import Session
from soft_gripper.extras.page.signal_feed import SignalFeed
from soft_gripper.scenario.scenario_file import load_scenario

SCENARIO = load_scenario("tip_distance_steps", ["estimator.type=gaussian", "sensor.sections=2"])
OPENING, STD = "grip.opening", "left_finger.position_std"
STRAIN = "left_finger.strain"


class Seen(SignalFeed):
    """What is sent to a page with these plots."""

    wanted_signals = frozenset({OPENING, STD, STRAIN})

    def __init__(self):
        super().__init__(())
        self.sent = []

    def send(self, status, values):
        self.sent.append((status, values))


class Shown:
    """Simulated hardware, its driver, view and session, on a clock that runs while somebody waits."""

    is_over = False

    def __init__(self, folder):
        self.hardware, self.bench = SimulatedHardware(SCENARIO), Bench(SCENARIO)
        self.now, self.sent, self.is_silent, self.strains = 0.0, 0, False, []
        config = bench_from_inputs(self.bench.inputs, "test")
        self.view = LiveView(self.bench, config, self, self.obey, clock=lambda: self.now)
        self.session = Session(self.view, folder)
        self.session.feed = self.feed = Seen()

    def obey(self, _, results):
        self.hardware.command(results)

    def receive(self, timeout):
        due = (self.sent + 1) * self.bench.period
        if due > self.now + timeout:
            self.now += timeout
            return []
        self.now, self.sent = max(self.now, due), self.sent + 1
        message = self.hardware.message()
        self.strains.append(message[STRAIN].tolist())
        return [] if self.is_silent else [by_entry(message)]

    def run(self, seconds):
        """The last that the page was sent."""
        end = self.now + seconds
        while self.now < end - 1e-9:
            self.session.step()
        return self.feed.sent[-1]

    def click(self, button):
        assert self.view.panel.take({"button": button})


@pytest.fixture
def shown(tmp_path):
    found = Shown(tmp_path)
    yield found
    found.session.run(lambda: True)


def test_it_shows_what_is_read_and_estimated_and_nothing_else(shown):
    status, values = shown.run(0.5)
    assert (status["mode"], status["alarm"], status["note"]) == ("live", False, "")
    assert status["time"] == pytest.approx(0.5, abs=0.06)
    assert status["latency"].startswith("reading to result 0.0 ms")
    assert set(values) == Seen.wanted_signals
    assert values[STRAIN].tolist() in shown.strains
    estimates, readings = status["tables"]
    assert estimates[1] == ["", "left_finger", "right_finger"]
    assert shown.sent - 6 < int(readings[2][1]) <= shown.sent
    assert shown.view.signals == shown.bench.signals
    assert [*shown.view.fingers] == ["left_finger", "right_finger"]


def test_in_silence_it_is_stale_with_wider_bands(shown):
    _, before = shown.run(1.0)
    shown.is_silent = True
    status, values = shown.run(0.5)
    assert status["mode"] == "stale, 0.5 s"
    assert status["alarm"]
    assert values[STD][-1] > 5 * before[STD][-1]
    np.testing.assert_array_equal(values[OPENING], shown.bench.read([OPENING])[OPENING])


def test_a_recording_goes_from_click_to_click_and_has_what_was_estimated(shown, tmp_path):
    shown.run(0.5)
    shown.click("record")
    status, _ = shown.run(0.4)
    assert status["recording"]
    shown.click("record")
    shown.run(0.1)
    at_end = shown.bench.read([OPENING])[OPENING]
    shown.view.recorder.close()
    status, _ = shown.run(0.1)
    assert status["note"] == f"written: {tmp_path / '1' / 'recording.nc'}"
    recording = Recording.load(tmp_path / "1" / "recording.nc")
    assert recording["time"].values[0] == 0.0
    assert recording["time"].attrs["units"] == "s"
    assert 30 < len(recording["time"]) < 50
    assert recording[OPENING].values[-1] == pytest.approx(float(at_end[0]), abs=2e-3)
    assert (tmp_path / "1" / "scenario.yaml").is_file()
    assert shown.session.recordings == [tmp_path / "1"]


def test_a_view_that_fails_stops_nothing(shown, monkeypatch):
    def fail(_):
        raise RuntimeError("Meshcat's thread has ended")

    shown.run(0.2)
    monkeypatch.setattr(live_view, "has_failed", lambda _: True)
    monkeypatch.setattr(shown.view._estimate_scene, "show", fail)
    status, _ = shown.run(0.3)
    assert (status["mode"], status["note"]) == ("live", "the view failed; estimates and commands go on")


def scene(name, moving=(), *changes):
    scenario, meshcat = load_scenario(name, changes), hidden_meshcat()
    bench = Bench(scenario, moving)
    return EstimateScene(scenario, bench.signals, moving, meshcat), scenario, meshcat, bench


def estimates(drawn, bench):
    """Of fingers that read nothing but zeros."""
    bench.step({name: np.zeros(size) for name, size in bench.inputs.items()})
    return dict(bench.read(drawn.signals))


@pytest.mark.parametrize("name", ["tip_distance_steps", "three_chambers", "tendon_grasp"])
def test_every_signal_that_is_drawn_is_estimated(name):
    changes = ["estimator.type=gaussian"]
    drawn, _, meshcat, bench = scene(name, (), *changes)
    assert set(drawn.signals) <= bench.signals.keys()
    drawn.show(estimates(drawn, bench))
    assert meshcat.HasPath("/drake/visualizer")
    assert meshcat.HasPath("/drake/estimate/band")


def test_joints_follow_their_estimates_and_stay_while_these_are_unknown():
    drawn, _, _, bench = scene("tip_distance_steps", (), "estimator.type=gaussian")
    values = estimates(drawn, bench)
    angles = np.linspace(0.01, 0.05, 12)
    drawn.show(values | {"left_finger.estimated_joint_angles": angles})
    places = drawn._positions["left_finger.estimated_joint_angles"]
    np.testing.assert_array_equal(drawn._posed.positions[places], angles)
    drawn.show(values | {"left_finger.estimated_joint_angles": np.full(12, np.nan)})
    np.testing.assert_array_equal(drawn._posed.positions[places], angles)


def test_a_base_that_moves_carries_the_gripper_and_no_arm():
    fingers = ["left_finger", "right_finger"]
    name, changes = "pick_and_place_box", ["task=null", "control.set_points=[0.06]"]
    drawn, _, meshcat, _ = scene(name, fingers, *changes)
    assert not meshcat.HasPath("/drake/visualizer/arm")
    X_WB, found = RigidTransform(RollPitchYaw(np.pi, 0.0, 0.3), [0.4, 0.1, 0.2]), {}
    drawn._meshcat = SimpleNamespace(SetTransform=found.__setitem__)
    drawn.show({"left_finger.X_WB": X_WB.GetAsMatrix34().ravel()})
    carried = found["/drake"] @ drawn._base.X_WB
    np.testing.assert_allclose(carried.GetAsMatrix34(), X_WB.GetAsMatrix34(), atol=1e-12)
