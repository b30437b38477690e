"""What presses on a finger, from patches that are made up: which count, with which sign, and where."""

import numpy as np
import pytest
from pydrake.geometry import GeometryId
from pydrake.math import RigidTransform, RollPitchYaw
from pydrake.multibody.tree import BodyIndex

from soft_gripper.truth.contact import (
    FingerContacts,
    Patch,
    TouchedLinks,
    contact_signals,
    contact_width,
    finger_contacts,
    links_by_geometry,
    object_grip,
    patch_table,
)

ONE, TWO, OTHER, THING = (GeometryId.get_new_id().get_value() for _ in range(4))
FINGER = TouchedLinks([BodyIndex(2), BodyIndex(0)], [[ONE], [TWO]], [0.0, 0.05])
NEIGHBOUR = TouchedLinks([BodyIndex(1)], [[OTHER]], [0.0])
TURNED = RigidTransform(RollPitchYaw(0.4, -0.5, 1.1), [1, 2, 3])
POSES = [TURNED, RigidTransform(), RigidTransform()]  # of the second link, of the neighbour, of the first link
X, Y, Z = np.eye(3)


LINKS = links_by_geometry([FINGER, NEIGHBOUR])


def patch(first, second, center, normal, force, torque=(0, 0, 0)):
    """The normal may be of any length."""
    vectors = (np.array(vector, dtype=float) for vector in (center, 2e-4 * np.array(normal), force, torque))
    return Patch((first, second), *vectors)


def over_time(samples, finger=FINGER):
    """Signals of a finger from the patches of several samples."""
    tables = [patch_table(found, LINKS, POSES) for found in samples]
    sample = np.repeat(np.arange(len(tables)), [len(table) for table in tables])
    contacts = finger_contacts(np.concatenate(tables), sample, np.full(len(tables), True))
    return contact_signals(contacts.select([FINGER, NEIGHBOUR].index(finger)), len(finger.bodies), finger.only_bends)


def signals(*found, finger=FINGER):
    return {name: value[0] for name, value in over_time([found], finger).items()}


def test_what_presses_on_the_inner_side_is_positive_whichever_shape_comes_first():
    """It pushes along -x of the link; friction along z counts in the total alone."""
    for first, second, sign in ((ONE, THING, 1), (THING, ONE, -1)):
        found = signals(patch(first, second, [0.01, 0, 0.004], X, sign * np.array([-3.0, 0, 4.0])))
        np.testing.assert_allclose(found["link_normal_force"], [3, 0])
        np.testing.assert_allclose(found["link_contact_force"], [5, 0])
        assert (found["true_contact_force"], found["true_contact_total"], found["normal_force"]) == (3, 5, 3)
        assert found["true_contact_arc_length"] == pytest.approx(0.004)
        np.testing.assert_array_equal(found["contact_center"], [0.01, 0, 0.004])


def test_a_link_that_is_turned_has_its_own_axes():
    """On the outer side, 4 mm beyond the frame of a link that begins at 50 mm; across it and along y."""
    R = TURNED.rotation()
    found = signals(patch(TWO, THING, TURNED @ [-0.01, 0.002, 0.004], R @ -X, R @ [2.0, 1.0, 0]))
    np.testing.assert_allclose(found["link_normal_force"], [0, -2])
    assert found["true_contact_arc_length"] == pytest.approx(0.054)
    assert found["normal_force"] == pytest.approx(2)


def test_the_transverse_force_is_at_right_angles_to_the_line_from_the_base():
    """That of two patches is of their sum and their mean place on the axis; y does not count if the finger bends."""
    near, far = (patch(ONE, THING, [0.01, 0, z], X, force) for z, force in ((0.02, [-3.0, 2, 4]), (0.04, [-3.0, 2, 4])))
    assert signals(near)["true_transverse_force"] == pytest.approx(3)
    assert signals(near, far)["true_transverse_force"] == pytest.approx(6)
    force, lever = TURNED.rotation() @ np.array([2.0, 0, 1.0]), TURNED @ np.array([0.0, 0, 0.004])
    bent = patch(TWO, THING, TURNED @ [-0.01, 0.002, 0.004], X, force)
    table = patch_table([bent], LINKS, POSES)
    in_space = finger_contacts(table, np.zeros(1, int), np.array([True])).transverse_force(only_bends=False)
    assert in_space == pytest.approx(np.linalg.norm(np.cross(lever, force)) / np.linalg.norm(lever))
    in_plane = TURNED.inverse().multiply(np.zeros(3))[[2, 0]] * [-1, -1] + [0.004, 0]  # from the base, along z and x
    assert signals(bent)["true_transverse_force"] == pytest.approx(
        abs(in_plane[0] * 2 - in_plane[1] * 1) / np.hypot(*in_plane)
    )


