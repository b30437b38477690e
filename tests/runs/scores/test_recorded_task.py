"""A recorded task: what of it succeeded, and how the object is turned from its goal."""

from dataclasses import replace

import numpy as np
import pytest
from pick_and_place import FINGERS, box_recording, box_station, state
from pydrake.common.eigen_geometry import AngleAxis
from pydrake.math import RigidTransform, RollPitchYaw, RotationMatrix

from soft_gripper.control.task import Outcome
from soft_gripper.diagrams.station_parts import Station
from soft_gripper.runs.scores.recorded_task import Judged, angle, detection_delay, false_alarm, judged, tilt, yaw
from soft_gripper.runs.success import success_criteria, success_rows

IN_PHASE = 10  # samples
NAMES = ["approach", "descend", "close", "lift", "carry", "lower", "release", "retreat", "return"]
TOUCH, FREE = 25, 65  # samples at which contact begins and ends
OVER = IN_PHASE * len(NAMES)


@pytest.fixture(scope="module")
def station() -> Station:
    return box_station()


def good_signals(station: Station) -> dict[str, np.ndarray]:
    """A task that goes well: ten samples in every phase, the box held from the third to the seventh."""
    number = {phase.name: i for i, phase in reversed(list(enumerate(station.task.phases)))}
    goal = station.scenario.task.X_WGoal.GetDeterministicValue()
    phase = np.repeat([*(number[name] for name in NAMES), len(station.task.phases)], IN_PHASE).astype(float)
    length = len(phase)
    signals = {
        "task.phase": phase,
        "task.outcome": np.where(np.arange(length) < OVER, Outcome.RUNNING, Outcome.DONE).astype(float),
        "plant.state": np.tile(state(station, goal, {}), (length, 1)),
        "grip.object_width": np.full(length, 0.044),
        "grip.true_object_width": np.full(length, 0.044),
    }
    touched = (np.arange(length) >= TOUCH) & (np.arange(length) < FREE)
    for finger in FINGERS:
        signals[f"{finger}.normal_force"] = 1.0 * touched
        signals[f"{finger}.contact"] = 1.0 * np.roll(touched, 2)
        signals[f"{finger}.contact_center"] = np.tile(goal.translation(), (length, 1))
    return signals


def row(station: Station, signals: dict[str, np.ndarray]) -> Judged:
    return judged(station, box_recording(station, signals))


def begin(name: str) -> int:
    """The first sample of a phase."""
    return IN_PHASE * NAMES.index(name)


def put(station: Station, signals: dict[str, np.ndarray], samples: slice, offset: list[float]) -> None:
    """Moves the box away from the goal, (3,) m."""
    X_WGoal = station.scenario.task.X_WGoal.GetDeterministicValue()
    signals["plant.state"][samples] = state(station, RigidTransform(offset) @ X_WGoal, {})


def test_a_task_that_goes_well_is_a_success(station):
    expected = Judged(True, 0.0, 0.0, False, 1.0, float("nan"), 0.0, 20.0, 0.0, 0.9, "")
    for value, other in zip(vars(row(station, good_signals(station))).values(), vars(expected).values(), strict=True):
        assert value == (pytest.approx(other, abs=1e-9, nan_ok=True) if isinstance(other, float) else other)


