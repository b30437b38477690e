"""Predicted errors: the covariance of the estimator, dense conditioning, and errors that are made in statics."""

import numpy as np
import pytest

from soft_gripper.estimators.mechanics import SpatialMechanics
from soft_gripper.estimators.spatial_estimator import Places
from soft_gripper.estimators.spatial_gaussian import SpatialGaussianShape
from soft_gripper.estimators.uncertainty import Uncertainty, uncertainty_of
from soft_gripper.extras.placement.catalogue import CURVATURE, ORIENTATION, STRAIN, Design, errors_of
from soft_gripper.extras.placement.push_finder import PushFinder
from soft_gripper.extras.placement.samples import Assumptions
from soft_gripper.extras.placement.spatial_scores import Scores, push_prior
from soft_gripper.extras.placement.spatial_trials import made_errors
from soft_gripper.scenario.schema import SensorConfig
from soft_gripper.scenario.sensor_presets import strain_errors

FACES = ("inner", "outer", "left", "right", "outer_rising")
DESIGNS = [
    Design(STRAIN, (0.5,), FACES),
    Design(STRAIN, (0.1667, 0.5833), ("outer_rising", "outer_falling")),
    Design(CURVATURE, (0.25, 0.5, 0.75)),
    Design(ORIENTATION, (0.3333, 0.6667)),
]
ASSUMED = Uncertainty(reading=2e-3, gain=0.01, bend_per_pressure=0.1)


@pytest.mark.parametrize("design", DESIGNS, ids=str)
def test_pose_variance_is_the_covariance_of_the_estimator(spatial_tasks, design):
    """In free bending, where it linearizes at the true shape as the scores do."""
    scores, layout = Scores(spatial_tasks, design.kind, ASSUMED), design.layout(spatial_tasks.statics.finger)
    q, free = spatial_tasks.q, ~spatial_tasks.is_pushed
    shape = SpatialGaussianShape(layout, ASSUMED)(layout.read(q), spatial_tasks.driving, spatial_tasks.statics.gravity)
    moves = np.swapaxes(Places(layout.finger, layout.ways)(shape.q)[2][..., -1, :], -1, -2)
    tip = ((moves @ shape.covariance) * moves).sum(axis=-1)
    twist = shape.covariance[:, 24:, 24:].sum(axis=(-1, -2))
    expected = np.concatenate([tip, twist[:, None]], axis=-1)[free]
    np.testing.assert_allclose(scores.pose_variance(scores.seen(design))[free], expected, rtol=0.01)


@pytest.mark.parametrize("design", DESIGNS, ids=str)
def test_pose_variance_is_that_of_dense_conditioning(spatial_tasks, design):
    """In every task, in information form, by readings and places whose slopes are differences."""
    scores, layout = Scores(spatial_tasks, design.kind, ASSUMED), design.layout(spatial_tasks.statics.finger)
    mechanics = SpatialMechanics(layout, ASSUMED)
    places, step = Places(layout.finger, layout.ways), 1e-6 * np.eye(36)
    expected = []
    for q, driving in zip(spatial_tasks.q, spatial_tasks.driving, strict=True):
        prior = mechanics.prior(mechanics.posture(q), q, driving)
        H = np.stack([(layout.predict(q + dq) - layout.predict(q - dq)) / 2e-6 for dq in step], axis=-1)
        variance = ASSUMED.reading**2 + (ASSUMED.gain * layout.predict(q)) ** 2
        covariance = np.linalg.inv(np.linalg.inv(prior) + H.T @ (H / variance[:, None]))
        tip = np.stack([(places(q + dq)[0][-1] - places(q - dq)[0][-1]) / 2e-6 for dq in step], axis=-1)
        expected.append([*np.diag(tip @ covariance @ tip.T), covariance[24:, 24:].sum()])
    np.testing.assert_allclose(scores.pose_variance(scores.seen(design)), expected, rtol=1e-3)


def test_push_variance_is_that_of_dense_conditioning(spatial_tasks):
    """Of push, drive and deviations of all joints together, by readings whose slopes are differences."""
    design = DESIGNS[0]
    layout, statics = design.layout(spatial_tasks.statics.finger), spatial_tasks.statics
    scores, pushed, k = Scores(spatial_tasks, STRAIN, ASSUMED), spatial_tasks.pushed, 7
    q, std = pushed.q[k], push_prior(statics.finger, ASSUMED)
    response = statics.response(q, pushed.driving[k], type(pushed.push)(*(part[k] for part in pushed.push)))
    step = 1e-6 * np.eye(36)
    H = np.stack([(layout.predict(q + dq) - layout.predict(q - dq)) / 2e-6 for dq in step], axis=-1)
    slopes = np.concatenate([H @ response.slopes, H], axis=-1)
    variance = ASSUMED.reading**2 + (ASSUMED.gain * layout.predict(q)) ** 2
    precision = np.diag(1 / np.append(std, np.full(36, ASSUMED.angle)) ** 2) + slopes.T @ (slopes / variance[:, None])
    covariance = np.linalg.inv(precision)[:5, :5]
    across = statics.across(q, pushed.push.s[k])
    expected = [*np.diag(across @ covariance[:3, :3] @ across.T), covariance[3, 3]]
    np.testing.assert_allclose(scores.push_variance(scores.seen(design))[k], expected, rtol=1e-4)


def test_sensors_that_are_added_never_harm(spatial_tasks):
    scores = Scores(spatial_tasks, STRAIN, ASSUMED)
    found = np.array([scores(Design(STRAIN, (0.5,), FACES[:count])) for count in range(1, 6)])
    assert np.all(np.diff(found, axis=0) < 1e-12)


def test_a_push_is_found_by_exact_sensors(spatial_tasks):
    """All of it, if the readings are known to be exact, and the finger too."""
    design, pushed = Design(CURVATURE, (0.1667, 0.3333, 0.5, 0.75)), spatial_tasks.pushed
    layout, exact = design.layout(pushed.statics.finger), Uncertainty(reading=1e-7, angle=1e-9, bend_per_pressure=1e-6)
    found = PushFinder(layout, pushed.statics, exact)(layout.read(pushed.q), pushed.pressures)
    across = pushed.statics.across(pushed.q, pushed.push.s)
    np.testing.assert_allclose((across @ (found[:, :3] - pushed.push.force)[..., None]), 0, atol=1e-4)
    np.testing.assert_allclose(found[:, 3:5], np.stack(pushed.push[1:], axis=-1), atol=1e-4)


@pytest.mark.slow
@pytest.mark.parametrize("design", DESIGNS, ids=str)
def test_predicted_errors_are_those_that_realistic_sensors_make(spatial_tasks, design):
    """Within a factor of two, but for the twist: `gaussian` does not expect as much as a push at the edge makes."""
    errors = strain_errors(SensorConfig(errors=errors_of(design.kind, "realistic")))
    assumed = uncertainty_of(errors, finger=0.1)
    predicted = Scores(spatial_tasks, design.kind, assumed)(design)
    nominal = Assumptions(nominal_error=10.0).nominal(spatial_tasks.statics.finger)
    made = made_errors(design, spatial_tasks, nominal, errors, assumed, np.random.default_rng(1))
    ratio = np.array(made) / predicted
    assert np.all(ratio[[0, 2, 3]] > 0.5)
    assert np.all(ratio[[0, 2, 3]] < 2)
    assert 0.5 < ratio[1] < 4
