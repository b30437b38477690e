"""Bands of a calibrated finger: where it was calibrated, and beyond, against an independent finger that stiffens."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from pydrake.systems.analysis import Simulator

from soft_gripper.array_block import ArrayBlock
from soft_gripper.diagrams.wiring.estimation import FingerEstimation
from soft_gripper.estimators.calibration_range import DISAGREEMENT, DISTANCE, FAR, CalibrationRange
from soft_gripper.estimators.contact import ContactShape
from soft_gripper.estimators.finger_shape import position_std
from soft_gripper.estimators.gaussian import GaussianShape
from soft_gripper.estimators.named_estimators import find_estimator
from soft_gripper.estimators.recursive import RecursiveShape
from soft_gripper.estimators.uncertainty import Uncertainty
from soft_gripper.extras.hardware.calibration import as_config
from soft_gripper.extras.hardware.fitted_range import nearest_distance
from soft_gripper.extras.hardware.free_bending import FreeBending, calibrate
from soft_gripper.fingers.kinematics import forward_kinematics
from soft_gripper.fingers.statics import resting_angles
from soft_gripper.scenario.calibration_file import CalibrationConfig, apply_calibration
from soft_gripper.sensors.sensor_layout import SensorLayout, extension_ratios
from soft_gripper.sensors.strain_errors import StrainErrors, disturb, draw

LEVELS = 0, 20, 40, 60, 80, 60, 40, 20, 0, 40, 80, 40, 0  # kPa, calibrated
BEYOND = 100, 120, 140, 150, 120, 100, 0
HELD, PERIOD, GRAVITY = 12, 0.05, 9.81j
DOWN_X = np.array([[0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0]])  # x of B along -z of the world
ERRORS = StrainErrors(hysteresis=0.01, gain_error=0.03, offset=0.005, noise=2e-3)
KNOWN = Uncertainty(reading=2e-3, gain=0.01, bend_per_pressure=0.01)


def bent(layout, levels, stiffens, seed):
    """Joint angles of a finger whose chamber gives the more than nominal the higher its pressure, and a recording."""
    pressure, hold = 1e3 * np.repeat(levels, HELD).astype(float), np.repeat(np.arange(len(levels)), HELD)
    hold[np.arange(len(hold)) % HELD < HELD // 3] = -1
    pull = np.full(pressure.shape, GRAVITY)
    q = resting_angles(layout.finger, pressure * (1 + stiffens * pressure / 150e3), pull)
    ratios = disturb(ERRORS, extension_ratios(layout, q), PERIOD, draw(np.random.default_rng(seed), (len(q), 4)))
    return q, FreeBending(PERIOD * np.arange(len(q)), pressure, pull, ratios, hold)


@pytest.fixture(scope="module")
def layout(shipped_finger):
    return SensorLayout(shipped_finger, 2)


@pytest.fixture(scope="module")
def nominal(layout):
    @cache
    def found(stiffens, seed):
        calibration = calibrate(layout, [bent(layout, LEVELS, stiffens, seed)[1]])
        return apply_calibration(layout, CalibrationConfig("", {layout.finger.name: as_config(layout, calibration)}))

    return found


def inputs(nominal, recording):
    """What estimators take: readings, driving torque, gravity."""
    gravity = np.column_stack([recording.gravity.imag, 0 * recording.pressure, recording.gravity.real])
    return nominal.response.curve.reading(recording.ratios), nominal.finger.pressure_torque(recording.pressure), gravity


def tips(finger, q):
    return forward_kinematics(q, finger.segment_length).points[:, -1]


@pytest.mark.parametrize(("stiffens", "seed"), [(0.0, 2), (0.15, 1), (-0.15, 1)])
def test_the_tip_is_in_its_band_where_the_finger_was_calibrated_and_beyond(layout, nominal, stiffens, seed):
    """Beyond, it is within the band of the same estimator without the states in fewer samples."""
    model = nominal(stiffens, seed)
    q, recording = bent(layout, (*LEVELS, *BEYOND), stiffens, seed)
    beyond, within = recording.pressure > 90e3, {}
    for states in (model.calibrated, None):
        estimate = GaussianShape(replace(model, calibrated=states), KNOWN)(*inputs(model, recording))
        std = position_std(model.finger, estimate.q, estimate.covariance)[:, -1]
        within[states is not None] = np.abs(tips(model.finger, estimate.q) - tips(model.finger, q)) <= 1.96 * std
    assert within[True][~beyond].mean() > 0.88
    assert within[True][beyond].mean() > 0.95
    assert within[True].mean() > within[False].mean()


def test_far_is_what_is_beyond_the_calibration(layout, nominal):
    model = nominal(0.15, 1)
    _, recording = bent(layout, (*LEVELS, *BEYOND), 0.15, 1)
    readings, driving, gravity = inputs(model, recording)
    far = model.calibrated.is_far(model.calibrated.distances(model.measured(readings), driving, gravity))
    assert far[recording.pressure > 90e3].mean() > 0.95
    assert far[recording.pressure < 90e3].mean() < 0.05


def test_a_finger_that_stiffens_is_hardly_taken_for_touched(layout, nominal):
    """Without the states its readings beyond the calibration often pass for a contact."""
    model = nominal(0.15, 1)
    _, recording = bent(layout, (*LEVELS, *BEYOND), 0.15, 1)
    rows = np.flatnonzero(recording.pressure > 90e3)[::4]
    samples = [each[rows] for each in inputs(model, recording)]
    touched = {
        states is not None: np.mean(ContactShape(replace(model, calibrated=states), KNOWN)(*samples).contact.force != 0)
        for states in (model.calibrated, None)
    }
    assert touched[True] < touched[False] / 2
    assert touched[False] > 0.4


def test_recursive_takes_no_finger_for_touched_that_is_beyond_its_calibration(layout, nominal):
    """Nor is it loaded as often as without the states; its tip is in its band throughout."""
    model = nominal(0.15, 1)
    q, recording = bent(layout, (*LEVELS, *BEYOND), 0.15, 1)
    given, beyond, found = inputs(model, recording), recording.pressure > 90e3, {}
    for states in (model.calibrated, None):
        shape = RecursiveShape(replace(model, calibrated=states), KNOWN, PERIOD)
        known = shape.over_time(*given)
        estimate = shape.estimate(known, given[1])
        std = position_std(model.finger, estimate.q, estimate.covariance)[:, -1]
        within = np.abs(tips(model.finger, estimate.q) - tips(model.finger, q)) <= 1.96 * std
        touched = estimate.contact.force[beyond] != 0
        found[states is not None] = within.mean(), known.loaded[beyond].mean(), touched.mean()
    assert found[True][0] > 0.93
    assert found[True][1] < 2 / 3 * found[False][1]
    assert found[True][2] < 0.05 < 0.5 < found[False][2]


def test_readings_of_a_sensor_that_was_set_anew_disagree_with_the_drive(layout, nominal):
    model = nominal(0.0, 2)
    _, recording = bent(layout, LEVELS, 0.0, 2)
    readings, driving, gravity = inputs(model, recording)
    states = model.calibrated

    def apart(shift):
        return nearest_distance(states.distances(model.measured(readings + shift), driving, gravity).agreement)

    assert apart(0.0) < states.disagreement < apart(np.array([0.0, 0.0, 0.02, 0.0]))


def test_the_block_says_what_the_states_say(layout, nominal):
    model = nominal(0.15, 1)
    block = CalibrationRange(model, model.calibrated, np.array([0.0, 0.0, -9.81]))
    context = block.CreateDefaultContext()
    _, recording = bent(layout, (140,), 0.15, 1)
    readings, driving, _ = (each[-1] for each in inputs(model, recording))
    given = {"strain": readings, "driving_torque": driving, "X_WB": np.column_stack([DOWN_X, np.zeros(3)]).ravel()}
    for name, value in given.items():
        block.GetInputPort(name).FixValue(context, value)
    gravity = DOWN_X.T @ [0.0, 0.0, -9.81]
    found = model.calibrated.distances(model.measured(readings), driving, gravity)
    out = {name: block.GetOutputPort(name).Eval(context) for name in (DISTANCE, FAR, DISAGREEMENT)}
    np.testing.assert_allclose(out[DISTANCE], [found.drive, *found.sections])
    assert out[FAR] == [1.0]
    assert np.isnan(out[DISAGREEMENT]), "no drive as large was calibrated"


def test_distances_are_those_of_the_readings_that_are_used(layout, nominal):
    """Sensors of an open finger that read too much are far from the calibration until they are zeroed, or rejected."""
    model, gravity = nominal(0.0, 2), np.array([0.0, 0.0, -9.81])
    readings = bent(layout, (0,), 0.0, 2)[1].ratios[-1]
    X_WB = np.column_stack([DOWN_X, np.zeros(3)]).ravel()
    given = {"strain": model.response.curve.reading(readings) + 0.05, "pressure": [0.0], "X_WB": X_WB}

    def distances(free_pressure, monitor=None):
        estimator = find_estimator("gaussian", replace(KNOWN, free_pressure=free_pressure))(model, gravity, PERIOD)
        estimation = FingerEstimation(estimator, model, gravity, PERIOD, monitor=monitor)
        simulator = Simulator(estimation)
        for name, value in given.items():
            estimation.GetInputPort(name).FixValue(simulator.get_mutable_context(), value)
        simulator.AdvanceTo(2.0)
        return estimation.GetOutputPort(DISTANCE).Eval(simulator.get_context())[1:]

    rejecting = ArrayBlock()
    rejecting.take("strain", layout.readings)
    rejecting.put_out("usable_strain", lambda readings: np.nan * readings, "strain", sensor=range(layout.readings))
    assert distances(0.0).min() > 1
    assert distances(2e3).max() < 0.3
    np.testing.assert_array_equal(distances(0.0, rejecting), 0.0)