@pytest.mark.parametrize(
    ("rpy_deg", "cause"),
    [
        ([0, 0, 9.9], ""),
        ([9.9, 0, 0], ""),
        ([0, 0, -10.1], "placed 10.1 degrees from the goal, tilted by 0.0, above 10 degrees"),
        ([0, 10.1, 0], "placed 10.1 degrees from the goal, tilted by 10.1, above 10 degrees"),
        ([90, 0, 0], "placed 90.0 degrees from the goal, tilted by 90.0, above 10 degrees"),
        ([0, 0, 180], "placed 180.0 degrees from the goal, tilted by 0.0, above 10 degrees"),
    ],
)
def test_what_stands_in_its_place_must_stand_upright_and_turned_as_it_should(station, rpy_deg, cause):
    """It is turned about its own middle, which is where it is to be."""
    X_WGoal = station.scenario.task.X_WGoal.GetDeterministicValue()
    turned = RigidTransform(RollPitchYaw(np.radians(rpy_deg)), np.zeros(3))
    signals = good_signals(station)
    signals["plant.state"][-1] = state(station, X_WGoal @ turned, {})
    found = row(station, signals)
    assert (found.cause, found.success) == (cause, not cause)
    assert found.placed_error_mm == pytest.approx(0.0, abs=1e-9)
    assert found.placed_angle_deg == pytest.approx(max(map(abs, rpy_deg)), abs=1e-6)


def test_slip_counts_while_the_object_is_lifted_and_carried_only(station):
    signals = good_signals(station)
    put(station, signals, slice(None, begin("lift")), [0.0, 0.1, 0.1])
    put(station, signals, slice(begin("lower"), -1), [0.0, 0.1, 0.1])
    assert row(station, signals).slip_mm == pytest.approx(0, abs=1e-9)
    put(station, signals, slice(begin("lower") - 1, begin("lower")), [0.0, 0.0, 0.0021])
    found = row(station, signals)
    assert found.slip_mm == pytest.approx(2.1, abs=0.05)  # the faces of the fingers are nearly upright
    assert found.cause == f"slip of {found.slip_mm:.2f} mm, above 2 mm"


def test_dropped_means_no_finger_touches_it_while_it_is_to_be_held(station):
    signals = good_signals(station)
    signals["left_finger.normal_force"][begin("carry") :] = 0
    assert not row(station, signals).dropped
    signals["right_finger.normal_force"][begin("carry") + 4] = 0
    found = row(station, signals)
    assert (found.dropped, found.success, found.cause) == (True, False, "dropped at 0.44 s in 'carry'")


@pytest.mark.parametrize(
    ("outcome", "after", "dropped", "cause"),
    [
        (Outcome.NOTHING_GRASPED, "close", False, "nothing grasped at 0.29 s in 'close'"),
        (Outcome.NOT_OPENED, "approach", False, "not opened at 0.09 s in 'approach'"),
        (Outcome.NOT_RELEASED, "release", False, "not released at 0.69 s in 'release'"),
        (Outcome.OBJECT_LOST, "carry", True, "dropped at 0.49 s in 'carry'"),
        (Outcome.RUNNING, "return", False, "not over at 0.99 s in 'rescue: open'"),
    ],
)
def test_a_task_that_was_not_done(station, outcome, after, dropped, cause):
    signals = good_signals(station)
    rescue = [phase.name for phase in station.task.phases].index("rescue: open")
    failed = begin(after) + IN_PHASE
    signals["task.phase"][failed:] = rescue
    signals["task.outcome"][failed:] = outcome
    found = row(station, signals)
    assert (found.success, found.dropped, found.cause) == (False, dropped, cause)


def test_the_largest_force_of_either_finger_is_compared_with_what_the_object_bears(station):
    signals = good_signals(station)
    signals["right_finger.normal_force"][begin("lower")] = 2.6
    assert row(station, signals).peak_force_n == pytest.approx(2.6)
    assert row(station, signals).success
    task = replace(station.scenario.task, force_limit=2.5)
    scenario = replace(station.scenario, task=task)
    delicate = replace(station, parts=replace(station.parts, scenario=scenario))
    assert row(delicate, signals).cause == "force of 2.60 N, above 2.5 N"
    compared = success_rows(delicate, box_recording(delicate, signals))
    assert [criterion.criterion for criterion in compared] == success_criteria(scenario)
    (missed,) = (criterion for criterion in compared if not criterion.met)
    assert (missed.criterion, missed.measured) == (
        "no finger presses with more than 2.5 N",
        "force of 2.60 N, above 2.5 N",
    )


