"""The search for the best paths of strain sensors, among all that a finger could have.

Up to EXHAUSTIVE sets of a size, all are tried. Larger ones grow from the best set that is smaller by one, and go on by
exchange: the path whose replacement by another gains most is replaced, until none gains. The set is then the best of
all that differ from it in one path, though perhaps not of all (exchange as for designs of experiments: Fedorov,
*Theory of Optimal Experiments*, 1972, chapter 3).
"""

from collections.abc import Callable, Iterator, Sequence
from itertools import combinations
from math import comb

Paths = tuple[str, ...]
EXHAUSTIVE = 1500


def try_sets(score: Callable[[Paths], float], paths: Sequence[str], most: int) -> dict[Paths, float]:
    """The scores of all sets of 1 to `most` paths that were tried, less being better; sets in the order of `paths`."""
    tried: dict[Paths, float] = {}

    def of(chosen: Paths) -> float:
        if chosen not in tried:
            tried[chosen] = score(chosen)
        return tried[chosen]

    best: Paths = ()
    for size in range(1, min(most, len(paths)) + 1):
        if comb(len(paths), size) <= EXHAUSTIVE:
            best = min(combinations(paths, size), key=of)
        else:
            best = _exchanged(of, paths, min(_larger(best, paths), key=of))
    return tried


def _exchanged(score: Callable[[Paths], float], paths: Sequence[str], begin: Paths) -> Paths:
    now, before = begin, None
    while now != before:
        before = now
        now = min((now, *_neighbours(now, paths)), key=score)
    return now


def _larger(chosen: Paths, paths: Sequence[str]) -> Iterator[Paths]:
    """All sets with one path more."""
    for added in paths:
        if added not in chosen:
            yield tuple(path for path in paths if path in chosen or path == added)


def _neighbours(chosen: Paths, paths: Sequence[str]) -> Iterator[Paths]:
    """All sets with one path replaced."""
    for removed in chosen:
        yield from _larger(tuple(path for path in chosen if path != removed), paths)