def test_forces_of_both_sides_cancel_and_places_count_by_their_sizes():
    inner, outer = (patch(ONE, THING, [0, 0, z], X, [f, 0, 0]) for z, f in ((0.01, -3.0), (0.03, 1.0)))
    found = signals(inner, outer)
    assert (found["true_contact_force"], found["true_contact_total"]) == (2, 4)
    assert found["true_contact_arc_length"] == pytest.approx((3 * 0.01 + 0.03) / 4)
    np.testing.assert_allclose(found["contact_center"], [0, 0, 0.015])


def test_only_what_is_outside_presses_on_a_finger():
    found = signals(patch(ONE, TWO, X, X, [50, 0, 0]), patch(THING, OTHER, X, X, [7, 0, 0]))
    for name, value in signals().items():
        np.testing.assert_array_equal(found[name], value)


def test_the_pressure_of_a_surface_acts_in_its_centre():
    """5 N along x, 2 mm beside the place of the patch: a torque of 10 mN m about it; and friction."""
    place, lever = np.array([0.01, 0, 0.02]), np.array([0, 0, 0.002])
    force = np.array([-5.0, 1.0, 0])
    found = signals(patch(ONE, THING, place, X, force, np.cross(lever, [-5.0, 0, 0])))
    np.testing.assert_allclose(found["contact_center"], place + lever, rtol=1e-12)
    assert found["true_contact_arc_length"] == pytest.approx(0.022)
    assert found["normal_force"] == pytest.approx(5)


def test_the_force_is_a_vector_in_the_world_with_friction():
    """Of either shape that comes first, and of all links, the turned one too."""
    one, two = [-3.0, 0.5, 4.0], TURNED.rotation() @ [2.0, 1.0, 0]
    for sign, first, second in ((1, TWO, THING), (-1, THING, TWO)):
        found = signals(patch(ONE, THING, X, X, one), patch(first, second, Y, X, sign * two))
        np.testing.assert_allclose(found["true_contact_force_world"], one + two, rtol=1e-12)


@pytest.mark.parametrize("degrees", [0, 90, 180, -90, 40])
@pytest.mark.parametrize(("first", "second", "sign"), [(TWO, THING, 1), (THING, TWO, -1)])
@pytest.mark.parametrize("way", [1, -1])
def test_the_side_is_where_the_finger_is_pressed_around_its_link(degrees, first, second, sign, way):
    """Whichever way the normal points, and however the thing rubs along the surface."""
    angle = np.radians(degrees)
    R, out, along = TURNED.rotation(), [np.cos(angle), np.sin(angle), 0], [-np.sin(angle), np.cos(angle), 0]
    force = sign * (R @ (-2 * np.array(out) + 5 * np.array(along)))
    found = signals(patch(first, second, TURNED @ out, R @ (way * np.array(out)), force))
    assert np.cos(found["true_contact_side"] - angle) == pytest.approx(1, abs=1e-12)


def test_fingers_that_press_on_each_other_receive_opposite_forces():
    pressed = patch(ONE, OTHER, [0, 0, 0.01], X, [-2.0, 0, 0])
    assert signals(pressed)["true_contact_force"] == 2
    assert signals(pressed, finger=NEIGHBOUR)["true_contact_force"] == -2
    assert signals(pressed, finger=NEIGHBOUR)["normal_force"] == 2


