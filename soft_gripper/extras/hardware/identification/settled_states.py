"""Fits parameters of a finger to recorded states at rest: pulled lengths (R, T) and markers (R, M, 3) -> parameters.

A row of such a recording has the pulled length of each tendon, and the resting positions of markers. The finger
of a model rests where its springs, weight and tendons balance (`tendon_balance`). Dry friction makes its bend lag:
it follows the balance only as far as this is more than the friction away (play operator; Visintin, *Differential Models
of Hysteresis*, 1994, chapter III), in the order of the rows. Backlash makes the pulled lengths lag behind the motors in
the same way, at all times of the recording, since motors turn back between two rows too. The base of the finger
in a recording is unknown, so predicted markers are shifted by their mean distance from measured ones.

A fit minimises the distances of predicted and measured markers; large ones count less than by their squares, because
tendons that stick or slip off are not part of the model. Derivatives by the markers' places are exact, those of joint
positions by the parameters are finite differences, which need no kinematics.
"""

from collections.abc import Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, replace
from typing import Annotated

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import ArrayLike, NDArray

from soft_gripper.arrays import Array
from soft_gripper.errors import InputError
from soft_gripper.extras.hardware.identification.confidence import (
    Confidence,
    confidence_of,
    fit_doubts,
    mean_correlation_time,
)
from soft_gripper.extras.hardware.identification.free_parameters import (
    FingerFit,
    FreeParameters,
    Model,
    free_parameters,
)
from soft_gripper.extras.hardware.identification.simulated_motion import Setup
from soft_gripper.extras.hardware.identification.tendon_balance import pulled_positions
from soft_gripper.extras.hardware.least_squares import Problem, Report, fit, no_report
from soft_gripper.extras.hardware.progress import wait_for
from soft_gripper.extras.hardware.recordings import HardwareRecording
from soft_gripper.extras.hardware.scoring import FITTED, LEFT_OUT, TESTED, error_columns, leave_groups_out
from soft_gripper.extras.hardware.text_pattern import find
from soft_gripper.files.document import require, require_value
from soft_gripper.files.notes import LEFT_OUT as LEFT_OUT_OF_FILE
from soft_gripper.files.notes import note
from soft_gripper.fingers.finger import Finger
from soft_gripper.fingers.finger_parts import TipLoad
from soft_gripper.fingers.spatial_chain import posture, spatial_chain
from soft_gripper.pictures.style import ESTIMATOR_COLORS, STYLE

_DIFFERENCE_STEP = 0.02  # step of the finite differences, in typical changes
_HUBER_DISTANCE = 0.02  # of the finger's length: distances of markers beyond this count less than by their squares
_TOLERANCE = 2e-4  # relative, of the cost
_MAX_STEPS = 60
_JITTER = 1.0  # typical changes, standard deviation of the random restarts
_WINDING_INSTANTS = 10  # instants with pulled lengths, from one row to the next
_ALL_ROWS = "all"  # name of all rows, or all markers
_SLACK_LENGTHS = 10.0  # lengths of the finger, by which a tendon is let out to be slack
_SLACK_MOTION = 1e-3  # of the finger's length: a tendon is slack if no marker moves further without it


@dataclass(frozen=True)
class SettledStates:
    """Rows of a recording, in their order."""

    name: str
    pulled: Array  # (R, T) m, of every tendon of the finger
    markers: Array  # (R, M, 3) m in B
    places: Array  # (M, 3) m, of the markers in the frame of the tip, or of their station
    families: NDArray[np.str_]  # (R,) names; empty where a row belongs to none
    gravity: Array  # (3,) m/s^2 in B
    marker_stations: Array | None = None  # (M,) arc lengths of the markers over the finger's; None: all at the tip
    load: float = 0.0  # kg, hung on the tip
    time: Array | None = None  # (R,) s; None: unknown
    names: tuple[str, ...] = ()  # of the markers; empty: they have none
    winding: tuple[Array, Array] | None = None  # (K,) s, (K, T) m: pulled lengths between the rows; None: unknown

    def delayed_lengths(self, delay: float, backlash: float) -> Array:
        """Pulled lengths of motors with a backlash, m, at a delay, s, before the rows, (R, T) m."""
        if self.winding is None or self.time is None:
            return _apply_backlash(self.pulled, backlash)
        if delay == backlash == 0:
            return self.pulled
        time, wound_lengths = self.winding
        pulled_lengths = _apply_backlash(wound_lengths, backlash).T
        return np.stack([np.interp(self.time - delay, time, tendon) for tendon in pulled_lengths], axis=-1)


