"""The search for the best designs: all of them where they are few, otherwise by exchange of one part at a time.

Exchange begins at a design, and goes to the best of all that differ from it in one part, until none is better. The
result is then the best of its neighbours, though perhaps not of all (exchange as for designs of experiments: Fedorov,
*Theory of Optimal Experiments*, 1972, chapter 3; Meyer and Nachtsheim 1995, doi 10.1080/00401706.1995.10485889).
"""

from collections.abc import Callable, Iterable, Iterator, Sequence
from itertools import combinations
from math import comb
from typing import TypeVar

EXHAUSTIVE = 500  # designs, up to which all are tried
Part = TypeVar("Part")
Parts = tuple[Part, ...]


def exchanged(
    score: Callable[[Parts[Part]], float], begin: Parts[Part], neighbours: Callable[..., Iterable[Parts[Part]]]
) -> Parts[Part]:
    """The best that exchange leads to."""
    now, before = begin, None
    while now != before:
        before, now = now, min((now, *neighbours(now)), key=score)
    return now


def search_borders(score: Callable[[Parts[int]], float], segments: int, begin: Parts[int]) -> None:
    """Tries borders between sections, ends of segments, as many as `begin` has, where an exchange begins."""
    if comb(segments - 1, len(begin)) <= EXHAUSTIVE:
        for borders in combinations(range(1, segments), len(begin)):
            score(borders)
    else:
        exchanged(score, begin, lambda now: _moved(now, segments))


def _moved(borders: Parts[int], segments: int) -> Iterator[Parts[int]]:
    """All that differ in one border."""
    for i, now in enumerate(borders):
        low, _, high = (0, *borders, segments)[i : i + 3]
        yield from ((*borders[:i], end, *borders[i + 1 :]) for end in range(low + 1, high) if end != now)


def search_sets(score: Callable[[Parts[str]], float], parts: Sequence[str], most: int) -> None:
    """Tries sets of 1 to `most` parts, in the order of `parts`; large ones grow from the best smaller one."""
    best: Parts[str] = ()
    for size in range(1, min(most, len(parts)) + 1):
        if comb(len(parts), size) <= EXHAUSTIVE:
            best = min(combinations(parts, size), key=score)
        else:
            best = exchanged(score, min(_larger(best, parts), key=score), lambda now: _replaced(now, parts))


def _larger(chosen: Parts[str], parts: Sequence[str]) -> Iterator[Parts[str]]:
    """All sets with one part more."""
    for added in parts:
        if added not in chosen:
            yield tuple(part for part in parts if part in chosen or part == added)


def _replaced(chosen: Parts[str], parts: Sequence[str]) -> Iterator[Parts[str]]:
    """All sets with one part replaced."""
    for removed in chosen:
        yield from _larger(tuple(part for part in chosen if part != removed), parts)
