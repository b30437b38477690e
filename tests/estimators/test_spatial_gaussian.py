"""The most probable shape in space: dense conditioning, the planar estimator, and fingers under known forces."""

from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from soft_gripper.errors import InputError
from soft_gripper.estimators.gaussian import GaussianShape, gain_of
from soft_gripper.estimators.mechanics import TIP_SHARE, SpatialMechanics, torque_covariance
from soft_gripper.estimators.shape_functions import SHAPE_FUNCTIONS, SPATIAL_FUNCTIONS, spatial_function
from soft_gripper.estimators.spatial_estimator import Places
from soft_gripper.estimators.spatial_gaussian import SpatialGaussianShape
from soft_gripper.estimators.uncertainty import Uncertainty, uncertainty_of
from soft_gripper.fingers.spatial_chain import Loads, posture, resting_positions, spatial_chain, torques, weights
from soft_gripper.scenario.schema import SensorConfig, StrainErrorsConfig
from soft_gripper.scenario.sensor_presets import sensor_layout, strain_errors
from soft_gripper.sensors.path_sensors import PathSensors, SensorPath
from soft_gripper.sensors.strain_errors import disturb

PAGE = Path(__file__).parents[2] / "docs" / "estimators.md"
WAYS = ("bending", "sideways", "twist")
GRAVITY = np.array([0.0, 0.0, 9.81])  # a finger that hangs points its +z down
FORCES = [(60e3, (0, 0.3, 0)), (120e3, (0, 0.3, 0)), (60e3, (-0.3, 0.3, 0))]  # Pa; N at the tip


@pytest.fixture
def spatial(shipped_finger):
    return replace(shipped_finger, yields=WAYS)


def sensors(finger, name="four_faces_and_diagonal", sections=2):
    return sensor_layout(finger, SensorConfig(layout=name, sections=sections))


def in_balance(finger, pressures, forces, drive=1.0):
    """Joint positions way after way, (..., D), of a hanging finger under forces at its tip, (..., 3) N."""
    chain = spatial_chain(finger)
    own, forces = weights(finger, chain, GRAVITY), np.asarray(forces, dtype=float)
    all_forces = np.concatenate([np.broadcast_to(own.forces, (*forces.shape[:-1], *own.forces.shape)),
                                 forces[..., None, :]], axis=-2)  # fmt: skip
    loads = Loads(
        np.append(own.frames, len(chain.ways)),
        np.concatenate([own.points, [[0, 0, finger.segment_length / 2]]]),
        all_forces,
        np.zeros_like(all_forces),
    )
    driving = chain.spread({"bending": np.asarray(drive)[..., None] * finger.pressure_torque(pressures)})
    q = resting_positions(chain, chain.spread(finger.stiffnesses), driving, loads)
    return q[..., np.argsort(chain.places(WAYS))]


def known_drive(finger, pressure, count=None):
    torque = np.append(finger.pressure_torque(pressure), np.zeros(2 * finger.segments))
    return torque if count is None else np.tile(torque, (count, 1))


def errors(finger, found, true):
    """Of tip, mm, and twist, degrees, (...)."""
    tip = Places(finger, WAYS)
    distance = np.linalg.norm((tip(found)[0] - tip(true)[0])[..., -1, :], axis=-1)
    twist = (found - true)[..., 2 * finger.segments :].sum(axis=-1)
    return 1e3 * distance, np.degrees(np.abs(twist))


def test_the_prior_of_a_straight_finger_is_that_of_the_plane_in_both_planes(spatial):
    mechanics, q = SpatialMechanics(sensors(spatial), Uncertainty()), np.zeros(3 * spatial.segments)
    N, compliance = spatial.segments, mechanics.compliance(q)
    covariance = mechanics.of_load(mechanics.posture(q), q) / np.outer(compliance, compliance)
    expected = torque_covariance(spatial, Uncertainty().load_pressure)
    for way in (0, 1):
        block = covariance[way * N : (way + 1) * N, way * N : (way + 1) * N]
        np.testing.assert_allclose(block, expected, rtol=1e-12, atol=1e-20)
    np.testing.assert_allclose(covariance[2 * N :], 0, atol=1e-20)


