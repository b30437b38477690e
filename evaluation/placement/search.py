"""The search for the best placement: all of them where they are few, else by exchange of one border at a time.

Up to EXHAUSTIVE placements, none is left out: of 12 segments there are 462 at most. For finer fingers the search begins
at a given placement and goes through the borders in turn; each goes to the best of all places between its neighbours.
It ends when no border moves: the placement is then the best of all that differ from it in one border, though perhaps
not of all. (Coordinate exchange, as for designs of experiments: Meyer and Nachtsheim 1995, doi
10.1080/00401706.1995.10485889.)
"""

from collections.abc import Callable

from soft_gripper.evaluation.placement.placements import Placement, all_placements, number_of_placements

EXHAUSTIVE = 500
Objective = Callable[[Placement], float]


def ranked(objective: Objective, segments: int, begin: Placement) -> list[Placement]:
    """The placements that were tried, that with the least objective first.

    `begin` is where the exchange begins; it has as many borders as all others, and is among those tried.
    """
    tried: dict[Placement, float] = {}

    def score(placement: Placement) -> float:
        if placement not in tried:
            tried[placement] = objective(placement)
        return tried[placement]

    if number_of_placements(segments, len(begin) + 1) <= EXHAUSTIVE:
        for placement in all_placements(segments, len(begin) + 1):
            score(placement)
    else:
        _exchange(score, segments, begin)
    return sorted(tried, key=lambda placement: (tried[placement], placement))


def _exchange(score: Objective, segments: int, begin: Placement) -> None:
    """Moves one border after the other to its best place, until none moves."""
    now, before = begin, None
    while now != before:
        before = now
        for i in range(len(now)):
            now = min(_moved(now, i, segments), key=score)


def _moved(placement: Placement, i: int, segments: int) -> list[Placement]:
    """All that differ from a placement in border i alone, itself among them."""
    low, _, high = (0, *placement, segments)[i : i + 3]
    return [(*placement[:i], end, *placement[i + 1 :]) for end in range(low + 1, high)]
