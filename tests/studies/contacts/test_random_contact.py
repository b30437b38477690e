"""Random contacts: which numbers are drawn, that each stands for itself, and what counts as a single contact."""

from dataclasses import replace

import numpy as np
import pytest

from studies.contacts.contacts import G
from studies.contacts.peg import (
    MIN_FORCE,
    PLACE,
    RADIUS,
    STILL,
    RandomContact,
    Settled,
    contact_flaw,
    draw_contact,
    run_contact,
)

LENGTH = 0.12  # m
DRAWN = RandomContact("outer", 5.0, 80.0, 50.0, 20.0, (1.0, 0.0, 0.0, 0.0))


def test_all_that_is_drawn_lies_in_its_range() -> None:
    drawn = [draw_contact(np.random.default_rng(i), LENGTH) for i in range(300)]
    assert {each.side for each in drawn} == {"inner", "outer"}
    assert {each.radius_mm for each in drawn} == set(range(RADIUS[0], RADIUS[1] + 1))
    places = np.array([each.place_mm for each in drawn]) / (1e3 * LENGTH)
    assert PLACE[0] <= places.min() < PLACE[0] + 0.02
    assert PLACE[1] - 0.02 < places.max() <= PLACE[1]
    for each in drawn:
        assert -50 <= each.pressure_kpa <= 150
        assert (each.pressure_kpa > each.touching_kpa) == (each.side == "inner")
        assert np.linalg.norm(each.orientation) == pytest.approx(1)


def test_gravity_points_any_way_in_and_out_of_the_bending_plane() -> None:
    gravity = np.array([draw_contact(np.random.default_rng(i), LENGTH).gravity for i in range(400)])
    np.testing.assert_allclose(np.linalg.norm(gravity, axis=-1), G)
    assert np.abs(gravity.mean(axis=0)).max() < 0.1 * G
    np.testing.assert_allclose((gravity**2).mean(axis=0), G**2 / 3, rtol=0.12)  # of a direction on the sphere


def test_gravity_of_a_base_that_stands_upright() -> None:
    np.testing.assert_allclose(DRAWN.gravity, [0, 0, -G], atol=1e-12)
    lying = replace(DRAWN, orientation=(np.sqrt(0.5), 0.0, np.sqrt(0.5), 0.0))  # z of B along x of the world
    np.testing.assert_allclose(lying.gravity, [G, 0, 0], atol=1e-12)


@pytest.mark.parametrize(
    ("orientation", "gravity"),
    [
        ((np.cos(np.pi / 12), 0.0, np.sin(np.pi / 12), 0.0), (0.5, 0, -np.sqrt(0.75))),  # by 30 degrees about y
        ((np.sqrt(0.5), np.sqrt(0.5), 0.0, 0.0), (0, -1, 0)),  # by 90 about x: gravity pulls out of the bending plane
        ((np.sqrt(0.5), 0.0, 0.0, np.sqrt(0.5)), (0, 0, -1)),  # about z: nothing changes
        ((0.0, 1.0, 0.0, 0.0), (0, 0, 1)),  # by 180 about x: the finger hangs
    ],
)
def test_an_orientation_is_a_quaternion_w_x_y_z(orientation, gravity) -> None:
    np.testing.assert_allclose(replace(DRAWN, orientation=orientation).gravity, G * np.array(gravity), atol=1e-12)


def settled(links, force, total=None, velocity=0.0):
    link_force = np.zeros(13)
    link_force[links] = 1.0
    total = abs(force) if total is None else total
    return Settled(np.zeros(12), velocity, np.zeros(12), link_force, force, total, 0.08, np.zeros(3))


@pytest.mark.parametrize(
    ("found", "flaw"),
    [
        (settled([7, 8], -1.0), ""),
        (settled([6, 7, 8], -MIN_FORCE), ""),
        (settled([], 0.0), "lost"),
        (settled([7], -1.0, velocity=2 * STILL), "not at rest"),
        (settled([6, 7, 8, 9], -1.0), "several places"),
        (settled([6, 8], -1.0), "several places"),
        (settled([12], -1.0, 1.2), "on an edge"),
        (settled([7], -0.9 * MIN_FORCE), "too weak"),
        (settled([7], 1.0), "too weak"),
    ],
)
def test_what_is_no_single_contact(found: Settled, flaw: str) -> None:
    assert contact_flaw(DRAWN, found, 0.45) == flaw


def test_a_contact_is_the_same_alone_and_among_others() -> None:
    first = run_contact(3, 1, 0.3)
    run_contact(3, 2, 0.3)
    again = run_contact(3, 1, 0.3)
    assert first.draw == again.draw
    assert first.flaws == again.flaws
    for one, two in zip(first.settled, again.settled, strict=True):
        np.testing.assert_array_equal(one, two)
    assert run_contact(4, 1, 0.3).draw != first.draw
    assert contact_flaw(first.draw, first.settled, first.friction) == ""


def test_the_cone_of_friction_is_that_of_the_contact() -> None:
    """What is within one of 0.45 lies beside one of 0.3; without friction nothing acts along the face."""
    found = settled([7], -1.0, 1.08)
    assert [contact_flaw(DRAWN, found, friction) for friction in (0.45, 0.3)] == ["", "on an edge"]
    assert contact_flaw(DRAWN, settled([7], -1.0, 1.01), 0.0) == "on an edge"


def test_a_smooth_peg_only_presses() -> None:
    contact = run_contact(3, 1, 0.0)
    assert contact.friction == 0
    assert contact.settled.total == pytest.approx(abs(contact.settled.force), rel=1e-3)