@pytest.mark.parametrize(("share", "difference"), [(1.0, 5e-3), (0.25, 1.5e-3)])
def test_a_finger_that_stays_in_its_plane_is_estimated_as_by_the_planar_one(shipped_finger, bent, share, difference):
    """Up to the prior, here that of the bent finger, there that of the straight one: less the less it is bent."""
    layout = PathSensors(shipped_finger, 2, paths=(SensorPath("outer", (-8.5e-3,), (0.0,)),))
    q = share * (0.01 * np.abs(bent(12)) + 0.02)
    readings, driving = layout.read(q), shipped_finger.pressure_torque(share * 30e3)
    planar = GaussianShape(layout)(readings, driving, 9.81 + 0j)
    found = SpatialGaussianShape(layout)(readings, driving, GRAVITY)
    np.testing.assert_allclose(found.q, planar.q, atol=difference * np.abs(planar.q).max())
    np.testing.assert_allclose(layout.matrix @ found.q, layout.matrix @ planar.q, rtol=1e-3)


def dense_covariance(finger, at, load_pressure):
    """Of the torques of a load, from unit forces at many places of every link, one after the other."""
    chain, ends = spatial_chain(finger), finger.link_ends
    base, cells = load_pressure * finger.pressure_gain.max(), 40
    found = np.zeros((len(chain.ways),) * 2)
    for link, (begin, end) in enumerate(pairwise(ends)):
        for z in (np.arange(cells) + 0.5) / cells * (end - begin):
            density = 3 * (1 - TIP_SHARE) * (end - begin) / cells / finger.length**3
            found += density * outer_products(chain, at, link, z)
    found += TIP_SHARE / finger.length**2 * outer_products(chain, at, finger.segments, ends[-1] - ends[-2])
    order = np.argsort(chain.places(WAYS))
    return base**2 * found[np.ix_(order, order)]


def outer_products(chain, at, link, z):
    frame = chain.beyond(np.array([link]))
    each = [torques(at, Loads(frame, np.array([[0, 0, z]]), unit[None], np.zeros((1, 3)))) for unit in np.eye(3)]
    return sum(np.outer(torque, torque) for torque in each)


def test_mean_and_covariance_are_those_of_dense_conditioning(spatial):
    """In information form, with numerical derivatives, linearized where the estimator was in its last pass."""
    layout, assumed = sensors(spatial), Uncertainty(reading=1e-3, bend_per_pressure=0.05, pressure=300.0)
    estimator = SpatialGaussianShape(layout, assumed)
    driving, true = known_drive(spatial, 60e3), in_balance(spatial, 60e3, (0, 0.3, 0))
    readings = layout.read(true) + 1e-3 * np.random.default_rng(3).standard_normal(layout.readings)
    found = estimator(readings, driving, GRAVITY)
    chain, N = spatial_chain(spatial), spatial.segments
    order, compliance = chain.places(WAYS), 1 / np.concatenate([spatial.stiffnesses[way] for way in WAYS])
    q = estimator.guess(*estimator.measured(readings), driving, GRAVITY)
    at = posture(chain, q[order])
    weight = torques(at, weights(spatial, chain, GRAVITY))[np.argsort(order)]
    free, gain = compliance * (driving + weight), np.append(spatial.pressure_gain, np.zeros(2 * N))
    prior = compliance[:, None] * dense_covariance(spatial, at, assumed.load_pressure) * compliance
    for known in (0.05 * compliance * driving, 300.0 * compliance * gain):
        prior += np.outer(known, known)
    prior += assumed.angle**2 * np.eye(3 * N)
    for _ in range(2):
        step = 1e-6 * np.eye(3 * N)
        H = np.stack([(layout.predict(q + dq) - layout.predict(q - dq)) / 2e-6 for dq in step], axis=-1)
        precision = np.linalg.inv(prior) + H.T @ H / 1e-6
        left = readings - layout.predict(q) + H @ (q - free)
        q = free + np.linalg.solve(precision, H.T @ left / 1e-6)
    np.testing.assert_allclose(found.q, q, atol=2e-5 * np.abs(q).max())
    expected = np.linalg.inv(precision)
    np.testing.assert_allclose(found.covariance, expected, atol=5e-4 * np.abs(expected).max())


