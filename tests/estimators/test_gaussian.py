"""The most probable shape: what least squares over all that is unknown find, and an uncertainty that errors confirm."""

from dataclasses import replace

import numpy as np
import pytest
from loaded_fingers import in_balance
from scipy.stats import chi2

from soft_gripper.estimators.gaussian import GaussianShape, condition
from soft_gripper.estimators.mechanics import torque_covariance
from soft_gripper.estimators.uncertainty import Uncertainty
from soft_gripper.fingers.finger_parts import ElasticLaw
from soft_gripper.fingers.statics import free_bending_angles
from soft_gripper.sensors.sensor_layout import SensorLayout, extension_ratios

PRESSURE = 80e3  # Pa
LAYOUTS = {
    "one": {"sections": 1},
    "four": {"sections": 4},
    "unequal": {"sections": 2, "borders": (1 / 3,)},
    "one-sided": {"sections": 3, "one_sided": True},
}
DOUBTS = {
    "default": Uncertainty(),
    "of pressure": Uncertainty(pressure=2e3, bend_per_pressure=0.0),
    "of the finger": Uncertainty(angle=5e-3, bend_per_pressure=0.05),
    "of the gains": Uncertainty(gain=0.1),
    "of the offsets": Uncertainty(offset=2e-3),
    "of the drift": Uncertainty(drift=3e-4),
}
SOFTENING = ElasticLaw((-40.0, -8.0, 8.0, 40.0), (-0.25, -0.1, 0.1, 0.25), (-0.22, -0.09, 0.09, 0.22))


@pytest.fixture(params=LAYOUTS.values(), ids=LAYOUTS)
def layout(request, shipped_finger):
    return SensorLayout(shipped_finger, **request.param)


def readings(layout, q):
    return layout.response.reading(extension_ratios(layout, q))


def estimated(layout, read, pressure=PRESSURE, gravity=0j, uncertainty=None):
    driving = layout.finger.pressure_torque(np.full(read.shape[:-1], pressure))
    return GaussianShape(layout, uncertainty or Uncertainty())(read, driving, gravity)


def least_squares(layout, read, assumed):
    """All that is unknown stacked, each of unit variance: load, pressure, joints; and the covariance of the joints.

    With no weight the problem is linear.
    """
    finger, (theta, variance) = layout.finger, layout.linear(read, assumed.reading)
    within_a_minute = assumed.reading**2 + assumed.offset**2 + 60 * assumed.drift**2
    variance = variance * within_a_minute / assumed.reading**2 + (assumed.gain * theta) ** 2
    load = np.linalg.cholesky(torque_covariance(finger, assumed.load_pressure))
    pressures = np.array([assumed.bend_per_pressure * PRESSURE, assumed.pressure])
    torques = np.hstack([load, np.outer(finger.pressure_gain, pressures)])
    to_joints = np.hstack([torques / finger.stiffness[:, None], assumed.angle * np.eye(finger.segments)])
    free = finger.pressure_gain * PRESSURE / finger.stiffness
    weights = 1 / np.sqrt(variance)
    rows = np.vstack([np.eye(to_joints.shape[1]), weights[:, None] * layout.sums(to_joints.T).T])
    right = np.concatenate([np.zeros(to_joints.shape[1]), weights * (theta - layout.sums(free))])
    unknown = np.linalg.lstsq(rows, right, rcond=None)[0]
    inverse = np.linalg.pinv(rows)
    return free + to_joints @ unknown, to_joints @ inverse @ inverse.T @ to_joints.T


def drawn(finger, assumed, rng):
    """Joint angles of a finger without weight, from what is assumed of load, pressure and joints."""
    load = rng.multivariate_normal(np.zeros(finger.segments), torque_covariance(finger, assumed.load_pressure))
    pressure = PRESSURE * (1 + assumed.bend_per_pressure * rng.standard_normal())
    pressure += assumed.pressure * rng.standard_normal()
    return finger.angle(pressure * finger.pressure_gain + load) + assumed.angle * rng.standard_normal(finger.segments)


