"""How far markers may be from where an identified finger has them, and recordings that leave what it was fitted to.

A state is what drives the finger: how far its tendons are pulled, or the pressure of its chamber, and the load on its
tip. The band of a marker is a ball that holds it with a probability of 95 %, and grows with the distance from the
nearest fitted state, as `fitted_states` says. Before it grows, that of a motion has two parts: what the model leaves of
the fitted recordings, and what the covariance of the keys leaves open. Growth is learned by leaving out regions of
states, in units of the band of the fit without them: that such a fit knows its keys less well is no error of the model.
It is the larger of two. Regions that lie apart show how errors grow where the finger is driven further; as most states
are in one of them, regions of equal numbers of states show how they grow in between. Tendons that are pulled far have
larger errors, so bands of settled states are in units of the errors nearby. In motions they are a share of the largest
displacement, which grows with the drive too; what is fitted to every recording, its events, is taken as found.

The states and the band are kept beside the finger's file, and read again with it.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from operator import attrgetter
from typing import Annotated, NamedTuple

import numpy as np
from numpy.typing import NDArray
from tqdm import tqdm

from soft_gripper.arrays import Array
from soft_gripper.extras.hardware.identification.beside_finger import BesideFinger
from soft_gripper.extras.hardware.identification.confidence import UNOBSERVABLE, square_root
from soft_gripper.extras.hardware.identification.fit import MotionScore, Run, confidence, marker_deviations
from soft_gripper.extras.hardware.identification.identified_finger import Identified, Tested
from soft_gripper.extras.hardware.identification.kept_confidence import ConfidenceConfig
from soft_gripper.extras.hardware.identification.settled_states import (
    IdentifiedStates,
    SettledStates,
    StateScore,
    TestedStates,
)
from soft_gripper.extras.hardware.identification.simulated_motion import MeasuredMotion, simulated_markers
from soft_gripper.extras.hardware.kept_states import kept_states
from soft_gripper.extras.hardware.left_out_regions import COVERAGE, LeftOut, learned_widths, regions_left_out
from soft_gripper.extras.hardware.scoring import LEFT_OUT, ball_radius, ball_rms_z, percent_within
from soft_gripper.files.document import require
from soft_gripper.fingers.finger import Finger
from soft_gripper.fingers.kinematics import as_points
from soft_gripper.scenario.fitted_states_config import FittedStatesConfig
from soft_gripper.sensors.fitted_states import FittedStates, spread_of

STATES = BesideFinger(
    ".states.yaml",
    "The states that a finger was fitted to, and how its errors grow away from them, for `--test`",
    FittedStatesConfig,
)
_LOAD = 0.1  # kg, unit of loads: recordings often have a single one
_MOST_KEPT = 2000  # states: a dozen tendons make a space in which few states are all far from each other
_STRIDE = 5  # one sample of a motion in so many counts


@dataclass(frozen=True)
class BandRow:
    """Markers of a recording and their 95 % bands."""

    recording: str
    role: str
    within_band_percent: Annotated[float, ".1f"]
    rms_z: Annotated[float, ".2f"]  # errors along an axis over their standard deviations, root mean square: 1 is right
    band_mm: Annotated[float, ".2f"]  # mean radius
    far_percent: Annotated[float, ".1f"]  # rows, or samples, that are far from what was fitted


class _Driven(NamedTuple):
    """T rows or samples of a recording."""

    name: str
    states: Array  # (T, D)
    errors: Array  # (T, M) m, of the markers; NaN where one is not seen
    scale: float  # m, of errors: the largest displacement, or 1
    by_keys: Array | float = 0.0  # (T, M) m, half widths that the covariance of the keys gives


class _Learned(NamedTuple):
    """A fit, as n samples of K errors each."""

    states: Array  # (n, D)
    errors: Array  # (n, K) m, or shares of the largest displacement; NaN where a sample is not seen
    to_error: Array | float  # (R,) factors that make errors of residuals
    parts: int  # residuals of an error
    is_local: bool  # whether errors differ between the states, and no covariance is counted


def learned_band(identified: Identified | IdentifiedStates) -> FittedStatesConfig:
    """The states that a finger was fitted to, and the band of its markers."""
    fit, learned = identified.fit, _learned(identified)
    seen = np.isfinite(learned.errors).all(axis=1)
    states, count = learned.states, learned.errors.shape[1] * learned.parts
    spread, floor = _spreads(states), np.nanquantile(learned.errors, COVERAGE)

    def sizes(rows: NDArray[np.bool_]) -> Array:
        """Sizes of the errors near some of the samples."""
        if not learned.is_local:
            return np.ones((int(rows.sum()), learned.errors.shape[1]))
        return FittedStates(states[rows], spread).local_size(learned.errors[rows])

    def errors(moved: Array, rows: NDArray[np.bool_]) -> Array:
        away = ((fit.residuals + fit.slopes @ moved) * learned.to_error).reshape(*learned.errors.shape, learned.parts)
        return np.linalg.norm(away, axis=-1)[rows]

    def by_keys(kept: NDArray[np.bool_]) -> Array:
        """Half widths by the keys of a fit to some of the residuals, (n, K)."""
        assert isinstance(identified, Identified)
        moved = fit.slopes @ square_root(confidence(identified.fit, kept).covariance)
        return ball_radius((moved.T * learned.to_error).reshape(-1, *learned.errors.shape, learned.parts))

    def without(region: NDArray[np.bool_]) -> LeftOut:
        left_out = np.zeros(len(states), bool)
        left_out[np.flatnonzero(seen)[region]] = True
        moved = fit.change_without(np.repeat(~left_out, count), UNOBSERVABLE, fit.free.scales)
        kept = seen & ~left_out
        others = FittedStates(states[kept], spread)
        size = sizes(kept)[others.nearest(states[left_out])]
        if not learned.is_local:
            size = np.hypot(size, by_keys(np.repeat(kept, count))[left_out] / floor)
        distance = np.sqrt(others.distance(states[left_out]))[:, None] * np.ones(size.shape[1])
        return LeftOut(errors(moved, left_out) / size, distance)

    fitted, size = FittedStates(states[seen], spread), sizes(seen)
    near = errors(np.zeros(len(fit.x)), seen) / size
    each_way = [
        [*tqdm(regions_left_out([regions], without), desc="bands", unit="region", dynamic_ncols=True)]
        for regions in (fitted.regions(), fitted.halves())
    ]
    widths = max((learned_widths(near, left_out) for left_out in each_way), key=attrgetter("growth"))
    of_states = size if learned.is_local else None
    return kept_states(_names(identified.model.finger, states), fitted, widths, sizes=of_states, most=_MOST_KEPT)


def _learned(identified: Identified | IdentifiedStates) -> _Learned:
    if isinstance(identified, IdentifiedStates):
        count = len(identified.left_out)
        recordings = [
            *_of_states(TestedStates(identified.model, identified.states[:count], identified.errors[:count], ()))
        ]
        states, errors = (np.concatenate(each) for each in zip(*(one[1:3] for one in recordings), strict=True))
        return _Learned(states, errors, 1.0, 3, is_local=True)
    recordings = [*_of_motions(Tested(identified.model, identified.fit.recordings, ()), every=1)]
    states = np.concatenate([np.repeat(each.states, each.errors.shape[1], axis=0) for each in recordings])
    errors = np.concatenate([(each.errors / each.scale).reshape(-1, 1) for each in recordings])
    sizes = [each.errors.size for each in recordings]
    to_error = np.concatenate([np.full(2 * size, np.sqrt(size)) for size in sizes])
    return _Learned(states, errors, to_error, 2, is_local=False)


def _names(finger: Finger, states: Array) -> list[str]:
    driven = [f"{tendon.name} [m]" for tendon in finger.tendons] or ["pressure [Pa]"]
    return [*driven[: states.shape[-1] - 1], "load [kg]"]


def _spreads(states: Array) -> Array:
    return np.append(np.full(states.shape[-1] - 1, spread_of(states[:, :-1])), _LOAD)


def band_rows(
    kept: FittedStatesConfig, tested: Tested | TestedStates, known: ConfidenceConfig | None = None, run: Run = map
) -> list[BandRow]:
    """How the markers of recordings lie in their bands.

    Args:
        kept: states and band of the fit.
        tested: recordings that are compared with the finger.
        known: confidence in its keys, which counts in motions; None: they are exact.
        run: calls a function with every one of its arguments, as `map` does, or that of an executor.
    """
    fitted, widths = kept.fitted, kept.widths
    recordings = _of_states(tested) if isinstance(tested, TestedStates) else _of_motions(tested, _STRIDE, known, run)
    scores: Sequence[MotionScore | StateScore] = tested.scores
    roles = {score.recording: score.role for score in reversed(scores)}
    rows = []
    for each in recordings:
        expected = f"its states have {each.states.shape[-1]} numbers: is it of another finger?"
        require(len(kept.spread) == each.states.shape[-1], each.name, "states", len(kept.spread), expected)
        markers = each.errors.shape[1]
        expected = f"its recording has {markers} markers: is it of another finger?"
        require(len(kept.floor) in (1, markers), each.name, "floor", len(kept.floor), expected)
        by_distance = np.sqrt(fitted.distance(each.states))[:, None]
        size = each.scale * kept.sizes_near(each.states)
        band = widths.band(by_distance) * np.hypot(size, each.by_keys / widths.floor)
        far = widths.is_far(by_distance)
        dimensions = 3 if isinstance(tested, TestedStates) else 2
        rows.append(_band_row(each.name, roles[each.name], each.errors, band, far, dimensions))
    return rows + (_left_out_rows(kept, tested) if isinstance(tested, IdentifiedStates) else [])


def _band_row(name: str, role: str, errors: Array, band: Array, far: NDArray[np.bool_], dimensions: int) -> BandRow:
    shares = percent_within(errors, band), ball_rms_z(errors, band, dimensions)
    return BandRow(name, role, *shares, 1e3 * float(band.mean()), 100 * float(far.mean()))


def _left_out_rows(kept: FittedStatesConfig, identified: IdentifiedStates) -> list[BandRow]:
    """How the markers of fitted rows lie in their bands, each by a fit without its family, and away from the others."""
    fitted = identified.states[: len(identified.left_out)]
    states, count = np.concatenate([_pulled(each) for each in fitted]), 0
    size = np.linalg.norm(np.concatenate(identified.errors[: len(fitted)]), axis=-1)
    rows = []
    for each, errors in zip(fitted, identified.left_out, strict=True):
        own, count = np.arange(count, count + len(errors)), count + len(errors)
        away, bands, far = [], [], []
        for family in sorted({*each.families} - {""}):
            of_family = own[each.families == family]
            kept_rows = np.setdiff1d(np.flatnonzero(np.isfinite(size).all(axis=1)), of_family)
            others = FittedStates(states[kept_rows], kept.fitted.spread)
            by_distance = np.sqrt(others.distance(states[of_family]))[:, None]
            near = others.local_size(size[kept_rows])[others.nearest(states[of_family])]
            bands.append(near * kept.widths.band(by_distance))
            away.append(np.linalg.norm(errors[of_family - own[0]], axis=-1))
            far.append(kept.widths.is_far(by_distance))
        if bands:
            of_all = np.concatenate(away), np.concatenate(bands), np.concatenate(far)
            rows.append(_band_row(each.name, LEFT_OUT, *of_all, dimensions=3))
    return rows


def are_far(kept: FittedStatesConfig, states: SettledStates) -> NDArray[np.bool_]:
    """Which rows are far from what the finger was fitted to, (R,)."""
    return kept.widths.is_far(np.sqrt(kept.fitted.distance(_pulled(states)))[:, None]).any(axis=1)


def extrapolations(rows: Sequence[BandRow]) -> list[str]:
    """Recordings that are far from what was fitted, as text."""
    return [
        f"{row.recording}: {row.far_percent:.0f} % of it is far from what was fitted"
        for row in rows
        if row.far_percent and row.role != LEFT_OUT
    ]


def _of_states(tested: TestedStates) -> Iterator[_Driven]:
    for states, errors in zip(tested.states, tested.errors, strict=True):
        yield _Driven(states.name, _pulled(states), np.linalg.norm(errors, axis=-1), 1.0)


def _pulled(states: SettledStates) -> Array:
    return np.column_stack([states.pulled, np.full(len(states.pulled), states.load)])


def _of_motions(tested: Tested, every: int, known: ConfidenceConfig | None = None, run: Run = map) -> Iterator[_Driven]:
    """Errors of motions; of a fit as shares of the largest displacement that was measured, as it takes them."""
    motions = {motion.name: motion for motion in reversed(tested.motions)}.values()
    for motion in tqdm(motions, desc="markers", unit="recording", dynamic_ncols=True):
        simulated = simulated_markers(tested.model.finger, tested.model.setup, motion)
        errors = np.abs(simulated - motion.markers)[::every]
        scale = float(np.abs(np.mean(simulated - motion.reference, axis=1)).max())
        states, by_keys = np.tile(_driven(motion), (len(errors), 1)), np.zeros(errors.shape)
        if known is not None:
            deviations = marker_deviations(known.free(tested.model), known.covariance, motion, run)
            by_keys = ball_radius(as_points(deviations[:, ::every]))
        yield _Driven(motion.name, states, errors, scale, by_keys)


def _driven(motion: MeasuredMotion) -> Array:
    return np.array([motion.pressure or 0.0, motion.load.mass if motion.load else 0.0])
