"""How much wider the errors of a fitted model may be away from the states that it was fitted to (`FittedStates`).

This is learned by leaving out regions of states, not recordings, which are often alike: the model is fitted without a
region, and its errors there are compared with the distances to what was kept.

Where the drive is as in a fitted state, but what is read is not, readings and drive disagree.

D numbers of a state; n samples.
"""

from collections.abc import Callable, Iterator, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from soft_gripper.arrays import Array
from soft_gripper.sensors.fitted_states import FittedStates, Widths

COVERAGE = 0.95  # of a band
_LARGEST = 1e12  # growth, of errors where nothing is left out
KNOWN_DRIVE = 0.25  # spreads, within which a drive was fitted
NEAREST = 0.1  # share of samples


class LeftOut(NamedTuple):
    """A region that was left out, of m samples."""

    errors: Array  # (m, K) absolute, of the model that was fitted without it
    by_distance: Array  # (m, K) what a growth of 1 makes of the distances to what was kept


def regions_left_out(
    regions: Sequence[NDArray[np.int_]], without: Callable[[NDArray[np.bool_]], LeftOut]
) -> Iterator[LeftOut]:
    """Leaves out every region of every division of the samples once.

    Args:
        regions: of n samples, (n,) each.
        without: errors in the samples that are left out, (n,), of a fit to the others.
    """
    for region in regions:
        for number in range(region.max() + 1) if region.any() else ():
            left_out = without(region == number)
            if len(left_out.errors):
                yield left_out


def learned_widths(fitted: Array, left_out: Sequence[LeftOut]) -> Widths:
    """Widths that hold COVERAGE of the errors where the model was fitted, and in regions that were left out.

    Errors of a region go together, however long it was stayed in: every region counts the same. Further away than any
    sample that was left out nothing is known: there, the distance makes more of a band than all else.

    Args:
        fitted: absolute errors of the model that was fitted to all, (n, K).
        left_out: regions; none of them: the distance is not taken to matter.
    """
    floor = np.quantile(fitted, COVERAGE, axis=0)
    if not left_out:
        return Widths(floor, 0.0)
    needed = np.concatenate([_needed(region, floor).ravel() for region in left_out])
    weights = np.concatenate([np.full(region.errors.size, 1 / region.errors.size) for region in left_out])
    order = np.argsort(needed)
    held = np.cumsum(weights[order]) / len(left_out)
    growth = float(needed[order][np.searchsorted(held, COVERAGE)])
    furthest = np.max([region.by_distance.max(axis=0) for region in left_out], axis=0)
    unknown = np.divide(floor, furthest, out=np.zeros_like(floor), where=furthest > 0)
    return Widths(floor, max(growth, float(unknown.min())))


def _needed(region: LeftOut, floor: Array) -> Array:
    """The least growth that holds each error, (m, K)."""
    beyond = np.sqrt(np.maximum(0, region.errors**2 - floor**2))
    needed: Array = np.divide(beyond, region.by_distance, out=_LARGEST * (beyond > 0), where=region.by_distance > 0)
    return needed


def disagreement(fitted: FittedStates, states: Array, shape: int) -> float:
    """How far states stay from the fitted ones where their drive is known: all but NEAREST of them; 0: it never is.

    Sensors that were set anew are wrong all the time; other recordings come near what was fitted.

    Args:
        fitted: states whose first `shape` numbers are read; the others are those of the drive.
        states: (T, D).
    """
    drive = fitted.part(slice(shape, None)).distance(states[:, shape:])
    return nearest(np.where(drive < KNOWN_DRIVE, fitted.distance(states), np.nan))


def nearest(distance: Array) -> float:
    """The distance, of those that are not NaN, within which the share NEAREST of them lies; 0: all are NaN."""
    known = np.isfinite(distance)
    return float(np.quantile(distance[known], NEAREST)) if known.any() else 0.0


def fitted_disagreement(by_recording: Sequence[Array], spread: Array, shape: int) -> float:
    """The most that the states of a recording disagree with those of all others; infinite: it cannot be told."""
    disagreements = []
    for number, own in enumerate(by_recording) if len(by_recording) > 1 else ():
        others = np.concatenate([states for i, states in enumerate(by_recording) if i != number])
        disagreements.append(disagreement(FittedStates(others, spread), own, shape))
    return max(disagreements, default=0.0) or float("inf")