@pytest.mark.parametrize("name", ["four_faces", "outer_pair_and_diagonals"])
@pytest.mark.parametrize(("pressure", "force"), FORCES)
def test_the_first_guess_is_near_enough_for_the_prior_to_be_linearized_there(spatial, name, pressure, force):
    """Ideal readings: the estimate is as near that of prior, weight and readings linearized about it as errors are."""
    layout, driving = sensors(spatial, name), known_drive(spatial, pressure)
    estimator, mechanics = SpatialGaussianShape(layout), SpatialGaussianShape(layout).mechanics
    readings = layout.read(in_balance(spatial, pressure, force))
    found, (measured, variance) = estimator(readings, driving, GRAVITY).q, estimator.measured(readings)
    q = found
    for _ in range(8):
        at, (predicted, H) = mechanics.posture(q), layout.linearized(q)
        free = mechanics.free(driving + mechanics.weight(at, GRAVITY))
        gain, _ = gain_of(H, mechanics.prior(at, q, driving), variance)
        q = free + gain @ (measured - predicted - H @ (free - q))
    tip, twist = errors(spatial, found, q)
    assert tip < 0.5
    assert twist < 0.5


def pushed_sideways(finger, name, sections=2):
    """Mean errors of tip, mm, and twist, degrees, of 200 draws of a noise of 0.1 %, for each of the forces."""
    layout, rng, found = sensors(finger, name, sections), np.random.default_rng(1), []
    estimate = SpatialGaussianShape(layout, Uncertainty(reading=1e-3))
    for pressure, force in FORCES:
        true = in_balance(finger, pressure, force)
        readings = layout.read(true) + 1e-3 * rng.standard_normal((200, layout.readings))
        shape = estimate(readings, known_drive(finger, pressure, 200), GRAVITY)
        found.append([error.mean() for error in errors(finger, shape.q, true)])
    return np.array(found)


@pytest.mark.parametrize("name", ["four_faces_and_diagonal", "outer_pair_and_diagonals"])
def test_slanted_paths_fix_tip_and_twist_of_a_finger_that_is_pushed_sideways(spatial, name):
    assert pushed_sideways(spatial, name).max() < 0.7


@pytest.mark.parametrize(
    ("name", "sections", "row"),
    [
        *((name, 2, f"| `{name}` |") for name in ("four_faces", "outer_pair_and_diagonals", "four_faces_and_diagonal")),
        ("outer_pair_and_diagonals", 1, "| `outer_pair_and_diagonals`, one section"),
    ],
)
def test_errors_are_those_that_are_printed(spatial, name, sections, row):
    page = PAGE.read_text(encoding="utf-8")
    table = page[page.index("| tip error [mm] / twist error") :].split("\n\n")[0]
    (line,) = (line for line in table.splitlines() if line.startswith(row))
    printed = [[float(number) for number in cell.split("/")] for cell in line.split("|")[2:-1]]
    np.testing.assert_allclose(pushed_sideways(spatial, name, sections), printed, atol=0.051)