@pytest.mark.parametrize("assumed", DOUBTS.values(), ids=DOUBTS)
def test_it_is_what_least_squares_find(layout, bent, assumed):
    read = readings(layout, bent(12) / 4)
    q, covariance = least_squares(layout, read, assumed)
    found = estimated(layout, read, uncertainty=assumed)
    np.testing.assert_allclose(found.q, q, rtol=0, atol=1e-10)
    np.testing.assert_allclose(found.covariance, covariance, rtol=0, atol=1e-8 * covariance.max())


@pytest.mark.parametrize("lost", [[0], [1, 5], [0, 4, 3, 7]])
def test_it_is_what_least_squares_find_of_what_is_read(shipped_finger, bent, lost):
    """One path of a section, a whole one, two."""
    layout = SensorLayout(shipped_finger, 4)
    read = readings(layout, bent(12) / 4)
    read[lost] = np.nan
    q, covariance = least_squares(layout, read, Uncertainty())
    found = estimated(layout, read)
    np.testing.assert_allclose(found.q, q, rtol=0, atol=1e-6)
    np.testing.assert_allclose(found.covariance, covariance, rtol=0, atol=1e-6 * covariance.max())


@pytest.mark.parametrize("direction", [0.0, 1.0, 2.5, -2.0])
@pytest.mark.parametrize("pressure", [-40e3, 0.0, 150e3])
def test_free_bending_is_exact_however_gravity_pulls(layout, pressure, direction):
    """But for readings of joints that do not bend alike, of which the sections have the mean."""
    gravity = 9.81 * np.exp(1j * direction)
    q = in_balance(layout.finger, pressure, gravity)
    found = estimated(layout, readings(layout, q), pressure, gravity)
    np.testing.assert_allclose(found.q, q, rtol=0, atol=2e-6)


def test_measured_bends_are_met_as_noise_goes_to_zero(layout, bent):
    read = readings(layout, bent(5, 12) / 4)
    theta = layout.linear(read, 1e-4).values
    errors = [
        np.abs(layout.sums(estimated(layout, read, uncertainty=Uncertainty(reading=noise)).q) - theta).max()
        for noise in (1e-1, 1e-3, 1e-5, 1e-7)
    ]
    assert sorted(errors, reverse=True) == errors
    assert errors[0] > 1e-2
    assert errors[-1] < 1e-9


@pytest.mark.parametrize("lost", [[0], [2, 6], [0, 4, 1, 5], list(range(8))])
def test_less_that_is_read_leaves_more_uncertain(shipped_finger, bent, lost):
    layout = SensorLayout(shipped_finger, 4)
    read = readings(layout, bent(12) / 4)
    whole = estimated(layout, read)
    read[lost] = np.nan
    part = estimated(layout, read)
    assert np.isfinite(part.q).all()
    more = np.linalg.eigvalsh(part.covariance - whole.covariance)
    assert more.min() > -1e-9 * np.abs(part.covariance).max()
    assert more.max() > 1e-12  # the inner path lies close to the neutral axis and says little


@pytest.mark.parametrize("law", [None, SOFTENING], ids=["linear", "softening"])
def test_where_nothing_is_read_the_finger_bends_freely_with_the_uncertainty_of_before(shipped_finger, law):
    layout = SensorLayout(replace(shipped_finger, elastic_law=law), 3)
    found = estimated(layout, np.full(6, np.nan), 30e3)
    free = free_bending_angles(layout.finger, np.array(30e3))
    np.testing.assert_allclose(found.q, free, rtol=0, atol=1e-6)
    before = GaussianShape(layout).mechanics.prior(free, free, layout.finger.pressure_torque(30e3))
    np.testing.assert_allclose(found.covariance, before, rtol=0, atol=1e-5 * before.max())


@pytest.mark.parametrize("pressure", [20e3, 150e3])
def test_free_bending_under_an_elastic_law_is_exact(shipped_finger, pressure):
    finger = replace(shipped_finger, elastic_law=SOFTENING)
    q = in_balance(finger, pressure, 9.81)
    for sections in (1, 2, 4):
        layout = SensorLayout(finger, sections)
        found = estimated(layout, readings(layout, q), pressure, 9.81)
        np.testing.assert_allclose(found.q, q, rtol=0, atol=2e-5)


