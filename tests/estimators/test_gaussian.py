"""The most probable shape: what least squares over all that is unknown find, and an uncertainty that errors confirm.

Of fingers that only bend and of those that leave their plane.
"""

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from fingers_in_space import (
    DOWN,
    WAYS,
    balanced,
    bend_stds,
    driven,
    forces_along,
    load_covariance,
    polynomials,
    pushed,
    sensors,
    weight,
    yielding,
)
from loaded_fingers import in_balance
from scipy.stats import chi2

from soft_gripper.estimators.finger_shape import Places
from soft_gripper.estimators.gaussian import GaussianShape, condition
from soft_gripper.estimators.uncertainty import Uncertainty
from soft_gripper.fingers.finger_parts import ElasticLaw
from soft_gripper.fingers.spatial_chain import Loads
from soft_gripper.fingers.statics import free_bending_angles
from soft_gripper.sensors.sensor_layout import SensorLayout

PAGE = Path(__file__).parents[2] / "docs" / "estimators.md"
PRESSURE = 80e3  # Pa
ASKEW = np.array([2.0, -3.0, 9.0])  # m/s^2
IN_PLANE = {
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
FORCES = [(60e3, (0, 0.3, 0)), (120e3, (0, 0.3, 0)), (60e3, (-0.3, 0.3, 0))]  # Pa; N at the tip


@pytest.fixture(params=IN_PLANE.values(), ids=IN_PLANE)
def layout(request, shipped_finger):
    return SensorLayout(shipped_finger, **request.param)


@pytest.fixture(params=[*IN_PLANE, "four_faces_and_diagonal", "outer_pair_and_diagonals"])
def any_layout(request, shipped_finger):
    if request.param in IN_PLANE:
        return SensorLayout(shipped_finger, **IN_PLANE[request.param])
    return sensors(yielding(shipped_finger), request.param)


@pytest.fixture
def spatial(shipped_finger):
    return yielding(shipped_finger)


def estimated(layout, read, pressure=PRESSURE, gravity=(0.0, 0.0, 0.0), uncertainty=None):
    driving = driven(layout.finger, np.full(read.shape[:-1], pressure))
    return GaussianShape(layout, uncertainty or Uncertainty())(read, driving, np.array(gravity))


def least_squares(layout, read, pressure, gravity, assumed):
    """In information form, linearized as often, and from the same first guess, by differences of the values."""
    finger, shape = layout.finger, GaussianShape(layout, assumed)
    driving, D = driven(finger, pressure), layout.straight.size
    compliance = 1 / np.concatenate([finger.stiffnesses[way] for way in layout.deformations])
    values, variance = layout.values(read, assumed.reading)
    within_a_minute = assumed.reading**2 + assumed.offset**2 + 60 * assumed.drift**2
    variance = variance * within_a_minute / assumed.reading**2 + (assumed.gain * values) ** 2
    q = shape.guess(shape.read(read), driving, gravity)
    of_load = load_covariance(finger, q, assumed.load_pressure)
    prior = np.outer(compliance, compliance) * of_load
    changes = bend_stds(assumed)[:, None] * polynomials(finger)
    changes = [driven(finger, pressure, share) for share in changes]
    for known in (*changes, assumed.pressure * driven(finger, 1.0)):
        prior += np.outer(compliance * known, compliance * known)
    prior += assumed.angle**2 * np.eye(D)
    for _ in range(2):
        free = compliance * (driving + weight(finger, q, gravity))
        step = 1e-6 * np.eye(D)
        A = ((layout.values_at(q + step)[0] - layout.values_at(q - step)[0]) / 2e-6).T
        precision = np.linalg.inv(prior) + A.T @ (A / variance[:, None])
        left = values - layout.values_at(q)[0] + A @ (q - free)
        q = free + np.linalg.solve(precision, A.T @ (left / variance))
    return q, np.linalg.inv(precision)


def check(layout, read, assumed):
    q, covariance = least_squares(layout, read, PRESSURE, ASKEW, assumed)
    found = estimated(layout, read, gravity=ASKEW, uncertainty=assumed)
    np.testing.assert_allclose(found.q, q, rtol=0, atol=1e-6)
    np.testing.assert_allclose(found.covariance, covariance, rtol=0, atol=1e-6 * covariance.max())


@pytest.mark.parametrize("assumed", DOUBTS.values(), ids=DOUBTS)
def test_it_is_what_least_squares_find(any_layout, bent, assumed):
    check(any_layout, any_layout.read(bent(any_layout.straight.size) / 4 / len(any_layout.deformations)), assumed)


@pytest.mark.parametrize("name", ["four", "four_faces_and_diagonal"])
@pytest.mark.parametrize("lost", [[0], [1, 5], [0, 4, 3, 7]])
def test_it_is_what_least_squares_find_of_what_is_read(shipped_finger, bent, name, lost):
    """Of four sections in the plane, one path of a section, a whole one, two."""
    layout = SensorLayout(shipped_finger, 4) if name == "four" else sensors(yielding(shipped_finger), name)
    read = layout.read(bent(layout.straight.size) / 4 / len(layout.deformations))
    read[lost] = np.nan
    check(layout, read, Uncertainty())


@pytest.mark.parametrize("gravity", [(0, 0, 9.81), (-8.9, 0, -4.1), (3.0, 6.0, -7.0)])
@pytest.mark.parametrize("pressure", [-40e3, 150e3])
def test_free_bending_is_exact_however_gravity_pulls(any_layout, pressure, gravity):
    """But for readings of joints that do not bend alike, of which the sections have the mean; nearly, in space."""
    q, atol = pushed(any_layout.finger, pressure, gravity=gravity), 2e-6 if len(any_layout.deformations) == 1 else 3e-4
    np.testing.assert_allclose(estimated(any_layout, any_layout.read(q), pressure, gravity).q, q, rtol=0, atol=atol)


@pytest.mark.parametrize("law", [None, SOFTENING], ids=["linear", "softening"])
def test_where_nothing_is_read_the_finger_bends_freely_with_the_uncertainty_of_before(shipped_finger, law):
    layout = SensorLayout(replace(shipped_finger, elastic_law=law), 3)
    found = estimated(layout, np.full(6, np.nan), 30e3)
    free = free_bending_angles(layout.finger, np.array(30e3))
    np.testing.assert_allclose(found.q, free, rtol=0, atol=1e-6)
    mechanics = GaussianShape(layout).mechanics
    before = mechanics.prior(mechanics.bent_finger(free), free, layout.finger.pressure_torque(30e3))
    np.testing.assert_allclose(found.covariance, before, rtol=0, atol=1e-5 * before.max())


@pytest.mark.parametrize("pressure", [20e3, 150e3])
def test_free_bending_under_an_elastic_law_is_exact(shipped_finger, pressure):
    finger = replace(shipped_finger, elastic_law=SOFTENING)
    q = in_balance(finger, pressure, 9.81)
    for sections in (1, 2, 4):
        layout = SensorLayout(finger, sections)
        found = estimated(layout, layout.read(q), pressure, DOWN)
        np.testing.assert_allclose(found.q, q, rtol=0, atol=2e-5)


@pytest.mark.parametrize("name", ["unequal", "four", "four_faces_and_diagonal"])
def test_errors_are_as_large_as_they_are_said_to_be(shipped_finger, name):
    """The normalized squared errors of all joints over 200 draws have a mean within its 95 % of chi-squared.

    Forces along the finger and on its tip are drawn as they are assumed, and so are all other errors.
    """
    in_plane = name in IN_PLANE
    layout = SensorLayout(shipped_finger, **IN_PLANE[name]) if in_plane else sensors(yielding(shipped_finger), name)
    finger, rng, draws = layout.finger, np.random.default_rng(13), 200
    assumed = Uncertainty(load_pressure=2e4, pressure=500.0)
    frames, places, variances = forces_along(finger)
    usual = assumed.load_pressure * finger.pressure_gain.max() * np.sqrt(variances)[:, None]
    forces = usual * rng.standard_normal((draws, len(frames), 3))
    drive = 1 + bend_stds(assumed) * rng.standard_normal((draws, 3)) @ polynomials(finger)
    drive += assumed.pressure / PRESSURE * rng.standard_normal((draws, 1))
    q = balanced(finger, PRESSURE, Loads(frames, places, forces, np.zeros_like(forces)), drive)
    q += assumed.angle * rng.standard_normal(q.shape)
    read = layout.read(q) + assumed.reading * rng.standard_normal((draws, layout.readings))
    found = estimated(layout, read, uncertainty=assumed)
    error = q - found.q
    squares = (error * np.linalg.solve(found.covariance, error[..., None])[..., 0]).sum(axis=-1)
    low, high = chi2.ppf([0.025, 0.975], q.size) / draws
    assert low < squares.mean() < high


def errors(finger, found, true):
    """Of tip, mm, and twist, degrees, (...)."""
    tip = Places(finger, WAYS)
    distance = np.linalg.norm((tip(found)[0] - tip(true)[0])[..., -1, :], axis=-1)
    twist = (found - true)[..., 2 * finger.segments :].sum(axis=-1)
    return 1e3 * distance, np.degrees(np.abs(twist))


def pushed_sideways(finger, name, sections=2):
    """Mean errors of tip, mm, and twist, degrees, of 200 draws of a noise of 0.1 %, for each of the forces."""
    layout, rng, found = sensors(finger, name, sections), np.random.default_rng(1), []
    estimate = GaussianShape(layout, Uncertainty(reading=1e-3))
    for pressure, force in FORCES:
        true = pushed(finger, pressure, force)
        readings = layout.read(true) + 1e-3 * rng.standard_normal((200, layout.readings))
        shape = estimate(readings, driven(finger, np.full(200, pressure)), DOWN)
        found.append([error.mean() for error in errors(finger, shape.q, true)])
    return np.array(found)


@pytest.mark.parametrize(
    ("name", "sections", "expected"),  # mm of the tip, degrees of twist
    [
        ("four_faces", 2, (4.7, 6.6)),
        ("outer_pair_and_diagonals", 2, (0.4, 0.3)),
        ("four_faces_and_diagonal", 2, (0.5, 0.5)),
        ("outer_pair_and_diagonals", 1, (1.3, 0.5)),
    ],
)
def test_errors_with_noise_are_as_measured(spatial, name, sections, expected):
    """The page has the twist of straight paths, and the largest errors of layouts with diagonals."""
    np.testing.assert_allclose(pushed_sideways(spatial, name, sections)[1], expected, atol=0.051)


def test_the_page_states_errors_with_noise():
    (stated,) = re.findall(
        r"miss the twist by ([\d.]+) degrees; .* by at most ([\d.]+) degrees and ([\d.]+) mm",
        PAGE.read_text(encoding="utf-8"),
    )
    assert [float(number) for number in stated] == [6.6, 0.5, 1.3]


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
