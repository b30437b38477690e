"""How far a state is from those that a model was fitted to, and how much wider its errors may be there.

A state is a vector of drive and shape, each kind of number in units of its spread over the fitted states; its distance
is that to the nearest of these. A combination that was never met is far, even if each of its numbers was met.

What a model leaves out is taken to wander from one state to the next as Brownian motion does: the variance of its
errors grows with the distance. How fast is learned by leaving out regions of states, not recordings, which are often
alike: the model is fitted without a region, and its errors there are compared with the distances to what was kept.

Errors need not be alike in all fitted states: those of tendons that are pulled far are larger. Then bands are in units
of the errors in the nearest fitted states (`local_size`), and widen in proportion.

Where the drive is as in a fitted state, but what is read is not, readings and drive disagree.

D numbers of a state; n samples; leading axes are free.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from soft_gripper.arrays import Array

_NEIGHBOURS = 30  # states over which errors are averaged
REGIONS = 8  # of states, each of which is left out once
COVERAGE = 0.95  # of a band
_LARGEST = 1e12  # growth, of errors where nothing is left out
_FEW = 20_000  # numbers that are compared, up to which a tree takes longer
KNOWN_DRIVE = 0.25  # spreads, within which a drive was fitted
NEAREST = 0.1  # share of samples


@dataclass(frozen=True)
class FittedStates:
    """States that a model was fitted to."""

    states: Array  # (n, D)
    spread: Array  # (D,) unit of each number

    @cached_property
    def _scaled(self) -> Array:
        return self.states / self.spread

    @cached_property
    def _tree(self) -> cKDTree:
        return cKDTree(self._scaled)

    def distance(self, states: Array) -> Array:
        """From the nearest fitted state, in spreads, (..., D) -> (...)."""
        at = np.asarray(states) / self.spread
        if at.size * len(self.states) > _FEW:
            return np.asarray(self._tree.query(at)[0])
        return np.sqrt(((at[..., None, :] - self._scaled) ** 2).sum(axis=-1).min(axis=-1))

    def nearest(self, states: Array) -> NDArray[np.int_]:
        """Which fitted state is the nearest, (..., D) -> (...)."""
        return np.asarray(self._tree.query(np.asarray(states) / self.spread)[1])

    def local_size(self, errors: Array) -> Array:
        """Root mean square of errors in some of the nearest states of each, (n, K) -> (n, K)."""
        near = self._tree.query(self._scaled, np.arange(1, min(_NEIGHBOURS, len(self.states)) + 1))[1]
        return np.sqrt(np.nanmean(errors[near] ** 2, axis=1))

    def without(self, left_out: NDArray[np.bool_]) -> "FittedStates":
        """The states that are kept when some are left out, (n,)."""
        return FittedStates(self.states[~left_out], self.spread)

    def part(self, columns: slice | NDArray[np.int_]) -> "FittedStates":
        """Some numbers of the states."""
        return FittedStates(self.states[:, columns], self.spread[columns])

    def regions(self, most: int = REGIONS) -> NDArray[np.int_]:
        """The region of every state, (n,): the nearest of centres that are as far from each other as can be.

        Fewer than `most` if there are fewer different states.
        """
        return self._centers(most)[1]

    def halves(self, most: int = REGIONS) -> NDArray[np.int_]:
        """Regions that hold much the same number of states, (n,): halves of halves, across their longest directions.

        Fewer than `most`, a power of 2, if there are fewer different states.
        """
        different, of_state = np.unique(self._scaled, axis=0, return_inverse=True)
        region = np.zeros(len(self._scaled), int)
        for _ in range(most.bit_length() - 1):
            halved = 2 * region
            for number in np.unique(region):
                own = np.flatnonzero(region == number)
                centred = different - self._scaled[own].mean(axis=0)
                longest = np.linalg.svd(centred[of_state[own]], full_matrices=False)[2][0]
                along = (centred @ longest)[of_state[own]]
                middle = np.median(along)
                halved[own] += along > middle if middle < along.max() else along >= middle
            region = np.unique(halved, return_inverse=True)[1]
        return region

    def thinned(self, most: int) -> list[int]:
        """Which states to keep: at most so many, as far from each other as can be."""
        return self._centers(most)[0]

    def _centers(self, most: int) -> tuple[list[int], NDArray[np.int_]]:
        at = self._scaled
        nearest, region, centers = np.full(len(at), np.inf), np.zeros(len(at), int), []
        center = int(np.argmin(np.linalg.norm(at - at.mean(axis=0), axis=-1)))
        for number in range(most):
            centers.append(center)
            distance = np.linalg.norm(at - at[center], axis=-1)
            closer = distance < nearest
            region[closer], nearest[closer] = number, distance[closer]
            center = int(np.argmax(nearest))
            if nearest[center] == 0:
                break
        return centers, region


def spread_of(values: Array) -> float:
    """Unit of a kind of numbers, from its values (n, ...) in the fitted states; 1 if they are all the same."""
    spread = float(np.sqrt(np.mean(np.var(values, axis=0))))
    return spread if spread > 0 else 1.0


class Widths(NamedTuple):
    """Half widths of a band: sqrt(floor^2 + (growth * by_distance)^2).

    `by_distance` is what a growth of 1 makes of the distances, the root of which it is proportional to.
    """

    floor: Array  # (K,) of each of K errors, where the model was fitted
    growth: float

    def band(self, by_distance: Array) -> Array:
        """(..., K) -> (..., K)."""
        return np.hypot(self.floor, self.growth * by_distance)

    def is_far(self, by_distance: Array) -> NDArray[np.bool_]:
        """Whether the distance makes more of a band than all else does, (..., K) -> (..., K)."""
        return self.growth * by_distance > self.floor


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
            found = without(region == number)
            if len(found.errors):
                yield found


def moved_without(slopes: Array, residuals: Array, kept: NDArray[np.bool_], unobservable: float | None = None) -> Array:
    """How far the P unknowns of a fit move if only some of its residuals count, to the first order, (P,).

    Args:
        slopes: of the residuals by the unknowns, where the fit ended, (R, P).
        residuals: those of the prior among them, (R,).
        kept: which count, (R,).
        unobservable: share of the strongest change of these residuals, up to which unknowns stay; None: rounding.
    """
    moved: Array = np.linalg.lstsq(slopes[kept], -residuals[kept], rcond=unobservable)[0]
    return moved


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
    found = []
    for number, own in enumerate(by_recording) if len(by_recording) > 1 else ():
        others = np.concatenate([states for i, states in enumerate(by_recording) if i != number])
        found.append(disagreement(FittedStates(others, spread), own, shape))
    return max(found, default=0.0) or float("inf")
