"""Cells of a surface that is pressed, several forces on them, and what sensors leave uncertain."""

from types import SimpleNamespace

import numpy as np
import pytest
from fingers_in_space import bent_chain, by_way, sensors, yielding
from loaded_fingers import Push, torque_of
from scipy.optimize import nnls

from soft_gripper.estimators.contact import LinearizedResidual, SurfaceContact
from soft_gripper.estimators.contact_cells import SurfaceCells
from soft_gripper.estimators.mechanics import Mechanics
from soft_gripper.estimators.uncertainty import Uncertainty, uncertainty_of
from soft_gripper.fingers.spatial_chain import Loads, spatial_chain, torques
from soft_gripper.sensors.measurement import LinearReadings
from soft_gripper.sensors.pressure_errors import PressureErrors
from soft_gripper.sensors.sensor_layout import SensorLayout
from soft_gripper.sensors.strain_errors import StrainErrors

Z = np.array([0.0, 0.0, 1.0])
INNER, LEFT, OUTER, RIGHT = 1, 3, 5, 7
PLACE, LINK, FRICTION = 37, 9, 0.45
NORMALS = {INNER: (1, 0, 0), LEFT: (0, 1, 0), OUTER: (-1, 0, 0), RIGHT: (0, -1, 0), 2: (1, 1, 0), 6: (-1, -1, 0)}


def cells_of(layout, q):
    """Cells, and what a force on a point of the chosen link, (3,) each in its frame, changes of the values."""
    mechanics, A = Mechanics(layout, Uncertainty(friction=FRICTION)), layout.values_at(q)[1]
    finger, contact = layout.finger, SurfaceContact(mechanics)
    at, frame = bent_chain(finger, q), spatial_chain(finger).link_frames(np.array([LINK]))

    def changed(point, force):
        load = Loads(frame, point[None], (at.rotations[frame[0]] @ force)[None], np.zeros((1, 3)))
        return A @ (mechanics.compliance(q) * by_way(finger, torques(at, load)))

    return contact.surface, contact.cells(q, mechanics.bent_finger(q), A), changed


def pressed(finger, s, normal):
    """The middle of a face or edge in the frame of the chosen link, and half of the section, m."""
    section = finger.section(s)
    half = np.array([(section.inner_face - section.outer_face) / 2, section.width / 2, 0])
    middle = (section.inner_face + section.outer_face) / 2
    return np.sign(normal.round(6)) * half + np.array([middle, 0, s - finger.joint_arc_lengths[LINK - 1]]), half


@pytest.mark.parametrize("side", NORMALS)
def test_a_cell_changes_the_readings_as_its_force_does(shipped_finger, bent, side):
    """By torques of dead loads at the joints, one after the other; so do friction and another place."""
    layout = sensors(yielding(shipped_finger))
    surface, cells, changed = cells_of(layout, 0.05 * bent(36))
    number = np.flatnonzero((surface.side == side) & (surface.place == PLACE))[0]  # the smooth one
    assert surface.link[number] == LINK
    normal = np.array(NORMALS[side]) / np.linalg.norm(NORMALS[side])
    across = np.array([-normal[1], normal[0], 0.0])
    point, half = pressed(layout.finger, surface.arc_length[number], normal)
    expected = changed(point, -normal)
    np.testing.assert_allclose(cells.response[number], expected, rtol=1e-9, atol=1e-15)
    np.testing.assert_allclose(cells.deviations[number, 0], 0.01 * changed(point, Z), rtol=1e-9, atol=1e-15)
    step = layout.finger.length / (surface.place.max() + 1) / np.sqrt(12)
    width = 2 * np.abs(across) @ half / np.sqrt(12) * (side % 2)
    for moved, spread in ((step * Z, cells.deviations[number, 2]), (width * across, cells.deviations[number, 3])):
        np.testing.assert_allclose(spread, changed(point + moved, -normal) - expected, rtol=1e-9, atol=1e-15)


