"""Random contacts: which numbers are drawn, that each stands for itself, and what counts as a single contact."""

import numpy as np
import pytest

from studies.contacts.peg import (
    MIN_FORCE,
    PLACE,
    RADIUS,
    STILL,
    RandomContact,
    SettledFinger,
    contact_flaw,
    draw_contact,
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


def settled(links, force, total=None, velocity=0.0):
    link_force = np.zeros(13)
    link_force[links] = 1.0
    total = abs(force) if total is None else total
    return SettledFinger(np.zeros(12), velocity, np.zeros(12), link_force, force, total, 0.08, np.zeros(3))


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
def test_what_is_no_single_contact(found: SettledFinger, flaw: str) -> None:
    assert contact_flaw(DRAWN, found, 0.45) == flaw


def test_the_cone_of_friction_is_that_of_the_contact() -> None:
    """What is within one of 0.45 lies beside one of 0.3; without friction nothing acts along the face."""
    found = settled([7], -1.0, 1.08)
    assert [contact_flaw(DRAWN, found, friction) for friction in (0.45, 0.3)] == ["", "on an edge"]
    assert contact_flaw(DRAWN, settled([7], -1.0, 1.01), 0.0) == "on an edge"
