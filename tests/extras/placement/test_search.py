"""The search finds optima that are known, and tries nothing twice."""

from collections import Counter

import pytest

from soft_gripper.extras.placement.place_sensors import EXHAUSTIVE, ranked
from soft_gripper.extras.placement.placements import all_placements


def distance_to(best):
    return lambda placement: float(sum((a - b) ** 2 for a, b in zip(placement, best, strict=True)))


@pytest.mark.parametrize("best", [(1, 2, 3), (2, 7, 11), (3, 6, 9)])
def test_few_placements_are_all_tried(best):
    found = ranked(distance_to(best), 12, (3, 6, 9))
    assert found[0] == best
    assert sorted(found) == all_placements(12, 4)


def test_the_first_is_the_least_and_the_last_the_greatest():
    objective = distance_to((4,))
    found = ranked(objective, 12, (6,))
    assert [objective(placement) for placement in found] == sorted(objective((end,)) for end in range(1, 12))


@pytest.mark.parametrize("best", [(5, 22, 59), (1, 2, 3), (20, 21, 40)])
def test_many_placements_are_exchanged_border_by_border(best):
    found = ranked(distance_to(best), 60, (15, 30, 45))
    assert found[0] == best
    assert (15, 30, 45) in found
    assert len(found) < 10 * EXHAUSTIVE < len(all_placements(60, 4))


def rugged(placement):
    """Has many local minima."""
    return float((7 * placement[0] * placement[1] + 13 * placement[2]) % 101)


def coupled(placement):
    """A valley along which borders move together, a little at a time."""
    return float((placement[1] - placement[0] - 20) ** 2 + (placement[0] - 5) ** 2 + (placement[2] - 50) ** 2)


@pytest.mark.parametrize("objective", [rugged, coupled])
def test_no_exchange_of_one_border_is_better(objective):
    best = ranked(objective, 60, (15, 30, 45))[0]
    around = [
        moved
        for i in range(3)
        for end in range(1, 60)
        if (moved := (*best[:i], end, *best[i + 1 :])) and list(moved) == sorted(set(moved))
    ]
    assert objective(best) == min(map(objective, around))


@pytest.mark.parametrize("segments", [12, 60])
def test_nothing_is_tried_twice(segments):
    tried = Counter()

    def objective(placement):
        tried[placement] += 1
        return float(sum(placement))

    found = ranked(objective, segments, (3, 6, 9))
    assert set(tried.values()) == {1}
    assert set(found) == set(tried)


def test_an_objective_without_slope_ends():
    assert ranked(lambda placement: 0.0, 60, (15, 30, 45))
