"""Warns, as text, if a recording leaves the fitted states of its model, or disagrees with them."""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from soft_gripper.arrays import Array


def extrapolated(
    time: Array, distance: Array, is_far: NDArray[np.bool_], state: Callable[[int, int], str]
) -> list[str]:
    """Fraction of a recording that is far from the fitted states, and its furthest sample, as text; empty: none.

    Args:
        time: (T,) s.
        distance: of D parts of the state, (T, D).
        is_far: (T,)
        state: describes the state of a sample and part in words.
    """
    if not is_far.any():
        return []
    row, part = np.unravel_index(int(np.argmax(distance)), distance.shape)
    remark = f"{100 * is_far.mean():.0f} % of it is far from what was fitted"
    return [f"{remark}: furthest at {time[row]:.1f} s, with {state(int(row), int(part))}"]


def disagreeing(signals: str, distance: float, max_distance: float) -> list[str]:
    """Statement that readings and drive disagree by more spreads than fitted recordings do; empty if they do not."""
    if distance <= max_distance:
        return []
    distances = f"by {distance:.2f} spreads, at most {max_distance:.2f} between fitted recordings"
    return [f"{signals} disagree ({distances}): if set anew, give --zero 2"]