@pytest.mark.parametrize("stiffness", [0.9, 1.1])
def test_realistic_sensors_on_a_finger_of_another_stiffness(spatial, stiffness):
    preset = strain_errors(SensorConfig(errors=StrainErrorsConfig(preset="realistic")))

    def stiffer(section):
        return replace(section, youngs_modulus=stiffness * section.youngs_modulus)

    layout, nominal = sensors(spatial), sensors(spatial.with_sections(stiffer))
    estimate, rng, tips = (
        SpatialGaussianShape(nominal, uncertainty_of(preset, finger=0.1)),
        np.random.default_rng(2),
        [],
    )
    for pressure, force in FORCES:
        true = in_balance(spatial, pressure, force)
        motion = np.append(np.linspace(0, 1, 50), np.ones(50))[:, None, None] * true
        read = disturb(preset, np.repeat(layout.ratios(motion), 50, axis=1), 0.05, rng)[-1] - 1
        tips.append(errors(spatial, estimate(read, known_drive(spatial, pressure, 50), GRAVITY).q, true)[0])
    assert np.mean(tips) < 2.5


def test_bands_cover_what_they_promise_where_errors_are_as_assumed(spatial):
    """95.4 % within two standard deviations: loads, noise, and deviations of the drive drawn as they are assumed."""
    rng, draws, pressure, load_pressure = np.random.default_rng(5), 300, 60e3, 20e3
    layout = sensors(spatial)
    assumed = Uncertainty(reading=1e-3, bend_per_pressure=0.02, load_pressure=load_pressure, angle=1e-6)
    force = load_pressure * spatial.pressure_gain.max() / spatial.length
    drive = 1 + assumed.bend_per_pressure * rng.standard_normal(draws)
    true = in_balance(spatial, pressure, force * np.sqrt(TIP_SHARE) * rng.standard_normal((draws, 3)), drive)
    readings = layout.read(true) + assumed.reading * rng.standard_normal((draws, layout.readings))
    found = SpatialGaussianShape(layout, assumed)(readings, known_drive(spatial, pressure, draws), GRAVITY)
    places, _, moves = Places(spatial, WAYS)(found.q)
    moves = np.swapaxes(moves[..., -1, :], -1, -2)  # of the tip
    tip_std = np.sqrt(((moves @ found.covariance) * moves).sum(axis=-1))
    difference = places[..., -1, :] - Places(spatial, WAYS)(true)[0][..., -1, :]
    across = np.abs(difference) < 2 * tip_std
    N = spatial.segments
    twist_std = np.sqrt(found.covariance[..., 2 * N :, 2 * N :].sum(axis=(-2, -1)))
    twist = np.abs((found.q - true)[..., 2 * N :].sum(axis=-1)) < 2 * twist_std
    assert all(0.92 <= share <= 0.99 for share in (*across.mean(axis=0), twist.mean()))


def test_places_move_as_joints_do(spatial, bent):
    places, q, step = Places(spatial, WAYS), 0.1 * bent(36), 1e-6
    differences = [(places(q + dq)[0] - places(q - dq)[0]) / (2 * step) for dq in step * np.eye(36)]
    np.testing.assert_allclose(places(q)[2], differences, atol=1e-9)


def test_a_reading_that_is_lost_is_left_out(spatial):
    layout, true = sensors(spatial, "four_faces_and_diagonal"), in_balance(spatial, 60e3, (0, 0.3, 0))
    readings = layout.read(true)
    readings[3] = np.nan
    found = SpatialGaussianShape(layout)(readings, known_drive(spatial, 60e3), GRAVITY)
    tip, twist = errors(spatial, found.q, true)
    assert (tip < 0.7, twist < 0.7) == (True, True)


@pytest.mark.parametrize("name", [name for name in SHAPE_FUNCTIONS if name not in SPATIAL_FUNCTIONS])
def test_estimators_of_the_plane_say_so(spatial, name):
    with pytest.raises(InputError) as error:
        spatial_function(name, sensors(spatial), Uncertainty())
    assert (error.value.field, error.value.value) == ("type", name)