def pressed_at(*places):
    """A contact of 1 N in every sample, by its centre and normal."""
    count = len(places)
    centers, normals = (np.array(vectors, dtype=float) for vectors in zip(*places, strict=True))
    numbers, ones = np.zeros(count, int), np.ones(count)
    return FingerContacts(
        np.full(count, True),
        *(np.arange(count), numbers, numbers, ones, centers, normals, ones, ones, ones, normals, normals[:, :2]),
        *(centers, normals),
    )


UNTOUCHED = FingerContacts(
    np.array([True]),
    *(*np.zeros((3, 0), int), np.zeros(0), *np.zeros((2, 0, 3)), *np.zeros((3, 0)), np.zeros((0, 3)), np.zeros((0, 2))),
    *np.zeros((2, 0, 3)),
)


def on_circle(count, radius, heights):
    """What fingers around a cylinder touch; normals may point either way."""
    out = [RollPitchYaw(0, 0, angle).ToRotationMatrix() @ X for angle in 2 * np.pi * np.arange(count) / count]
    centers = [radius * x + [1, 2, 3 + height] for x, height in zip(out, heights, strict=True)]
    return [pressed_at((center, (-1) ** i * x)) for i, (center, x) in enumerate(zip(centers, out, strict=True))]


@pytest.mark.parametrize("count", [2, 3, 4])
def test_width_of_a_cylinder_is_its_diameter(count):
    """However high each finger touches it."""
    assert contact_width(on_circle(count, 0.03, np.zeros(count))) == pytest.approx(0.06, rel=1e-12)
    assert contact_width(on_circle(count, 0.03, 0.01 * np.arange(count))) == pytest.approx(0.06, rel=1e-12)


def test_the_strongest_patch_gives_the_normal():
    weak, strong = patch(ONE, THING, X, Y, [0, 1.0, 0]), patch(ONE, THING, X, Z, [0, 0, 2.0])
    for found in ([weak, strong], [strong, weak]):
        table = patch_table(found, LINKS, POSES)
        np.testing.assert_allclose(finger_contacts(table, np.zeros(2, int), np.array([True])).main_normal, [Z])


def test_there_is_no_width_unless_two_fingers_or_more_all_touch():
    for contacts in ([], on_circle(1, 0.03, [0]), [*on_circle(2, 0.03, [0, 0]), UNTOUCHED]):
        assert np.isnan(contact_width(contacts))


BALL, CUBE = (GeometryId.get_new_id().get_value() for _ in range(2))


def held(number, *samples):
    """How the two fingers hold the ball (0) or the cube (1), from patches of several samples."""
    tables = [patch_table(found, LINKS, POSES, {BALL: 0, CUBE: 1}) for found in samples]
    sample = np.repeat(np.arange(len(tables)), [len(table) for table in tables])
    return object_grip(number, 2, np.concatenate(tables), sample, np.full(len(tables), True))


def test_an_object_is_held_by_what_touches_it_alone():
    """Two links of the one finger and one of the other, of which each comes first or second; in the second sample."""
    one, two = (patch(ONE, BALL, X, X, [-3.0, 0, 4.0]), patch(BALL, TWO, X, X, [2.0, 0, 1.0]))
    other = patch(BALL, OTHER, X, X, [-5.0, 0.5, 0])
    others = (patch(ONE, CUBE, X, X, [-1.0, 0, 0]), patch(TWO, THING, X, X, [-1.0, 0, 0]), patch(ONE, OTHER, X, X, X))
    found = held(0, [], [one._replace(area=2e-5, pressure=1e4), two._replace(area=1e-5, pressure=3e4), other, *others])
    np.testing.assert_array_equal(found.grip_normal_force, [[0, 0], [5, 5]])
    np.testing.assert_array_equal(found.grip_force[1], [[5, 0, -3], [-5, 0.5, 0]])
    np.testing.assert_array_equal(found.grip_friction_force[1], [[0, 0, -3], [0, 0.5, 0]])
    assert found.grip_area[1, 0] == pytest.approx(3e-5)
    assert found.grip_pressure[1, 0] == 3e4
    assert np.isnan([found.grip_area[1, 1], found.grip_pressure[1, 1]]).all()  # points touch
    np.testing.assert_array_equal(held(1, [], [*others]).grip_normal_force, [[0, 0], [1, 0]])
