"""The search finds optima that are known, tries nothing twice, and ends where no exchange is better."""

from collections import Counter
from itertools import combinations

import pytest

from soft_gripper.extras.placement import search
from soft_gripper.extras.placement.search import EXHAUSTIVE, search_borders, search_sets


def tried(objective):
    """A score that remembers, and what it remembers."""
    found = {}

    def score(parts):
        found[parts] = objective(parts)
        return found[parts]

    return score, found


def distance_to(best):
    return lambda borders: float(sum((a - b) ** 2 for a, b in zip(borders, best, strict=True)))


def test_few_borders_are_all_tried():
    score, found = tried(distance_to((2, 7, 11)))
    search_borders(score, 12, (3, 6, 9))
    assert list(found) == list(combinations(range(1, 12), 3))
    assert min(found, key=found.get) == (2, 7, 11)


@pytest.mark.parametrize("best", [(5, 22, 59), (1, 2, 3), (20, 21, 40)])
def test_many_borders_are_exchanged(best):
    score, found = tried(distance_to(best))
    search_borders(score, 60, (15, 30, 45))
    assert min(found, key=found.get) == best
    assert (15, 30, 45) in found
    assert len(found) < 10 * EXHAUSTIVE


@pytest.mark.parametrize(
    "objective",
    [
        lambda borders: float((7 * borders[0] * borders[1] + 13 * borders[2]) % 101),
        lambda b: float((b[1] - b[0] - 20) ** 2 + (b[0] - 5) ** 2 + (b[2] - 50) ** 2),
        lambda borders: 0.0,
    ],
    ids=["rugged", "a valley", "flat"],
)
def test_no_exchange_of_one_border_is_better(objective):
    score, found = tried(objective)
    search_borders(score, 60, (15, 30, 45))
    best = min(found, key=found.get)
    moved = ((*best[:i], end, *best[i + 1 :]) for i in range(3) for end in range(1, 60))
    assert objective(best) == min(objective(each) for each in moved if list(each) == sorted(set(each)))


WEIGHTS = dict(zip("abcdefghij", (3, 1, 4, 1.5, 9, 2, 6, 5, 3.5, 8), strict=True))


def coverage(chosen):
    """Less is better: what is left when pairs overlap."""
    pairs = sum(WEIGHTS[a] * WEIGHTS[b] * ((ord(a) + ord(b)) % 3 == 0) for a, b in combinations(chosen, 2))
    return 100 - sum(WEIGHTS[one] for one in chosen) + 0.02 * pairs


@pytest.mark.parametrize("exhaustive", [0, 500])
def test_sets_are_those_of_brute_force(monkeypatch, exhaustive):
    monkeypatch.setattr(search, "EXHAUSTIVE", exhaustive)
    score, found = tried(coverage)
    search_sets(score, list(WEIGHTS), 4)
    for size in range(1, 5):
        least = min(map(coverage, combinations(WEIGHTS, size)))
        assert min(found[chosen] for chosen in found if len(chosen) == size) == pytest.approx(least)


def test_there_are_no_more_parts_than_there_are():
    calls = Counter()
    search_sets(lambda chosen: calls.update([chosen]) or float(len(chosen)), ["a", "b"], 5)
    assert set(calls) == {("a",), ("b",), ("a", "b")}