@pytest.mark.parametrize("side", [-1, 1])
def test_in_the_plane_cells_have_friction_of_any_size_along_the_finger(shipped_finger, bent, side):
    """A smooth one, and five between the ends of the cone, which are the likelier ones."""
    layout = SensorLayout(shipped_finger, 4)
    surface, cells, changed = cells_of(layout, bent(12) / 2)
    numbers, normal = np.flatnonzero((surface.side == side) & (surface.place == PLACE)), np.array([side, 0.0, 0.0])
    point, _ = pressed(shipped_finger, surface.arc_length[numbers[0]], normal)
    step = shipped_finger.length / 48 / np.sqrt(12)
    for number, rub in zip(numbers, (0.0, *np.linspace(-FRICTION, FRICTION, 5)), strict=True):
        expected = changed(point, rub * Z - normal)
        np.testing.assert_allclose(cells.response[number], expected, atol=1e-12)
        moved = changed(point + step * Z, -normal) - changed(point, -normal)
        np.testing.assert_allclose(cells.deviations[number, 1], moved, atol=1e-12)
    np.testing.assert_allclose(cells.prior[numbers] / cells.prior[numbers].sum(), [0.3, *0.7 * SHARES], rtol=1e-12)


SHARES = np.array([0.25, 0.5 / 3, 0.5 / 3, 0.5 / 3, 0.25])


def test_prior_and_places_of_the_cells(shipped_finger):
    for finger, sides in ((shipped_finger, [-1, 1]), (yielding(shipped_finger), list(range(1, 9)))):
        surface = SurfaceCells.from_finger(finger, finger.yields, 0.9)
        assert surface.prior.sum() == pytest.approx(1)
        assert (np.diff(surface.side) >= 0).all()
        assert sorted(set(surface.side)) == sides
        assert surface.arc_length.max() == finger.length
        assert surface.angle[surface.side == 1] == pytest.approx(0)
    assert surface.angle[surface.side == LEFT] == pytest.approx(np.pi / 2)
    assert surface.angle[surface.side == RIGHT] == pytest.approx(-np.pi / 2)


SMOOTH = 0.0101  # friction


@pytest.fixture(params=[4, 12, "space"])
def layout(request, shipped_finger):
    """Sections of a finger that only bends, and a finger that leaves its plane."""
    if request.param == "space":
        return sensors(yielding(shipped_finger), "four_faces_and_diagonal", 4)
    return SensorLayout(shipped_finger, request.param)


@pytest.fixture
def q(layout, bent):
    return np.append(bent(12) / 4, np.zeros(len(layout.straight) - 12))


def found(layout, q, s, forces, side=1, friction=0.45, std=0.01, noise=0.0):
    """What is found on a side, 1 the inner one and -1 the outer one, of forces (F) at places (F); of noise (K, S).

    `std` is that of the noise, as a share of what the largest force at the tip changes.
    """
    mechanics = Mechanics(layout, Uncertainty(friction=friction))
    contact, A = SurfaceContact(mechanics), layout.values_at(q)[1]

    def changed(*pushes):
        torque = sum(torque_of(layout.finger, q[:12], push) for push in pushes)
        return A @ (mechanics.compliance(q) * np.append(torque, np.zeros(len(q) - 12)))

    std = std * np.abs(changed(Push(layout.finger.length, 1.0))).max()
    residual = np.atleast_2d(changed(*map(Push, s, forces)) + std * noise)
    each = np.tile(q, (len(residual), 1))
    read, covariance = np.full(len(residual), float(len(A))), np.tile(std**2 * np.eye(len(A)), (len(residual), 1, 1))
    left = LinearizedResidual(each, mechanics.bent_finger(each), layout.values_at(each)[1], read, residual, covariance)
    explained, number = contact.explain(left), side if mechanics.is_planar or side > 0 else 5
    fits = [contact._fit_several_forces(k, number, explained) for k in range(len(residual))]
    fields = {name: np.squeeze([fit.fields[name] for fit in fits]) for name in fits[0].fields}
    torque = np.array([fit.torque for fit in fits])
    remaining = residual - torque * mechanics.compliance(q) @ A.T
    return SimpleNamespace(
        **fields, torque=torque, left=remaining, changed=changed, std=std, usual=mechanics.usual_force
    )


