"""Placements: the boundaries between sensor sections along a finger.

A placement is the ends of all sections but the last, in whole segments from the base, increasing: of 12 segments (4,)
makes two sections of 4 and 8 segments.
"""

from itertools import combinations
from math import comb

from soft_gripper.errors import InputError
from soft_gripper.fingers.finger import Finger

Placement = tuple[int, ...]
_DECIMALS = 4  # of a share of the length: enough for 5000 segments


def all_placements(segments: int, count: int) -> list[Placement]:
    """Every way to make `count` sections of whole segments, in lexicographic order."""
    return list(combinations(range(1, segments), count - 1))


def number_of_placements(segments: int, count: int) -> int:
    """The number of placements."""
    return comb(segments - 1, count - 1)


def equal_placement(finger: Finger, count: int) -> Placement:
    """Sections as equal as whole segments allow; raises an InputError if the finger has too few segments."""
    if not 1 <= count <= finger.segments:
        expected = f"give 1 to {finger.segments}, the number of segments of a finger"
        raise InputError("place-sensors", "count", count, expected)
    return tuple(map(int, finger.section_ends(count)[1:-1]))


def as_borders(placement: Placement, segments: int) -> tuple[float, ...]:
    """The shares of the length that `sensor.borders` of a scenario takes."""
    return tuple(round(end / segments, _DECIMALS) for end in placement)