def test_a_law_that_is_the_linear_spring_estimates_alike(shipped_finger, bent):
    finger = replace(shipped_finger, tip=shipped_finger.base)
    moment = finger.stiffness[0] * finger.segment_length
    law = ElasticLaw((-1.0, 1.0), (-moment, moment), (-moment, moment))
    linear, lawful = (SensorLayout(f, 3) for f in (finger, replace(finger, elastic_law=law)))
    read = readings(linear, bent(12) / 4)
    found = [estimated(layout, read, gravity=9.81) for layout in (linear, lawful)]
    np.testing.assert_allclose(found[0].q, found[1].q, atol=1e-13)
    np.testing.assert_allclose(found[0].covariance, found[1].covariance, atol=1e-15)


def test_where_a_law_is_softer_the_load_is_less_certain(shipped_finger):
    layout = SensorLayout(replace(shipped_finger, elastic_law=SOFTENING), 2)
    gaussian = GaussianShape(layout)
    little, much = (gaussian.mechanics.prior(*[np.full(12, angle)] * 2, np.zeros(12)) for angle in (0.01, 0.2))
    ratio = np.sqrt(np.diagonal(much) / np.diagonal(little))
    stiffness = layout.finger.joint_law.slopes
    np.testing.assert_allclose(ratio, stiffness[:, 1] / stiffness[:, 2], rtol=1e-2)


@pytest.mark.parametrize("sections", [{"sections": 2, "borders": (1 / 3,)}, {"sections": 4}], ids=["two", "four"])
def test_errors_are_as_large_as_they_are_said_to_be(shipped_finger, sections):
    """The normalized squared errors of 12 joints over 200 draws have a mean within its 95 % of chi-squared."""
    layout, rng, draws = SensorLayout(shipped_finger, **sections), np.random.default_rng(11), 200
    assumed = Uncertainty(load_pressure=5e4)
    q = np.array([drawn(shipped_finger, assumed, rng) for _ in range(draws)])
    read = readings(layout, q) + assumed.reading * rng.standard_normal((draws, layout.readings))
    found = estimated(layout, read, uncertainty=assumed)
    error = q - found.q
    squares = (error * np.linalg.solve(found.covariance, error[..., None])[..., 0]).sum(axis=-1)
    low, high = chi2.ppf([0.025, 0.975], 12 * draws) / draws
    assert low < squares.mean() < high


def test_condition_is_the_joint_gaussian_given_its_sections(shipped_finger, bent):
    """By the partitioned inverse of the covariance of joints and readings together."""
    layout, root = SensorLayout(shipped_finger, 3, borders=(0.25, 0.6)), bent(12, 12)
    covariance, variance = root @ root.T, np.array([1e-3, 2e-2, 5e-4])
    sums = (layout.joint_sections == np.arange(3)[:, None]).astype(float)
    read = sums @ covariance @ sums.T
    together = np.block([[covariance, covariance @ sums.T], [sums @ covariance, read + np.diag(variance)]])
    precision = np.linalg.inv(together)
    left = np.linalg.inv(precision[:12, :12])
    gain, after = condition(sums, covariance, variance)
    np.testing.assert_allclose(after, left, atol=1e-8)
    np.testing.assert_allclose(gain, -left @ precision[:12, 12:], atol=1e-8)


@pytest.mark.parametrize("law", [None, SOFTENING], ids=["linear", "softening"])
def test_a_batch_is_its_samples(shipped_finger, bent, law):
    layout = SensorLayout(replace(shipped_finger, elastic_law=law), 3)
    gaussian, read = GaussianShape(layout), readings(layout, bent(3, 2, 12) / 4)
    read[1, 1, 2] = np.nan
    driving, gravity = 0.05 * bent(3, 2, 12), 9.81 * np.exp(1j * bent(3, 2))
    found = gaussian(read, driving, gravity)
    for index in np.ndindex(3, 2):
        alone = gaussian(read[index], driving[index], complex(gravity[index]))
        np.testing.assert_allclose(found.q[index], alone.q, atol=1e-13)
        np.testing.assert_allclose(found.covariance[index], alone.covariance, atol=1e-15)
