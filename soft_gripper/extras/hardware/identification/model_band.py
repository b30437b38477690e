"""Bands of the markers of an identified finger, and recordings that leave the states that it was fitted to.

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

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from operator import attrgetter
from typing import Annotated, NamedTuple

import numpy as np
from numpy.typing import NDArray
from tqdm import tqdm

from soft_gripper.arrays import Array
from soft_gripper.extras.hardware.fitted_range import (
    COVERAGE,
    LeftOut,
    kept_states,
    learned_widths,
    regions_left_out,
)
from soft_gripper.extras.hardware.identification.companion_file import CompanionFile
from soft_gripper.extras.hardware.identification.confidence import UNOBSERVABLE, ConfidenceConfig, square_root
from soft_gripper.extras.hardware.identification.fit import MotionScore, Run, fit_confidence, marker_deviations
from soft_gripper.extras.hardware.identification.identified_finger import Identified, Tested
from soft_gripper.extras.hardware.identification.settled_states import (
    IdentifiedStates,
    SettledStates,
    StateScore,
    TestedStates,
)
from soft_gripper.extras.hardware.identification.simulated_motion import simulated_markers
from soft_gripper.extras.hardware.scoring import LEFT_OUT, ball_radius, ball_rms_z, percent_within
from soft_gripper.files.document import require
from soft_gripper.fingers.kinematics import as_points
from soft_gripper.scenario.fitted_states_config import FittedStatesConfig
from soft_gripper.sensors.fitted_states import FittedStates, spread_of

STATES = CompanionFile(
    ".states.yaml",
    "The states that a finger was fitted to, and how its errors grow away from them, for `--test`",
    FittedStatesConfig,
)
_LOAD_UNIT = 0.1  # kg, unit of loads: recordings often have a single one
_MAX_KEPT = 2000  # states: a dozen tendons make a space in which few states are all far from each other
_SAMPLE_STRIDE = 5  # one sample of a motion in so many counts


@dataclass(frozen=True)
class BandRow:
    """Markers of a recording and their 95 % bands."""

    recording: str
    role: str
    within_band_percent: Annotated[float, ".1f"]
    rms_z: Annotated[float, ".2f"]  # errors along an axis over their standard deviations, root mean square: 1 is right
    band_mm: Annotated[float, ".2f"]  # mean radius
    far_percent: Annotated[float, ".1f"]  # rows, or samples, that are far from what was fitted


class _MarkerErrors(NamedTuple):
    """T rows or samples of a recording."""

    name: str
    states: Array  # (T, D)
    errors: Array  # (T, M) m, of the markers; NaN where one is not seen
    scale: float = 1.0  # m, of errors: the largest displacement, or 1
    key_widths: Array | float = 0.0  # (T, M) m, half widths that the covariance of the keys gives


def learned_band(identified: Identified | IdentifiedStates) -> FittedStatesConfig:
    """The states that a finger was fitted to, and the band of its markers."""
    fit, is_local = identified.fit, isinstance(identified, IdentifiedStates)
    if isinstance(identified, IdentifiedStates):  # errors differ between the states, and no covariance is counted
        recording_count = len(identified.left_out)
        recordings = [*map(_state_errors, identified.states[:recording_count], identified.errors[:recording_count])]
        errors, components = np.concatenate([recording.errors for recording in recordings]), 3
        states = np.concatenate([recording.states for recording in recordings])
        residual_scales: Array | float = 1.0
    else:  # an error is that of a marker, over the largest displacement
        recordings = [*_motion_errors(Tested(identified.model, identified.fit.recordings, ()), stride=1)]
        sizes = [recording.errors.size for recording in recordings]
        errors = np.concatenate([(recording.errors / recording.scale).reshape(-1, 1) for recording in recordings])
        states = np.concatenate([np.repeat(one.states, one.errors.shape[1], axis=0) for one in recordings])
        residual_scales, components = np.concatenate([np.full(2 * size, np.sqrt(size)) for size in sizes]), 2
    is_seen, residual_count = np.isfinite(errors).all(axis=1), errors.shape[1] * components
    units = np.append(np.full(states.shape[-1] - 1, spread_of(states[:, :-1])), _LOAD_UNIT)
    floor = np.nanquantile(errors, COVERAGE)

    def local_sizes(rows: NDArray[np.bool_]) -> Array:
        """Sizes of the errors near some of the samples."""
        if not is_local:
            return np.ones((int(rows.sum()), errors.shape[1]))
        return FittedStates(states[rows], units).local_size(errors[rows])

    def changed_errors(unknown_change: Array, rows: NDArray[np.bool_]) -> Array:
        residuals = (fit.residuals + fit.slopes @ unknown_change) * residual_scales
        return np.linalg.norm(residuals.reshape(*errors.shape, components), axis=-1)[rows]

    def key_widths(kept: NDArray[np.bool_]) -> Array:
        """Half widths by the keys of a fit to some of the residuals, (n, K)."""
        assert isinstance(identified, Identified)
        changes = fit.slopes @ square_root(fit_confidence(identified.fit, kept).covariance)
        return ball_radius((changes.T * residual_scales).reshape(-1, *errors.shape, components))

    def leave_out(region: NDArray[np.bool_]) -> LeftOut:
        left_out = np.zeros(len(states), bool)
        left_out[np.flatnonzero(is_seen)[region]] = True
        unknown_change = fit.change_without(np.repeat(~left_out, residual_count), UNOBSERVABLE, fit.free.scales)
        kept = is_seen & ~left_out
        fitted_states = FittedStates(states[kept], units)
        size = local_sizes(kept)[fitted_states.nearest(states[left_out])]
        if not is_local:
            size = np.hypot(size, key_widths(np.repeat(kept, residual_count))[left_out] / floor)
        distance = np.sqrt(fitted_states.distance(states[left_out]))[:, None] * np.ones(size.shape[1])
        return LeftOut(changed_errors(unknown_change, left_out) / size, distance)

    all_states, size = FittedStates(states[is_seen], units), local_sizes(is_seen)
    relative_errors = changed_errors(np.zeros(len(fit.x)), is_seen) / size
    divisions = [
        [*tqdm(regions_left_out([regions], leave_out), desc="bands", unit="region", dynamic_ncols=True)]
        for regions in (all_states.regions(), all_states.halves())
    ]
    widths = max((learned_widths(relative_errors, left_out) for left_out in divisions), key=attrgetter("growth"))
    drive_names = [f"{tendon.name} [m]" for tendon in identified.model.finger.tendons] or ["pressure [Pa]"]
    names = [*drive_names[: states.shape[-1] - 1], "load [kg]"]
    return kept_states(names, all_states, widths, sizes=size if is_local else None, most=_MAX_KEPT)


def band_rows(
    kept: FittedStatesConfig, tested: Tested | TestedStates, confidence: ConfidenceConfig | None = None, run: Run = map
) -> list[BandRow]:
    """Positions of the markers of recordings in the kept bands, which a confidence in the keys widens in motions.

    `run` calls a function with every one of its arguments, as `map` does, or that of an executor.
    """
    fitted, widths = kept.fitted, kept.widths
    scores: Sequence[MotionScore | StateScore] = tested.scores
    roles = {score.recording: score.role for score in reversed(scores)}
    recordings: Iterable[_MarkerErrors]
    if isinstance(tested, TestedStates):
        recordings, dimensions = map(_state_errors, tested.states, tested.errors), 3
    else:
        recordings, dimensions = _motion_errors(tested, _SAMPLE_STRIDE, confidence, run), 2
    rows = []
    for name, states, errors, scale, key_widths in recordings:
        expected = f"its states have {states.shape[-1]} numbers: is it of another finger?"
        require(len(kept.spread) == states.shape[-1], name, "states", len(kept.spread), expected)
        expected = f"its recording has {errors.shape[1]} markers: is it of another finger?"
        require(len(kept.floor) in (1, errors.shape[1]), name, "floor", len(kept.floor), expected)
        distance = np.sqrt(fitted.distance(states))[:, None]
        band = widths.band(distance) * np.hypot(scale * kept.sizes_near(states), key_widths / widths.floor)
        rows.append(_band_row(name, roles[name], errors, band, widths.is_far(distance), dimensions))
    return rows + (_left_out_rows(kept, tested) if isinstance(tested, IdentifiedStates) else [])


def _band_row(name: str, role: str, errors: Array, band: Array, far: NDArray[np.bool_], dimensions: int) -> BandRow:
    percentages = percent_within(errors, band), ball_rms_z(errors, band, dimensions)
    return BandRow(name, role, *percentages, 1e3 * float(band.mean()), 100 * float(far.mean()))


def _left_out_rows(kept: FittedStatesConfig, identified: IdentifiedStates) -> list[BandRow]:
    """Markers of fitted rows in their bands, each by a fit without its family, and away from the others."""
    recordings = identified.states[: len(identified.left_out)]
    states, first_row = np.concatenate([_driven_states(recording) for recording in recordings]), 0
    size = np.linalg.norm(np.concatenate(identified.errors[: len(recordings)]), axis=-1)
    rows = []
    for recording, left_out in zip(recordings, identified.left_out, strict=True):
        errors, bands, far = [], [], []
        for family in sorted({*recording.families} - {""}):
            is_family = recording.families == family
            family_rows = first_row + np.flatnonzero(is_family)
            kept_rows = np.setdiff1d(np.flatnonzero(np.isfinite(size).all(axis=1)), family_rows)
            other_states = FittedStates(states[kept_rows], kept.fitted.spread)
            distance = np.sqrt(other_states.distance(states[family_rows]))[:, None]
            local_size = other_states.local_size(size[kept_rows])[other_states.nearest(states[family_rows])]
            bands.append(local_size * kept.widths.band(distance))
            errors.append(np.linalg.norm(left_out[is_family], axis=-1))
            far.append(kept.widths.is_far(distance))
        first_row += len(left_out)
        if bands:
            all_rows = np.concatenate(errors), np.concatenate(bands), np.concatenate(far)
            rows.append(_band_row(recording.name, LEFT_OUT, *all_rows, dimensions=3))
    return rows


def far_rows(kept: FittedStatesConfig, states: SettledStates) -> NDArray[np.bool_]:
    """Mask of the rows far from the fitted states, (R,)."""
    return kept.widths.is_far(np.sqrt(kept.fitted.distance(_driven_states(states)))[:, None]).any(axis=1)


def extrapolations(rows: Sequence[BandRow]) -> list[str]:
    """Texts that name recordings far from the fitted states."""
    return [
        f"{row.recording}: {row.far_percent:.0f} % of it is far from what was fitted"
        for row in rows
        if row.far_percent and row.role != LEFT_OUT
    ]


def _state_errors(states: SettledStates, errors: Array) -> _MarkerErrors:
    return _MarkerErrors(states.name, _driven_states(states), np.linalg.norm(errors, axis=-1))


def _driven_states(states: SettledStates) -> Array:
    return np.column_stack([states.pulled, np.full(len(states.pulled), states.load)])


def _motion_errors(
    tested: Tested, stride: int, confidence: ConfidenceConfig | None = None, run: Run = map
) -> Iterator[_MarkerErrors]:
    """Errors of motions, m, with the scale of each recording: its largest displacement, m."""
    motions = {motion.name: motion for motion in reversed(tested.motions)}.values()
    for motion in tqdm(motions, desc="markers", unit="recording", dynamic_ncols=True):
        simulated_positions = simulated_markers(tested.model.finger, tested.model.setup, motion)
        errors = np.abs(simulated_positions - motion.markers)[::stride]
        scale = float(np.abs(np.mean(simulated_positions - motion.reference, axis=1)).max())
        state = motion.pressure or 0.0, motion.load.mass if motion.load else 0.0
        key_widths = np.zeros(errors.shape)
        if confidence is not None:
            deviations = marker_deviations(confidence.parameters(tested.model), confidence.covariance, motion, run)
            key_widths = ball_radius(as_points(deviations[:, ::stride]))
        yield _MarkerErrors(motion.name, np.tile(state, (len(errors), 1)), errors, scale, key_widths)
