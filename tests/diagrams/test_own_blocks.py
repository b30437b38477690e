"""What a user's own blocks do wrong ends in an InputError that names function, port, size and time."""

import sys

import numpy as np
import pytest
from command_line import soft_gripper
from finger_plants import free_bending
from pydrake.systems.framework import LeafSystem

import soft_gripper as sg

LATE = 0.1  # s
SHORT = ("pressure.steps.all=[20e3]", "pressure.settle=0.15", "pressure.hold_samples=5")


def boom(*_):
    raise RuntimeError("no calibration")


def missing(*_):
    return {}["gain"]


def leave(*_):
    sys.exit(0)


class Estimator(LeafSystem):
    """Answers with zeros up to LATE, then with what a function gives; another function is its update."""

    def __init__(self, layout, period, answer, update=None, late=LATE):
        super().__init__()
        self.answer, self.joints, self.late = answer, layout.finger.segments, late
        self.strain = self.DeclareVectorInputPort("strain", layout.readings)
        self.DeclareVectorOutputPort("estimated_joint_angles", self.joints, self.calc)
        if update is not None:
            self.update = update
            self.DeclareDiscreteState(1)
            self.DeclarePeriodicDiscreteUpdateEvent(period, 0.0, self.remember)

    def calc(self, context, output):
        self.strain.Eval(context)
        angles = np.zeros(self.joints) if context.get_time() < self.late - 1e-9 else self.answer(self.joints)
        if angles is not None:
            output.SetFromVector(angles)

    def remember(self, context, values):
        self.update()


class Sensor(LeafSystem):
    """Reads zeros up to LATE, then what a function gives."""

    def __init__(self, layout, period, answer):
        super().__init__()
        self.answer, self.readings = answer, layout.readings
        self.DeclareVectorInputPort("joint_angles", layout.finger.segments)
        self.DeclareStateOutputPort("strain", self.DeclareDiscreteState(layout.readings))
        self.DeclareInitializationDiscreteUpdateEvent(self.sample)
        self.DeclarePeriodicDiscreteUpdateEvent(period, 0.0, self.sample)

    def sample(self, context, values):
        late = context.get_time() > LATE - 1e-9
        values.set_value(0, self.answer(self.readings) if late else np.zeros(self.readings))


def failing_estimator(layout, gravity, period):
    """What a scenario names."""
    return Estimator(layout, period, missing)


def refused(*overrides, **makers):
    """The error that a run with blocks of one's own ends in."""
    station = sg.make_station(free_bending([20e3], 0.2, *overrides), **makers)
    with pytest.raises(sg.InputError) as caught:
        sg.run_station(station)
    return caught.value


@pytest.mark.parametrize(
    ("answer", "said", "cause"),
    [
        (lambda n: np.full(n, np.nan), "is nan in entry 0", None),
        (lambda n: np.append(np.zeros(n - 1), np.inf), "is inf in entry 11", None),
        (lambda n: np.zeros(n - 1), "IndexError", IndexError),
        (lambda n: "text", "TypeError", TypeError),
        (boom, "RuntimeError: no calibration", RuntimeError),
        (missing, "KeyError: 'gain'", KeyError),
        (leave, "sys.exit(0) was called", SystemExit),
    ],
)
def test_an_answer_of_an_estimator(answer, said, cause):
    error = refused(make_estimator=lambda layout, gravity, period: Estimator(layout, period, answer))
    assert error.field == "estimator.type"
    assert error.value.startswith("test_own_blocks:test_an_answer_of_an_estimator")
    assert "left_finger: output port 'estimated_joint_angles', (12) rad" in error.expected
    assert f"at t = {LATE} s" in error.expected
    assert said in error.expected
    assert isinstance(error.__cause__, cause or type(None))


@pytest.mark.parametrize(
    ("answer", "said"),
    [
        (lambda n: np.full(n, np.nan), "is nan in entry 0"),
        (lambda n: np.zeros(n + 1), "IndexError"),
        (lambda n: None, "TypeError"),
        (boom, "no calibration"),
        (leave, "sys.exit(0) was called"),
    ],
)
def test_an_answer_of_a_sensor(answer, said):
    """With errors that are added to its readings."""
    error = refused("sensor.errors={noise: 1e-4}", make_sensor=lambda layout, period: Sensor(layout, period, answer))
    assert error.field == "sensor.type"
    assert "left_finger: output port 'strain', (8)" in error.expected
    assert said in error.expected


@pytest.mark.parametrize(
    ("function", "said"),
    [
        (lambda readings, driving, gravity: None, "returned NoneType"),
        (lambda readings, driving, gravity: driving, "returned ndarray"),
        (lambda readings, driving, gravity: sg.estimators.ShapeEstimate(driving[..., 1:]), "(11,)"),
        (lambda readings, driving, gravity: sg.estimators.ShapeEstimate(np.zeros(12)), "(12,)"),
    ],
)
def test_a_function_that_gives_no_shape(function, said):
    with pytest.raises(sg.InputError) as caught:
        sg.make_station(
            free_bending([20e3], 0.1),
            make_estimator=lambda layout, gravity, period: sg.estimators.ShapeEstimator(function, layout, gravity),
        )
    assert caught.value.field == "function"
    assert "estimator.type = test_own_blocks:" in str(caught.value)
    assert said in caught.value.expected


def test_a_function_that_fails_for_all_samples_at_once():
    def single(readings, driving, gravity):
        if driving.ndim > 1 and len(driving) > 2:
            raise ValueError("one at a time")
        return sg.estimators.ShapeEstimate(driving)

    error = refused(
        make_estimator=lambda layout, gravity, period: sg.estimators.ShapeEstimator(single, layout, gravity)
    )
    assert error.field == "estimator.type"
    assert "ValueError: one at a time" in error.expected


@pytest.mark.slow
def test_nan_that_leads_the_state_out_of_the_numbers():
    """In a closed loop the estimator is named, and not the solver."""
    overrides = ("control.set_points=[0.06]", "control.hold=0.5")
    scenario = sg.load_scenario("tip_distance_steps", overrides)
    station = sg.make_station(
        scenario,
        make_estimator=lambda layout, gravity, period: Estimator(layout, period, lambda n: np.full(n, np.nan)),
    )
    with pytest.raises(sg.InputError) as caught:
        sg.run_station(station)
    assert caught.value.field == "estimator.type"
    assert f"is nan in entry 0 at t = {LATE} s" in caught.value.expected


def test_the_traceback_is_shown_on_request(tmp_path):
    arguments = ["run", "free_bending", "--set", "estimator.type=test_own_blocks:failing_estimator"]
    for override in SHORT:
        arguments += ["--set", override]
    plain = soft_gripper(*arguments, "--out", tmp_path / "plain")
    assert plain.code == 2
    assert len(plain.err.strip().splitlines()) == 1
    assert "estimator.type = 'test_own_blocks:failing_estimator'" in plain.err
    shown = soft_gripper(*arguments, "--out", tmp_path / "shown", "--traceback")
    assert shown.code == 2
    assert 'return {}["gain"]' in shown.err
    assert not (tmp_path / "plain" / "recording.nc").exists()
