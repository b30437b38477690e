"""Errors: distances of points, and bands that cover a normal error in 95 of 100 cases."""

import numpy as np
import pytest

from soft_gripper.estimators.estimate import ShapeEstimate
from soft_gripper.estimators.named_estimators import SHAPE_FUNCTIONS
from soft_gripper.estimators.recursive import RecursiveShape
from soft_gripper.estimators.uncertainty import Uncertainty
from soft_gripper.fingers.kinematics import forward_kinematics, in_space
from soft_gripper.sensors.sensor_layout import SensorLayout
from studies.robustness.rows import Errors, covered, errors_of, estimated, in_mm, together


def points(finger, q):
    return in_space(ShapeEstimate(q).points(finger))


def test_errors_are_distances(shipped_finger, bent) -> None:
    q = bent(3, 12)
    errors = errors_of(shipped_finger, ShapeEstimate(q), points(shipped_finger, q) + np.array([2e-3, 2e-3, 1e-3]))
    np.testing.assert_allclose(errors.pose, 3e-3)
    np.testing.assert_allclose(errors.tip, 3e-3)
    assert errors.covered.size == 0


def test_the_error_of_the_tip_is_that_of_the_tip_alone(shipped_finger, bent) -> None:
    q = bent(12)
    truth = points(shipped_finger, q).copy()
    truth[-1, 1] += 2e-3
    errors = errors_of(shipped_finger, ShapeEstimate(q), truth)
    assert (errors.pose.item(), errors.tip.item()) == pytest.approx((0.0, 2e-3))


@pytest.mark.parametrize(("scale", "share"), [(1.0, 0.95), (0.5, 0.67), (2.0, 1.0)])
def test_bands_cover_as_they_say(shipped_finger, bent, scale, share) -> None:
    """Of normal errors with a known covariance; of half that, 0.67, and of twice, nearly all."""
    rng, spread = np.random.default_rng(5), 1e-3 * bent(12, 12)
    q = np.full((4000, 12), 0.1)
    truth = points(shipped_finger, q + rng.standard_normal(q.shape) @ spread.T)
    covariance = np.broadcast_to(scale**2 * spread @ spread.T, (4000, 12, 12))
    found = covered(shipped_finger, ShapeEstimate(q, covariance), truth)
    assert found.shape == (4000, 12)
    assert found.mean() == pytest.approx(share, abs=0.015)


def test_only_what_is_across_the_finger_counts(shipped_finger) -> None:
    q = np.full(12, 0.1)
    chain, truth = forward_kinematics(q, shipped_finger.segment_length), points(shipped_finger, q)
    estimate = ShapeEstimate(q, 1e-6 * np.eye(12))
    assert covered(shipped_finger, estimate, truth + 0.01 * in_space(chain.directions)).all()
    assert not covered(shipped_finger, estimate, truth + 0.01 * in_space(chain.normals)).any()


def test_numbers_of_a_row() -> None:
    parts = [
        Errors(1e-3 * np.arange(51.0), np.zeros(51), np.array([True])),
        Errors(1e-3 * np.arange(51.0, 101), np.zeros(50), np.array([True, True, False])),
    ]
    assert in_mm(together(parts)) == pytest.approx((50.0, 95.0, 100.0, 0.75))
    skewed = in_mm(Errors(1e-3 * np.array([0, 0, 0, 0, 10.0]), np.zeros(5), np.array([True])))
    assert skewed == pytest.approx((2.0, 8.0, 10.0, 1.0))
    nothing = in_mm(Errors(np.ones(1), np.ones(1), np.zeros(0, bool)))
    assert np.isnan(nothing[-1])


@pytest.mark.parametrize("name", SHAPE_FUNCTIONS)
def test_estimators_are_compared_with_the_recording(held, name) -> None:
    """Four ideal sensors per side know a finger that bends freely, at every held sample and seed.

    Shortly after a step `recursive` takes what the finger still moves for a load, whose modes follow its posture.
    """
    errors = estimated(name, SensorLayout(held.simulated, 4), Uncertainty(), held, held.readings(4, None, 2))
    assert errors.pose.shape == errors.tip.shape == (2 * len(held.samples),)
    assert errors.pose.max() < (1.5e-3 if name == "recursive" else 5e-4)
    assert (errors.covered.size > 0) == (name not in ("arcs", "constant_curvature", "spline"))


@pytest.mark.parametrize(
    ("name", "misled"), [("arcs", False), ("spline", False), ("gaussian", True), ("contact", True)]
)
def test_a_pressure_that_is_read_too_high_misleads_who_uses_it(held, name, misled) -> None:
    layout, readings = SensorLayout(held.simulated, 1), held.readings(1, None, 1)
    right, wrong = (estimated(name, layout, Uncertainty(reading=1e-2), held, readings, gain) for gain in (1.0, 1.2))
    assert (wrong.tip.max() > right.tip.max() + 1e-3) == misled


def test_a_filter_goes_through_all_samples_whichever_are_wanted(held) -> None:
    layout, rows = SensorLayout(held.simulated, 2), held.samples
    function = RecursiveShape(layout, Uncertainty(), held.period)
    pressure, gravity = np.tile(held.pressure[:, None], (1, 2)), np.tile(held.gravity[:, None], (1, 2, 1))
    given = held.readings(2, None, 2), layout.finger.pressure_torque(pressure), gravity
    whole, some = function(*given), function.at(rows, *given)
    np.testing.assert_array_equal(some.q, whole.q[rows])
    np.testing.assert_array_equal(some.covariance, whole.covariance[rows])