def test_the_delay_is_that_of_the_slower_finger(station):
    signals = good_signals(station)
    signals["right_finger.contact"] = np.roll(signals["right_finger.contact"], 3)
    assert row(station, signals).detection_delay_ms == pytest.approx(50)
    signals["right_finger.contact"][:] = 0
    assert row(station, signals).detection_delay_ms == np.inf


@pytest.mark.parametrize("name", ["approach", "return"])
def test_contact_reported_in_free_motion_is_a_false_alarm(station, name):
    signals = good_signals(station)
    signals["left_finger.contact"][begin(name) + 3] = 1
    assert row(station, signals).cause == f"false alarm of left_finger at {0.01 * begin(name) + 0.03:.2f} s in '{name}'"


def test_size_error_is_that_as_the_fingers_have_closed(station):
    signals = good_signals(station)
    signals["grip.object_width"][:] = 1.0
    signals["grip.true_object_width"][: begin("lift") - 1] = np.nan
    signals["grip.object_width"][begin("lift") - 1] = 0.0425
    assert row(station, signals).size_error_mm == pytest.approx(1.5)


def test_what_was_never_reached_is_not_a_number(station):
    signals = {name: values[: begin("descend")] for name, values in good_signals(station).items()}
    found = row(station, signals)
    assert np.isnan([found.slip_mm, found.detection_delay_ms, found.size_error_mm]).all()
    assert found.cause == "not over at 0.09 s in 'approach'"


def test_slip_that_is_not_known_is_no_success(station):
    signals = good_signals(station)
    for finger in FINGERS:
        signals[f"{finger}.contact_center"][:] = np.nan
    found = row(station, signals)
    assert np.isnan(found.slip_mm)
    assert not found.success


def flags(text: str) -> np.ndarray:
    return np.array([mark != "." for mark in text])


@pytest.mark.parametrize(
    ("true", "reported", "alarm", "delay"),
    [
        ("....xxxxxxxx....", "......xxxxxxxx..", None, 2),
        ("....xxxxxxxx....", "..xxxxxxxxxxxx..", 2, -2),
        ("....xxxxxxxx....", "xxxxxxxxxxxxxx..", 0, -4),
        ("....xxxxxxxx....", ".....x.x.xxxx...", None, 1),
        ("....xx..........", ".......xxx......", None, 3),
        ("....xx..........", "......x...x.....", 10, 2),
        ("....xx..........", ".....x........xx", 14, 1),
        ("................", "..........xxxxxx", 10, np.nan),
        ("....xxxxxxxx....", "................", None, np.inf),
        ("................", "................", None, np.nan),
    ],
)
def test_alarms_and_delays(true, reported, alarm, delay):
    assert false_alarm(flags(reported), flags(true)) == alarm
    found = detection_delay(np.arange(16.0), flags(reported), flags(true))
    assert found == pytest.approx(delay, nan_ok=True)


def rotation(tilted: float, toward: float, turned: float) -> RotationMatrix:
    """A turn about the own z axis, which is then tilted toward a side, rad."""
    axis = [-np.sin(toward), np.cos(toward), 0.0]
    return RotationMatrix(AngleAxis(tilted, axis)) @ RotationMatrix.MakeZRotation(turned)


@pytest.mark.parametrize("toward", [0.0, 0.7, 3.0, -2.0])
@pytest.mark.parametrize("tilted", [0.0, 1e-6, 0.1, 1.5, 3.0])
@pytest.mark.parametrize("turned", [0.0, 0.2, -1.5, 3.1, -3.1])
def test_tilt_and_turn_are_separated(tilted, toward, turned):
    R = rotation(tilted, toward, turned)
    assert tilt(R) == pytest.approx(tilted, abs=1e-9)
    assert yaw(R) == pytest.approx(turned, abs=1e-6)
    # Half-angle formula of the product of two rotations about axes at right angles.
    assert np.cos(angle(R) / 2) == pytest.approx(np.cos(tilted / 2) * np.cos(turned / 2), abs=1e-9)
