"""Learns how errors of a fitted model grow away from the states that it was fitted to (`FittedStates`).

It is learned by leaving out regions of states, not recordings, which are often alike: the model is fitted without a
region, and its errors there are compared with the distances to what was kept.

Where the drive is as in a fitted state, but what is read is not, readings and drive disagree. Both are told as text.
The states are kept in a file with their widths.

D numbers of a state; n samples.
"""

from collections.abc import Callable, Iterator, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from soft_gripper.arrays import Array
from soft_gripper.scenario.fitted_states_config import FittedStatesConfig
from soft_gripper.sensors.fitted_states import FittedStates, Widths

COVERAGE = 0.95  # of a band
_MAX_GROWTH = 1e12  # of errors where nothing is left out
KNOWN_DRIVE = 0.25  # spreads, within which a drive was fitted
NEAREST = 0.1  # share of samples
_MAX_STATES = 400  # states that are kept
_DIGITS, _MIN_NUMBER = 6, 1e-12  # of kept numbers; smaller ones are rounding


class LeftOut(NamedTuple):
    """A region that was left out, of m samples."""

    errors: Array  # (m, K) absolute, of the model that was fitted without it
    growth_widths: Array  # (m, K) of a growth of 1, at the distances from the kept states


def regions_left_out(
    regions: Sequence[NDArray[np.int_]], leave_out: Callable[[NDArray[np.bool_]], LeftOut]
) -> Iterator[LeftOut]:
    """Leaves out every region of every division of the samples, (n,), once.

    `leave_out` gives errors in the samples of a mask, (n,), of a fit to the others.
    """
    for region in regions:
        for number in range(region.max() + 1) if region.any() else ():
            left_out = leave_out(region == number)
            if len(left_out.errors):
                yield left_out


def learned_widths(fitted: Array, left_out: Sequence[LeftOut]) -> Widths:
    """Widths that hold COVERAGE of the errors where the model was fitted, and in regions that were left out.

    Errors of a region go together, however long it was stayed in: every region counts the same. Further away than any
    sample that was left out nothing is known: there, the distance makes more of a band than all else. Without a
    region, the distance is not taken to matter. `fitted` are absolute errors of the fit to all samples, (n, K).
    """
    floor = np.quantile(fitted, COVERAGE, axis=0)
    if not left_out:
        return Widths(floor, 0.0)
    growths = np.concatenate([_needed_growths(region, floor).ravel() for region in left_out])
    weights = np.concatenate([np.full(region.errors.size, 1 / region.errors.size) for region in left_out])
    order = np.argsort(growths)
    covered = np.cumsum(weights[order]) / len(left_out)
    growth = float(growths[order][np.searchsorted(covered, COVERAGE)])
    far_widths = np.max([region.growth_widths.max(axis=0) for region in left_out], axis=0)
    floor_ratio = np.divide(floor, far_widths, out=np.zeros_like(floor), where=far_widths > 0)
    return Widths(floor, max(growth, float(floor_ratio.min())))


def _needed_growths(region: LeftOut, floor: Array) -> Array:
    """The least growth that covers each error, (m, K)."""
    excess, widths = np.sqrt(np.maximum(0, region.errors**2 - floor**2)), region.growth_widths
    return np.divide(excess, widths, out=_MAX_GROWTH * (excess > 0), where=widths > 0)


def disagreement(fitted: FittedStates, states: Array, shape: int) -> float:
    """Quantile NEAREST of the distances of states with a known drive from the fitted ones; 0 without such states.

    Sensors that were set anew are wrong all the time; other recordings come near what was fitted. Of the states,
    (T, D), the first `shape` numbers are read; the others are those of the drive.
    """
    drive = fitted.part(slice(shape, None)).distance(states[:, shape:])
    return nearest_distance(np.where(drive < KNOWN_DRIVE, fitted.distance(states), np.nan))


def nearest_distance(distance: Array) -> float:
    """Quantile NEAREST of the finite distances; 0 if all are NaN."""
    known_distances = distance[np.isfinite(distance)]
    return float(np.quantile(known_distances, NEAREST)) if len(known_distances) else 0.0


def fitted_disagreement(recordings: Sequence[Array], spread: Array, shape: int) -> float:
    """Largest disagreement of a recording's states with the states of all others; infinite if unknown."""
    disagreements = []
    for number, states in enumerate(recordings) if len(recordings) > 1 else ():
        other_states = np.concatenate([*recordings[:number], *recordings[number + 1 :]])
        disagreements.append(disagreement(FittedStates(other_states, spread), states, shape))
    return max(disagreements, default=0.0) or float("inf")


def extrapolation_warnings(
    time: Array, distance: Array, is_far: NDArray[np.bool_], describe_state: Callable[[int, int], str]
) -> list[str]:
    """Fraction of a recording, (T,) s, that is far from the fitted states, and its furthest sample, as text, if any.

    `distance` is that of D parts of the state, (T, D); `describe_state` puts those of a sample and part in words.
    """
    if not is_far.any():
        return []
    row, column = np.unravel_index(int(np.argmax(distance)), distance.shape)
    remark = f"{100 * is_far.mean():.0f} % of it is far from what was fitted"
    return [f"{remark}: furthest at {time[row]:.1f} s, with {describe_state(int(row), int(column))}"]


def disagreement_warnings(signals: str, distance: float, max_distance: float) -> list[str]:
    """Warning that readings and drive disagree by more spreads than in fitted recordings; empty otherwise."""
    distances = f"by {distance:.2f} spreads, at most {max_distance:.2f} between fitted recordings"
    return [] if distance <= max_distance else [f"{signals} disagree ({distances}): if set anew, give --zero 2"]


def kept_states(
    names: Sequence[str],
    fitted: FittedStates,
    widths: Widths,
    noise: float = 0.0,
    disagreement: float = float("inf"),
    sizes: Array | None = None,
    most: int = _MAX_STATES,
) -> FittedStatesConfig:
    """Fields of a file that keeps `most` states; an infinite disagreement is unknown.

    `sizes` are those of the errors in the states, (n, K).
    """
    rows = fitted.thinned(most)
    growth, noise, limit = _round([widths.growth, noise, disagreement if np.isfinite(disagreement) else 0.0])
    return FittedStatesConfig(
        names=list(names),
        spread=_round(fitted.spread),
        states=[_round(state) for state in fitted.states[rows]],
        floor=_round(widths.floor),
        sizes=[] if sizes is None else [_round(size) for size in sizes[rows]],
        growth=growth,
        noise=noise,
        disagreement=limit if np.isfinite(disagreement) else None,
    )


def _round(values: Sequence[float] | np.ndarray) -> list[float]:
    return [0.0 if abs(value) < _MIN_NUMBER else float(f"{value:.{_DIGITS}g}") for value in values]
