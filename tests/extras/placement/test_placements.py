"""Placements: all of them, each once; equal ones; and borders that a scenario takes."""

from itertools import pairwise

import pytest
from refusals import refused

from soft_gripper.extras.placement.placements import (
    all_placements,
    as_borders,
    equal_placement,
    number_of_placements,
)
from soft_gripper.sensors.sensor_layout import SensorLayout


@pytest.mark.parametrize(("count", "number"), [(1, 1), (2, 11), (3, 55), (4, 165), (12, 1)])
def test_the_list_is_complete_and_has_no_duplicates(count, number):
    """The numbers are the binomial coefficients (11 over count - 1)."""
    placements = all_placements(12, count)
    assert len(set(placements)) == len(placements) == number == number_of_placements(12, count)
    for placement in placements:
        assert len(placement) == count - 1
        assert all(begin < end for begin, end in pairwise((0, *placement, 12)))


def test_equal_sections(shipped_finger):
    assert equal_placement(shipped_finger, 1) == ()
    assert equal_placement(shipped_finger, 2) == (6,)
    assert equal_placement(shipped_finger, 4) == (3, 6, 9)


@pytest.mark.parametrize("count", [0, 13])
def test_a_finger_has_no_more_sections_than_segments(shipped_finger, count):
    with refused("count", count):
        equal_placement(shipped_finger, count)


@pytest.mark.parametrize("count", [1, 2, 4])
def test_borders_lead_back_to_the_same_sections(shipped_finger, count):
    for placement in all_placements(12, count):
        layout = SensorLayout(shipped_finger, count, borders=as_borders(placement, 12))
        assert tuple(layout.section_ends) == (0, *placement, 12)