@pytest.mark.parametrize("side", [1, -1])
@pytest.mark.parametrize("places", [(0.5, 0.9), (0.6, 0.85), (0.45, 1.0)])
def test_sum_and_centre_of_two_forces_are_found(layout, q, side, places):
    s = np.array(places) * layout.finger.length
    fit = found(layout, q, s, [0.8 * side, 0.6 * side], side)
    assert fit.force == pytest.approx(1.4 * side, rel=0.06)
    assert fit.arc_length == pytest.approx(s @ [0.8, 0.6] / 1.4, abs=0.03 * layout.finger.length)
    assert abs(fit.force - 1.4 * side) < 2 * fit.force_std
    assert np.abs(fit.left).max() < fit.std, "the torque that is found explains the values"


def test_no_force_pulls(layout, q):
    """Forces on the other side are explained by none, whose place is none."""
    fit = found(layout, q, np.array([0.05, 0.1]), [0.8, 0.6], -1)
    assert fit.force == 0
    assert not fit.torque.any()
    assert not fit.vector.any()
    assert np.isnan(fit.arc_length)
    assert fit.force_std > 0


def test_uncertainty_is_that_of_the_forces_beside_each_other(layout, q):
    """Of what presses and the places beside it, by the information of prior and values; without friction.

    That of the sum and of the centre have the covariance between neighbours in them, which nearly cancels.
    """
    straight = 0 * q
    nearest, length = Uncertainty().nearest_contact, layout.finger.length
    s = (np.arange(48) + 0.5) / 48 * length
    s = s[s >= nearest * length]
    fit = found(layout, straight, s[[14]], [0.8], 1, SMOOTH, 0.02)
    units = np.array([fit.changed(Push(each, 1.0)) for each in s]).T
    rows = np.vstack([units / fit.std, np.eye(len(s)) / fit.usual])
    presses = nnls(rows, np.concatenate([0.8 * units[:, 14] / fit.std, np.zeros(len(s))]))[0] > 0
    near = np.convolve(presses, np.ones(3), "same") > 0
    part = units[:, near] / fit.std
    covariance = np.linalg.inv(part.T @ part + np.eye(near.sum()) / fit.usual**2)
    for std, weights in (
        (fit.force_std, np.ones(near.sum())),
        (fit.arc_length_std, (s[near] - fit.arc_length) / fit.force),
    ):
        assert std == pytest.approx(np.sqrt(weights @ covariance @ weights), rel=2e-3)


@pytest.mark.parametrize(
    ("errors", "field", "expected"),
    [
        ({"noise": 3e-3, "low_frequency_noise": 4e-3}, "reading", 5e-3),
        ({"quantization": 0.12**0.5}, "reading", 0.1),
        ({"gain_error": 0.03, "hysteresis": 0.04}, "gain", 0.05),
        ({"creep": 0.1}, "gain", 0.1),
        ({"offset": 2e-3}, "offset", 2e-3),
        ({"drift": 6e-3}, "drift", 6e-3 / 60**0.5),
    ],
)
def test_strain_errors_are_added_as_variances(errors, field, expected):
    found, usual = uncertainty_of(StrainErrors(**errors)), Uncertainty()
    assert getattr(found, field) == pytest.approx(expected, rel=1e-3)
    others = set(vars(usual)) - {field}
    assert {name: getattr(found, name) for name in others} == {name: getattr(usual, name) for name in others}


def test_pressure_errors_and_the_finger():
    found = uncertainty_of(None, PressureErrors(gain_error=0.06, offset=300.0, noise=400.0), 0.08)
    assert (found.pressure, found.bend_per_pressure) == (500.0, pytest.approx(0.1, rel=2e-3))


def test_a_share_of_a_bend_adds_its_variance():
    bends = LinearReadings(np.array([0.0, -0.5]), np.array([1e-4, 1e-4])).uncertain_by(0.04)
    np.testing.assert_allclose(bends.variance, [1e-4, 5e-4])
