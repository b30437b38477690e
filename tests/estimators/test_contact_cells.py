"""Cells of the surface that may be pressed: what forces there change of the readings, and how likely they are."""

import numpy as np
import pytest
from fingers_in_space import bent_chain, by_way, sensors, yielding
from loaded_fingers import Push, torque_of

from soft_gripper.estimators.contact import SurfaceContact
from soft_gripper.estimators.contact_cells import SurfaceCells
from soft_gripper.estimators.mechanics import Mechanics
from soft_gripper.estimators.uncertainty import Uncertainty
from soft_gripper.fingers.spatial_chain import Loads, spatial_chain, torques
from soft_gripper.sensors.sensor_layout import SensorLayout

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


def test_a_contact_as_long_as_a_link_lies_on_two(shipped_finger):
    """Its lever at the joint below its middle is an eighth of its length, which a force on one link does not have."""
    layout, q = SensorLayout(shipped_finger, 4), np.zeros(12)
    surface, cells, _ = cells_of(layout, q)
    for joint in (3, 5, 8):
        middle = shipped_finger.joint_arc_lengths[joint]
        spread = middle + shipped_finger.segment_length * (np.arange(100) + 0.5) / 100
        spread -= shipped_finger.segment_length / 2
        torque = np.mean([torque_of(shipped_finger, q, Push(s, 1.0)) for s in spread], axis=0)
        more = torque - torque_of(shipped_finger, q, Push(middle, 1.0))
        chosen = np.flatnonzero((surface.place == int(middle / shipped_finger.length * 48)) & (surface.side == 1))
        levers, expected = cells.deviations[chosen, -1], layout.sums(more / shipped_finger.stiffness)
        assert np.abs(levers[0]).max() == 0  # of a contact on one link
        for lever in levers[1:]:
            np.testing.assert_allclose(np.abs(lever), np.abs(expected), rtol=0.5, atol=1e-9)


def test_a_finger_in_space_is_pressed_on_its_inner_and_outer_face_as_one_that_only_bends(shipped_finger, bent):
    """By smooth forces; the sides alone know that it leaves its plane."""
    q = bent(12) / 4
    (plane, cells, _), (space, others, _) = (
        cells_of(sensors(finger, "four_faces"), np.append(q, np.zeros(12 * (len(finger.yields) - 1))))
        for finger in (shipped_finger, yielding(shipped_finger))
    )
    for side, same in ((1, INNER), (-1, OUTER)):
        chosen = (plane.side == side) & ~plane.rough & (plane.arc_length < shipped_finger.length)
        other = (space.side == same) & ~space.rough & (space.arc_length < shipped_finger.length)
        np.testing.assert_allclose(others.response[other], cells.response[chosen], rtol=1e-9, atol=1e-15)
        np.testing.assert_allclose(others.deviations[other, 2], cells.deviations[chosen, 1], rtol=1e-9, atol=1e-15)
