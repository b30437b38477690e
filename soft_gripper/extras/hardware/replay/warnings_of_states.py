"""Warnings where a recording leaves the states that its model was fitted to, or disagrees with them, as text."""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from soft_gripper.arrays import Array


def extrapolated(
    time: Array, distance: Array, is_far: NDArray[np.bool_], state: Callable[[int, int], str]
) -> list[str]:
    """How much of a recording is far from what was fitted, and where it is furthest; none of it: nothing.

    Args:
        time: (T,) s.
        distance: of D parts of the state, (T, D).
        is_far: (T,)
        state: what the state of a sample and part is, in words.
    """
    if not is_far.any():
        return []
    row, part = np.unravel_index(int(np.argmax(distance)), distance.shape)
    share = f"{100 * is_far.mean():.0f} % of it is far from what was fitted"
    return [f"{share}: furthest at {time[row]:.1f} s, with {state(int(row), int(part))}"]


def disagreeing(what: str, apart: float, most: float) -> list[str]:
    """That readings and drive disagree by more than fitted recordings do, in spreads; nothing if they do not."""
    if apart <= most:
        return []
    by = f"by {apart:.2f} spreads, at most {most:.2f} between fitted recordings"
    return [f"{what} disagree ({by}): if set anew, give --zero 2"]