def settled_states(recording: HardwareRecording, finger: Finger) -> SettledStates:
    """Selects the rows of a recording with all markers, for a finger with the tendons that it describes."""
    config, name = recording.config, recording.name
    expected = "describe the markers on the tip, and their places there"
    if config.poses and config.markers is None:
        expected = "places of markers are read, not poses: name the columns of a position as those of a marker"
    markers = require_value(config.markers, name, "markers", expected)
    require(len(markers.places) > 0, name, "markers.places", {}, "give at least one marker on the tip and its place")
    expected = "describe the columns of pulled lengths"
    if recording.pressures is not None:
        expected = "settled states are of tendons: describe a file for each constant pressure, with event: step"
    require(len(recording.pulled) > 0, name, "tendons", None, expected)
    names = [tendon.name for tendon in finger.tendons]
    if sorted(names) != sorted(recording.pulled):
        expected = f"name the tendons of the finger '{finger.name}': {', '.join(names) or 'it has none'}"
        raise InputError(name, "tendons.columns", ", ".join(recording.pulled), expected)
    for tendon in finger.tendons:
        expected = "give a first guess: a tendon that is commanded in length is a spring"
        require(tendon.stiffness > 0, f"finger '{finger.name}'", f"{tendon.name}.stiffness", 0.0, expected)
    pulled_lengths = np.stack([recording.pulled[tendon] for tendon in names], axis=-1)
    points = np.stack([recording.markers[marker] for marker in markers.places], axis=1)
    is_whole: NDArray[np.bool_] = np.isfinite(pulled_lengths + points.sum(axis=(1, 2))[:, None]).all(axis=1)
    row_count = int(is_whole.sum())
    require(row_count > config.every, name, "rows", row_count, "at least 2 need all tendons and markers")
    pattern = config.labels.family if config.labels else "(.*)"
    families = np.array([_family(label, pattern) for label in recording.labels or [""] * len(is_whole)])
    row_number = np.arange(len(is_whole))
    if config.blocks > 1 and config.labels is None:
        families = np.array([f"block {block}" for block in row_number * config.blocks // len(row_number) + 1])
    is_wound = np.isfinite(pulled_lengths).all(axis=1) & (row_number % max(config.every // _WINDING_INSTANTS, 1) == 0)
    is_used = is_whole & (row_number % config.every == 0)
    return SettledStates(
        name=name,
        pulled=pulled_lengths[is_used],
        markers=points[is_used],
        places=np.array(list(markers.places.values())),
        families=families[is_used],
        gravity=np.zeros(3) if recording.gravity is None else recording.gravity,
        marker_stations=np.array([markers.at.get(name, 1.0) for name in markers.places]),
        load=recording.load_mass,
        time=recording.time[is_used],
        names=tuple(markers.places),
        winding=(recording.time[is_wound], pulled_lengths[is_wound]),
    )


def _family(label: str, pattern: str) -> str:
    """Match of a label with the first fitting alternative of a pattern; the whole label without a pattern."""
    matches = (find(alternative, label) for alternative in pattern.split("|"))
    return next((match[0] for match in matches if match), "") if pattern else label


def resting_positions(model: Model, states: SettledStates) -> Array:
    """Joint positions of a finger in its set-up in every row, (R, J) rad, or m where joints slide.

    A row in which it finds no balance is NaN.
    """
    pulled_lengths = states.delayed_lengths(model.setup.delay, model.setup.backlash)
    q = pulled_positions(_load_tip(model.finger, states.load), pulled_lengths, states.gravity)
    if model.setup.dry_friction == 0:
        return q
    deformations = np.array(spatial_chain(model.finger).deformations)
    bends = deformations == "bending", *([deformations == "sideways"] if "sideways" in deformations else [])
    friction_lag = model.setup.dry_friction / model.finger.segments
    lagged_positions = _apply_friction(np.stack([q[:, bend] for bend in bends], axis=-1), friction_lag)
    q = q.copy()
    for i, bend in enumerate(bends):
        q[:, bend] = lagged_positions[..., i]
    return q


def _apply_backlash(wound: Array, backlash: float) -> Array:
    """Applies the play operator of a backlash, m, to each wound length, (K, T) m."""
    if backlash == 0:
        return wound
    pulled_lengths, position = np.empty_like(wound), wound[:1]
    for row, (lower_end, upper_end) in enumerate(zip(wound - backlash, wound + backlash, strict=True)):
        pulled_lengths[row] = position = np.clip(position, lower_end, upper_end)
    return pulled_lengths


def _load_tip(finger: Finger, mass: float) -> Finger:
    """Adds a point mass, kg, in the middle of a finger's tip; 0: none."""
    if mass == 0:
        return finger
    require(finger.tip_load is None, f"finger '{finger.name}'", "tip_load", "", "leave it out: the recording names one")
    return replace(finger, tip_load=TipLoad(mass, 0.0, 0.0))


def _apply_friction(targets: Array, lag: float) -> Array:
    """Applies the play operator of a lag to vectors, (R, N, 2) or (R, N, 1), rad; skips NaN."""
    positions, rows = np.full(targets.shape, np.nan), np.flatnonzero(np.isfinite(targets).all(axis=(1, 2)))
    position = targets[rows[0]] if len(rows) else targets[:0]
    for row in rows:
        target = targets[row]
        difference = target - position
        distance = np.sqrt((difference**2).sum(axis=-1, keepdims=True))
        position = position + difference * np.maximum(0.0, 1 - lag / np.maximum(distance, lag))
        positions[row] = position
    return positions


def predicted_markers(finger: Finger, states: SettledStates, q: Array) -> tuple[Array, Array]:
    """Markers of a finger at joint positions (R, J): (R, M, 3) m in its frame; derivatives by these, (R, J, M, 3)."""
    chain = spatial_chain(finger)
    bent_chain = posture(chain, q)
    fractions = np.ones(len(states.places)) if states.marker_stations is None else states.marker_stations
    stations = finger.length * fractions
    joint_counts = np.searchsorted(finger.joint_arc_lengths, stations)  # joints between the base and each marker
    frames, joint_s = chain.link_frames(joint_counts), np.concatenate([[0.0], finger.joint_arc_lengths])[joint_counts]
    places = states.places + np.outer(stations - joint_s, [0.0, 0.0, 1.0])
    markers = bent_chain.origins[:, frames] + (bent_chain.rotations[:, frames] @ places[..., None])[..., 0]
    rotations, translations = bent_chain.screws[..., None, :3], bent_chain.screws[..., None, 3:]
    is_moved = (frames > np.arange(len(chain.deformations))[:, None])[..., None]
    return markers, is_moved * (np.cross(rotations, markers[:, None]) + translations)


def state_errors(model: Model, states: SettledStates, rows: NDArray[np.bool_] | None = None) -> Array:
    """Predicted minus measured markers, (R, M, 3) m, their mean over the rows that are true in `rows` removed.

    A row in which the finger finds no balance is NaN.
    """
    errors = predicted_markers(model.finger, states, resting_positions(model, states))[0] - states.markers
    return _center(errors, errors if rows is None else errors[rows])


def _center(vectors: Array, others: Array) -> Array:
    """Subtracts the mean of others, (R, M, 3), from vectors (..., M, 3); rows that are NaN do not count."""
    balanced_vectors = others[balanced_rows(others)]
    return vectors - balanced_vectors.mean(axis=(0, 1)) if len(balanced_vectors) else vectors


def balanced_rows(errors: Array) -> NDArray[np.bool_]:
    """Mask of the rows in which the finger finds a balance, (R,), from their errors, (R, M, 3)."""
    return np.isfinite(errors).all(axis=(1, 2))


Rows = Sequence[NDArray[np.bool_]]  # (R,) each: mask of the fitted rows of a recording


def fit_states(
    free: FreeParameters,
    recordings: Sequence[SettledStates],
    rows: Rows | None = None,
    report: Report = no_report,
    starts: ArrayLike | None = None,
) -> FingerFit[SettledStates]:
    """Fits free parameters to the rows of recordings that are true in `rows`, None for all, from vectors (K, P).

    A row in which the finger finds no balance counts as if its markers were off by the finger's length, so that the
    search does not seek such fingers, and has no slope.
    """
    length = free.model.finger.length
    masks = rows or [np.full(len(states.pulled), True) for states in recordings]
    pairs = [*zip(recordings, masks, strict=True)]

    def residuals(x: Array) -> Array:
        try:
            model = free.build_model(x)
            errors = [state_errors(model, states, mask)[mask].ravel() for states, mask in pairs]
        except InputError:  # a step of the search may lead to an impossible finger
            errors = [np.full(states.markers[mask].size, length) for states, mask in pairs]
        return np.concatenate(errors)

    def slopes(x: Array, residuals: Array) -> Array:
        return np.concatenate([marker_slopes(free, x, *pair) for pair in pairs])

    problem = Problem(
        free.build_model,
        residuals,
        slopes,
        outlier=_HUBER_DISTANCE * length,
        missing=length,
        bounds=free.bounds,
        error=lambda residuals: _rms_distance(residuals[np.isfinite(residuals)].reshape(-1, 3)) / length,
        options={"x_scale": free.scales, "ftol": _TOLERANCE, "xtol": _TOLERANCE, "max_nfev": _MAX_STEPS},
    )
    solution = fit(problem, free.start if starts is None else starts, report)
    return FingerFit(**vars(solution), free=free, recordings=tuple(recordings))


def marker_slopes(free: FreeParameters, x: Array, states: SettledStates, rows: NDArray[np.bool_]) -> Array:
    """Derivatives of the residuals of one recording by the free parameters, (K, P); 0 in rows without a balance."""
    model = free.build_model(x)
    q = resting_positions(model, states)
    markers, joint_slopes = predicted_markers(model.finger, states, q)
    columns = []
    for step in np.diag(free.steps(x, _DIFFERENCE_STEP)):
        changed = free.build_model(x + step)
        if changed.finger.length != model.finger.length:  # which alone changes the markers where the joints stand still
            slope = predicted_markers(changed.finger, states, resting_positions(changed, states))[0] - markers
        else:
            slope = np.einsum("rj,rjmi->rmi", resting_positions(changed, states) - q, joint_slopes)
        slope = slope[rows] / step.sum()
        columns.append(np.nan_to_num(_center(slope, slope)).ravel())
    return np.stack(columns, axis=-1)


def slack_tendons(model: Model, recordings: Sequence[SettledStates]) -> list[str]:
    """Names of the tendons without which no marker moves in any row with a balance."""
    finger, setup = model.finger, model.setup

    def markers(states: SettledStates, slack: int | None = None) -> Array:
        pulled_lengths = states.delayed_lengths(setup.delay, setup.backlash).copy()
        pulled_lengths[:, [] if slack is None else [slack]] = -_SLACK_LENGTHS * finger.length
        q = pulled_positions(_load_tip(finger, states.load), pulled_lengths, states.gravity)
        return predicted_markers(finger, states, q)[0]

    pairs = [(states, markers(states)) for states in recordings]
    if not any(balanced_rows(places).any() for _, places in pairs):
        return []

    def is_slack(tendon: int) -> bool:
        changes = [(markers(states, tendon) - places)[balanced_rows(places)] for states, places in pairs]
        limit = _SLACK_MOTION * finger.length  # what buckles without a tendon is NaN, and needs it
        return bool((np.linalg.norm(np.concatenate(changes), axis=-1) <= limit).all())

    return [tendon.name for i, tendon in enumerate(finger.tendons) if is_slack(i)]


def note_unbalanced(states: SettledStates, errors: Array) -> None:
    """Notes rows in which the finger finds no balance, by their errors, (R, M, 3)."""
    for row in np.flatnonzero(~balanced_rows(errors)):
        row_name = f"row {row + 1} of those used" if states.time is None else f"row at {states.time[row]:.6g} s"
        reason = "the finger finds no shape in balance with its tendons and its weight"
        note(LEFT_OUT_OF_FILE, states.name, row_name, "", reason)


def _rms_distance(errors: Array) -> float:
    """Root mean square of the lengths of vectors (..., 3)."""
    return float(np.sqrt((errors**2).sum(axis=-1).mean()))


@dataclass(frozen=True)
class StateScore:
    """A row of the table: marker errors of one recording, or of some of its rows, their mean removed."""

    recording: str
    role: str  # FITTED, LEFT_OUT of the fit that is scored, or TESTED
    family: str  # "all": all rows; or the family
    marker: str  # "all"; or its name, if there are several
    rows: int
    rms_mm: Annotated[float, ".2f"]
    mean_mm: Annotated[float, ".2f"]
    percentile_95_mm: Annotated[float, ".2f"]


@dataclass(frozen=True)
class TestedStates:
    """Recordings compared with a finger."""

    model: Model  # the finger in its set-up
    states: tuple[SettledStates, ...]
    errors: tuple[Array, ...]  # of the same, (R, M, 3) m
    scores: tuple[StateScore, ...]


@dataclass(frozen=True)
class IdentifiedStates(TestedStates):
    """The result of a fit: the recordings that were fitted, then those held out."""

    left_out: tuple[Array, ...]  # errors of the fitted ones by fits without the row's family; NaN where it has none
    fit: FingerFit[SettledStates]
    confidence: Confidence


def identify_states(
    finger: Finger,
    names: Sequence[str],
    fitted: Sequence[SettledStates],
    tested: Sequence[SettledStates],
    executor: Executor,
    starts: int = 1,
    seed: int = 0,
    report: Report = no_report,
    setup: Setup | None = None,
) -> IdentifiedStates:
    """Fits keys of a finger to settled states, and tests the result on others and on families left out of the fit.

    Arguments are those of `identify`; only the placement of tested recordings is fitted.
    """
    free = free_parameters(finger, names, [], setup)
    tendons = [tendon.name for tendon in finger.tendons]
    if len(slack_tendons(free.model, fitted)) == len(tendons):
        expected = "no row tightens any of them: do they pull the other way, or is their slack too large?"
        raise InputError(fitted[0].name, "tendons", ", ".join(tendons), expected)
    best_fit = fit_states(free, fitted, report=report, starts=free.starts(starts, seed, _JITTER))
    fits, tests = _compare(best_fit.model, fitted, FITTED), compare_states(best_fit.model, tested)
    correlated_rows = mean_correlation_time(balanced_series(fits.errors))
    confidence = confidence_of(free, best_fit.x, best_fit.residuals, best_fit.slopes, correlated_rows)
    left_out = _family_errors(best_fit, names, [key.name for key in confidence.undetermined], fitted, executor)
    scores = list(fits.scores)
    for recording, error in zip(fitted, left_out, strict=True):
        families = [name for name in sorted(set(recording.families)) if name]
        for name in families:
            scores += _scores(recording, LEFT_OUT, name, error[recording.families == name])
        scores += _scores(recording, LEFT_OUT, _ALL_ROWS, error[recording.families != ""]) if families else []
    states, errors = fits.states + tests.states, fits.errors + tests.errors
    return IdentifiedStates(best_fit.model, states, errors, (*scores, *tests.scores), left_out, best_fit, confidence)


def balanced_series(errors: Sequence[Array]) -> list[Array]:
    """Errors of recordings, (R, M, 3), as series of the rows with a balance."""
    return [error[balanced_rows(error)].reshape(-1, error[0].size) for error in errors]


def compare_states(model: Model, states: Sequence[SettledStates]) -> TestedStates:
    """Compares recordings with a finger in its set-up; only their placement is fitted."""
    return _compare(model, states, TESTED)


def _compare(model: Model, states: Sequence[SettledStates], role: str) -> TestedStates:
    errors, scores = tuple(state_errors(model, run) for run in states), list[StateScore]()
    for run, error in zip(states, errors, strict=True):
        note_unbalanced(run, error)
        scores += _scores(run, role, _ALL_ROWS, error)
    return TestedStates(model, tuple(states), errors, tuple(scores))


def state_doubts(identified: IdentifiedStates) -> list[str]:
    """Warnings about a fit to settled states, and about tendons that no row tightens."""
    slack = slack_tendons(identified.model, identified.states[: len(identified.left_out)])
    doubts = [f"no row tightens {', '.join(slack)}: do they pull the other way?"] if slack else []
    return fit_doubts(identified.fit, identified.confidence) + doubts


def _family_errors(
    best: FingerFit[SettledStates],
    names: Sequence[str],
    undetermined: Sequence[str],
    fitted: Sequence[SettledStates],
    executor: Executor,
) -> tuple[Array, ...]:
    """Errors of every row by a fit without its family, whose placement is fitted separately, (R, M, 3) m.

    The fits begin with the best one. Its undetermined parameters stay as they are; if that is all of them, the
    best one predicts them.
    """
    fitted_rows = leave_groups_out([states.families for states in fitted])
    all_errors = tuple(np.full(states.markers.shape, np.nan) for states in fitted)
    if len(fitted_rows) < 2:
        return all_errors
    model = best.model
    futures = [executor.submit(_fit_rest, model, names, undetermined, fitted, rows) for rows in fitted_rows]
    wait_for(futures, "left out", "family")
    for rows, future in zip(fitted_rows, futures, strict=True):
        for errors, states, row_mask in zip(all_errors, fitted, rows, strict=True):
            errors[~row_mask] = state_errors(future.result(), states, ~row_mask)[~row_mask]
    return all_errors


def _fit_rest(
    model: Model, names: Sequence[str], undetermined: Sequence[str], fitted: Sequence[SettledStates], rows: Rows
) -> Model:
    free = free_parameters(model.finger, names, [], model.setup)
    free = free.fix(free.start, undetermined)
    return fit_states(free, fitted, rows).model if free.names else free.model


def _scores(states: SettledStates, role: str, family: str, errors: Array) -> list[StateScore]:
    """Scores of all markers together, and of each one of several, over the rows with a balance."""
    errors = errors[balanced_rows(errors)]
    if not len(errors):
        return []
    distances = 1e3 * np.linalg.norm(_center(errors, errors), axis=-1)
    marker_distances = {_ALL_ROWS: distances}
    if len(states.names) > 1:
        marker_distances |= dict(zip(states.names, distances.T, strict=True))
    columns = "rms_mm", "mean_mm", "percentile_95_mm"
    return [
        StateScore(states.name, role, family, marker, len(errors), **error_columns(values, *columns))
        for marker, values in marker_distances.items()
    ]


_WIDTH, _HEIGHT = 3.0, 2.8  # inches, of a panel
_VIEW_AXES = ((0, 1), (0, 2))  # axes of B: from the tip, and from the side


def states_figure(tested: TestedStates) -> Figure:
    """Plots positions of the last marker, measured and predicted, along the finger and from the side.

    Each recording has a row, with the distribution of the errors at the end.
    """
    count = len(tested.states)
    with plt.rc_context(STYLE):
        size = 3 * _WIDTH, count * _HEIGHT
        figure, axes = plt.subplots(count, 3, figsize=size, squeeze=False, constrained_layout=True)
        fitted = tested.left_out if isinstance(tested, IdentifiedStates) else ()
        left_out: list[Array | None] = [*fitted, *[None] * count]
        for row, states, errors, left_out_errors in zip(axes, tested.states, tested.errors, left_out, strict=False):
            for panel, (i, j) in zip(row, _VIEW_AXES, strict=False):
                _draw_places(panel, states.markers[:, -1], errors[:, -1], i, j)
            _draw_errors(row[2], errors, "held out" if left_out_errors is None else "fitted", ESTIMATOR_COLORS[2])
            if left_out_errors is not None and balanced_rows(left_out_errors).any():
                _draw_errors(row[2], left_out_errors, "left out", ESTIMATOR_COLORS[5])
            row[0].set_title(states.name)
            row[1].legend(frameon=False, markerscale=3, loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=2)
            row[2].set(xlabel="error [mm]", ylabel="share of the rows [%]", ylim=(0, 100), xlim=(0, None))
            row[2].legend(frameon=False, loc="lower right")
    plt.close(figure)
    return figure


def _draw_places(panel: Axes, measured: Array, errors: Array, i: int, j: int) -> None:
    for place, error in zip(1e3 * measured, 1e3 * errors, strict=True):
        panel.plot(place[i] + [0, error[i]], place[j] + [0, error[j]], color="0.75", lw=0.5, zorder=0)
    panel.plot(*(1e3 * measured[:, [i, j]]).T, ".", ms=2.5, color="0.35", label="measured")
    panel.plot(*(1e3 * (measured + errors)[:, [i, j]]).T, ".", ms=1.5, color=ESTIMATOR_COLORS[5], label="predicted")
    panel.set(xlabel=f"{'xyz'[i]} [mm]", ylabel=f"{'xyz'[j]} [mm]", aspect="equal")


def _draw_errors(panel: Axes, errors: Array, label: str, color: str) -> None:
    distances = np.sort(1e3 * np.linalg.norm(errors[balanced_rows(errors)], axis=-1).ravel())
    fractions, rms = np.arange(1, len(distances) + 1) / len(distances), error_columns(distances, "rms")["rms"]
    panel.plot(distances, 100 * fractions, color=color, label=f"{label}: {rms:.1f} mm r.m.s.")
