"""Distance of a state from the fitted states of a model, and the growth of its error bands with this distance.

A state is a vector of drive and shape, each kind of number in units of its spread over the fitted states; its distance
is that to the nearest of these. A combination that was never met is far, even if each of its numbers was met.

What a model leaves out is taken to wander from one state to the next as Brownian motion does: the variance of its
errors grows with the distance. How fast is learned where the model is fitted.

Errors need not be alike in all fitted states: those of tendons that are pulled far are larger. Then bands are in units
of the errors in the nearest fitted states (`local_size`), and widen in proportion.

D numbers of a state; n samples; leading axes are free.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from soft_gripper.arrays import Array

_LOCAL_STATES = 30  # states over which errors are averaged
REGIONS = 8  # of states, each of which is left out once
_MAX_COMPARED_NUMBERS = 20_000  # numbers that are compared, up to which a tree takes longer


@dataclass(frozen=True)
class FittedStates:
    states: Array  # (n, D)
    spread: Array  # (D,) unit of each number

    @cached_property
    def _scaled(self) -> Array:
        return self.states / self.spread

    @cached_property
    def _tree(self) -> Any:
        from scipy.spatial import cKDTree

        return cKDTree(self._scaled)

    def distance(self, states: Array) -> Array:
        """Distance to the nearest state, in spreads, (..., D) -> (...)."""
        scaled = np.asarray(states) / self.spread
        if scaled.size * len(self.states) > _MAX_COMPARED_NUMBERS:
            return np.asarray(self._tree.query(scaled)[0])
        return np.sqrt(((scaled[..., None, :] - self._scaled) ** 2).sum(axis=-1).min(axis=-1))

    def nearest(self, states: Array) -> NDArray[np.int_]:
        """Index of the nearest fitted state, (..., D) -> (...)."""
        return np.asarray(self._tree.query(np.asarray(states) / self.spread)[1])

    def local_size(self, errors: Array) -> Array:
        """Root mean square of errors in some of the nearest states of each, (n, K) -> (n, K)."""
        neighbors = self._tree.query(self._scaled, np.arange(1, min(_LOCAL_STATES, len(self.states)) + 1))[1]
        return np.sqrt(np.nanmean(errors[neighbors] ** 2, axis=1))

    def leave_out(self, left_out: NDArray[np.bool_]) -> "FittedStates":
        """Copy with the states of a mask left out, (n,)."""
        return FittedStates(self.states[~left_out], self.spread)

    def part(self, columns: slice | NDArray[np.int_]) -> "FittedStates":
        return FittedStates(self.states[:, columns], self.spread[columns])

    def regions(self, max_count: int = REGIONS) -> NDArray[np.int_]:
        """The region of every state, (n,): the nearest of centres that are as far from each other as can be.

        Fewer than `max_count` if there are fewer different states.
        """
        return self._centers(max_count)[1]

    def halves(self, max_count: int = REGIONS) -> NDArray[np.int_]:
        """Regions that hold much the same number of states, (n,): halves of halves, across their longest directions.

        Fewer than `max_count`, a power of 2, if there are fewer different states.
        """
        distinct_states, distinct_index = np.unique(self._scaled, axis=0, return_inverse=True)
        region = np.zeros(len(self._scaled), int)
        for _ in range(max_count.bit_length() - 1):
            half_regions = 2 * region
            for number in np.unique(region):
                members = np.flatnonzero(region == number)
                centred = distinct_states - self._scaled[members].mean(axis=0)
                longest = np.linalg.svd(centred[distinct_index[members]], full_matrices=False)[2][0]
                positions = (centred @ longest)[distinct_index[members]]
                middle = np.median(positions)
                half_regions[members] += positions > middle if middle < positions.max() else positions >= middle
            region = np.unique(half_regions, return_inverse=True)[1]
        return region

    def thinned(self, max_count: int) -> list[int]:
        """Indices of states to keep: `max_count` of them, as far from each other as can be."""
        return self._centers(max_count)[0]

    def _centers(self, max_count: int) -> tuple[list[int], NDArray[np.int_]]:
        scaled = self._scaled
        min_distances = np.full(len(scaled), np.inf)
        region, centers = np.zeros(len(scaled), int), []
        center = int(np.argmin(np.linalg.norm(scaled - scaled.mean(axis=0), axis=-1)))
        for region_index in range(max_count):
            centers.append(center)
            distance = np.linalg.norm(scaled - scaled[center], axis=-1)
            is_closer = distance < min_distances
            region[is_closer], min_distances[is_closer] = region_index, distance[is_closer]
            center = int(np.argmax(min_distances))
            if min_distances[center] == 0:
                break
        return centers, region


def spread_of(values: Array) -> float:
    """Unit of a kind of numbers, from its values (n, ...) in the fitted states; 1 if they are all the same."""
    unit = float(np.sqrt(np.mean(np.var(values, axis=0))))
    return unit if unit > 0 else 1.0


class Widths(NamedTuple):
    """Half widths of a band: sqrt(floor^2 + (growth * by_distance)^2).

    `by_distance` is what a growth of 1 makes of the distances, the root of which it is proportional to.
    """

    floor: Array  # (K,) of each of K errors, where the model was fitted
    growth: float

    def band(self, by_distance: Array) -> Array:
        """Half widths of the band, (..., K) -> (..., K)."""
        return np.hypot(self.floor, self.growth * by_distance)

    def is_far(self, by_distance: Array) -> NDArray[np.bool_]:
        """Mask of errors with a band that is wider by the distance than by the floor, (..., K) -> (..., K)."""
        return self.growth * by_distance > self.floor
