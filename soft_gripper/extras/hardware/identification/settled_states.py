"""Recorded states of a finger at rest, its tendons pulled, and parameters fitted to them: free ones and placement.

A row of such a recording holds how far each tendon is pulled, and where markers on the finger came to rest. The finger
of a model rests where its springs, weight and tendons balance (`tendon_balance`). Dry friction makes its bend lag:
it follows the balance only as far as this is more than the friction away (play operator; Visintin, *Differential Models
of Hysteresis*, 1994, chapter III), in the order of the rows. Backlash makes the pulled lengths lag behind the motors in
the same way, at all times of the recording, since motors turn back between two rows too. Where a recording places the
finger is not known, so predicted markers are shifted by their mean distance from measured ones.

A fit minimises the distances of predicted and measured markers; large ones count less than by their squares, because
tendons that stick or slip off are not part of the model. Derivatives by the markers' places are exact, those of joint
positions by the parameters are finite differences, which takes no kinematics.
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
from soft_gripper.extras.hardware.identification.confidence import Confidence, confidence_of, mean_correlation_time
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
from soft_gripper.extras.hardware.scoring import FITTED, LEFT_OUT, TESTED, error_columns, groups_left_out
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
_MOST_STEPS = 60
_JITTER = 1.0  # typical changes, standard deviation of the random restarts
_WOUND = 10  # instants at which pulled lengths are known, from one row to the next
_ALL = "all"  # rows, or markers
_FAR = 10.0  # lengths of the finger by which a tendon is let out so that it is slack
_SLACK_MOTION = 1e-3  # of the finger's length: a tendon without which no marker is further away is slack


@dataclass(frozen=True)
class SettledStates:
    """The rows of a recording, in their order."""

    name: str
    pulled: Array  # (R, T) m, of every tendon of the finger
    markers: Array  # (R, M, 3) m in B
    places: Array  # (M, 3) m, of the markers in the frame of the tip, or of where else they are
    families: NDArray[np.str_]  # (R,) of what was moved; empty where a row belongs to none
    gravity: Array  # (3,) m/s^2 in B
    at: Array | None = None  # (M,) shares of the length where the markers are; None: all at the tip
    load: float = 0.0  # kg, hung on the tip
    time: Array | None = None  # (R,) s; None: not known
    names: tuple[str, ...] = ()  # of the markers; empty: they have none
    winding: tuple[Array, Array] | None = None  # (K,) s, (K, T) m: pulled lengths between the rows; None: not known

    def pulled_before(self, delay: float, backlash: float) -> Array:
        """Lengths that motors with a backlash, m, have pulled in some time, s, before the rows, (R, T) m."""
        if self.winding is None or self.time is None:
            return _behind(self.pulled, backlash)
        if delay == backlash == 0:
            return self.pulled
        time, wound = self.winding
        return np.stack([np.interp(self.time - delay, time, of) for of in _behind(wound, backlash).T], axis=-1)


def settled_states(recording: HardwareRecording, finger: Finger) -> SettledStates:
    """The rows of a recording whose markers were all seen, for a finger with the tendons that it describes.

    Raises:
        InputError: if tendons or markers are not described, or the finger does not have the tendons.
    """
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
    pulled = np.stack([recording.pulled[tendon] for tendon in names], axis=-1)
    seen = np.stack([recording.markers[marker] for marker in markers.places], axis=1)
    whole: NDArray[np.bool_] = np.isfinite(pulled + seen.sum(axis=(1, 2))[:, None]).all(axis=1)
    require(int(whole.sum()) > config.every, name, "rows", int(whole.sum()), "at least 2 need all tendons and markers")
    pattern = config.labels.family if config.labels else "(.*)"
    families = np.array([_family(label, pattern) for label in recording.labels or [""] * len(whole)])
    gravity = np.zeros(3) if recording.gravity is None else recording.gravity
    places = np.array(list(markers.places.values()))
    if config.blocks > 1 and config.labels is None:
        block = np.arange(len(whole)) * config.blocks // len(whole) + 1
        families = np.array([f"block {number}" for number in block])
    number = np.arange(len(whole))
    wound = np.isfinite(pulled).all(axis=1) & (number % max(config.every // _WOUND, 1) == 0)
    winding = recording.time[wound], pulled[wound]
    whole &= number % config.every == 0
    at = np.array([markers.at.get(name, 1.0) for name in markers.places])
    return SettledStates(
        name,
        pulled[whole],
        seen[whole],
        places,
        families[whole],
        gravity,
        at,
        recording.load_mass,
        recording.time[whole],
        tuple(markers.places),
        winding,
    )


def _family(label: str, pattern: str) -> str:
    """The text of a label that a pattern matches, or its first alternative that does; the label without a pattern."""
    matches = (find(alternative, label) for alternative in pattern.split("|"))
    return next((match[0] for match in matches if match), "") if pattern else label


def resting_positions(model: Model, states: SettledStates) -> Array:
    """Joint positions of a finger in its set-up in every row, (R, J) rad, or m where joints slide.

    A row in which it finds no balance is NaN.
    """
    pulled = states.pulled_before(model.setup.delay, model.setup.backlash)
    q = pulled_positions(_loaded(model.finger, states.load), pulled, states.gravity)
    if model.setup.dry_friction == 0:
        return q
    ways = np.array(spatial_chain(model.finger).deformations)
    bends = ways == "bending", *([ways == "sideways"] if "sideways" in ways else [])
    lag = model.setup.dry_friction / model.finger.segments
    lagging = _lagging(np.stack([q[:, bend] for bend in bends], axis=-1), lag)
    q = q.copy()
    for i, bend in enumerate(bends):
        q[:, bend] = lagging[..., i]
    return q


def _behind(wound: Array, backlash: float) -> Array:
    """Lengths (K, T) m that follow what is wound, once this is over a backlash, m, away: a play operator of each."""
    if backlash == 0:
        return wound
    found, at = np.empty_like(wound), wound[:1]
    for row, (least, most) in enumerate(zip(wound - backlash, wound + backlash, strict=True)):
        found[row] = at = np.clip(at, least, most)
    return found


def _loaded(finger: Finger, mass: float) -> Finger:
    """A finger with a point mass, kg, in the middle of its tip besides what it carries; 0: as it is."""
    if mass == 0:
        return finger
    require(finger.tip_load is None, f"finger '{finger.name}'", "tip_load", "", "leave it out: the recording names one")
    return replace(finger, tip_load=TipLoad(mass, 0.0, 0.0))


def _lagging(wanted: Array, lag: float) -> Array:
    """Vectors that follow wanted ones, (R, N, 2) or (R, N, 1), once these are over `lag` away; NaN are passed."""
    found, seen = np.full(wanted.shape, np.nan), np.flatnonzero(np.isfinite(wanted).all(axis=(1, 2)))
    at = wanted[seen[0]] if len(seen) else wanted[:0]
    for row in seen:
        there = wanted[row]
        away = there - at
        distance = np.sqrt((away**2).sum(axis=-1, keepdims=True))
        at = at + away * np.maximum(0.0, 1 - lag / np.maximum(distance, lag))
        found[row] = at
    return found


def predicted_markers(finger: Finger, states: SettledStates, q: Array) -> tuple[Array, Array]:
    """Markers of a finger at joint positions (R, J): (R, M, 3) m in its frame; derivatives by these, (R, J, M, 3)."""
    chain = spatial_chain(finger)
    at = posture(chain, q)
    stations = finger.length * (np.ones(len(states.places)) if states.at is None else states.at)
    before = np.searchsorted(finger.joint_arc_lengths, stations)  # joints between the base and each marker
    frames, last = chain.link_frames(before), np.concatenate([[0.0], finger.joint_arc_lengths])[before]
    places = states.places + np.outer(stations - last, [0.0, 0.0, 1.0])
    markers = at.origins[:, frames] + (at.rotations[:, frames] @ places[..., None])[..., 0]
    turning, moving = at.screws[..., None, :3], at.screws[..., None, 3:]
    carried = (frames > np.arange(len(chain.deformations))[:, None])[..., None]
    return markers, carried * (np.cross(turning, markers[:, None]) + moving)


def state_errors(model: Model, states: SettledStates, rows: NDArray[np.bool_] | None = None) -> Array:
    """Predicted minus measured markers, (R, M, 3) m, their mean over the rows that are true in `rows` removed.

    A row in which the finger finds no balance is NaN.
    """
    away = predicted_markers(model.finger, states, resting_positions(model, states))[0] - states.markers
    return _centred(away, away if rows is None else away[rows])


def _centred(away: Array, others: Array) -> Array:
    """Vectors (..., M, 3) without the mean of others, (R, M, 3), of which rows that are NaN do not count."""
    seen = others[in_balance(others)]
    return away - seen.mean(axis=(0, 1)) if len(seen) else away


def in_balance(errors: Array) -> NDArray[np.bool_]:
    """Whether the finger found a balance in rows, (R,), by their errors, (R, M, 3)."""
    found: NDArray[np.bool_] = np.isfinite(errors).all(axis=(1, 2))
    return found


Rows = Sequence[NDArray[np.bool_]]  # (R,) each: which rows of the recordings are fitted


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

    Raises:
        InputError: if the result comes nowhere near the markers.
    """
    length = free.model.finger.length
    kept = [np.full(len(of.pulled), True) for of in recordings] if rows is None else rows

    def residuals(x: Array) -> Array:
        try:
            model = free.at(x)
            errors = [state_errors(model, *of)[of[1]].ravel() for of in zip(recordings, kept, strict=True)]
        except InputError:  # a step of the search may lead to an impossible finger
            errors = [
                np.full(3 * keep.sum() * of.markers.shape[1], length) for of, keep in zip(recordings, kept, strict=True)
            ]
        return np.concatenate(errors)

    def slopes(x: Array, residuals: Array) -> Array:
        return np.concatenate([marker_slopes(free, x, *of) for of in zip(recordings, kept, strict=True)])

    problem = Problem(
        free.at,
        residuals,
        slopes,
        outlier=_HUBER_DISTANCE * length,
        missing=length,
        bounds=free.bounds,
        error=lambda residuals: root_mean_square(residuals[np.isfinite(residuals)].reshape(-1, 3)) / length,
        options={"x_scale": free.scales, "ftol": _TOLERANCE, "xtol": _TOLERANCE, "max_nfev": _MOST_STEPS},
    )
    found = fit(problem, free.start if starts is None else starts, report)
    return FingerFit(**vars(found), free=free, recordings=tuple(recordings))


def marker_slopes(free: FreeParameters, x: Array, states: SettledStates, rows: NDArray[np.bool_]) -> Array:
    """Derivatives of the residuals of one recording by the free parameters, (K, P); 0 in rows without a balance."""
    model = free.at(x)
    q = resting_positions(model, states)
    markers, by_joints = predicted_markers(model.finger, states, q)
    columns = []
    for step in np.diag(free.steps(x, _DIFFERENCE_STEP)):
        moved = free.at(x + step)
        if moved.finger.length != model.finger.length:  # which alone changes the markers where the joints stand still
            change = predicted_markers(moved.finger, states, resting_positions(moved, states))[0] - markers
        else:
            change = np.einsum("rj,rjmi->rmi", resting_positions(moved, states) - q, by_joints)
        change = change[rows] / step.sum()
        columns.append(np.nan_to_num(_centred(change, change)).ravel())
    return np.stack(columns, axis=-1)


def slack_tendons(model: Model, recordings: Sequence[SettledStates]) -> list[str]:
    """Names of the tendons without which no marker would be elsewhere, in any row in which the finger is in balance."""
    finger, setup = model.finger, model.setup

    def markers(states: SettledStates, slack: int | None = None) -> Array:
        pulled = states.pulled_before(setup.delay, setup.backlash).copy()
        pulled[:, [] if slack is None else [slack]] = -_FAR * finger.length
        q = pulled_positions(_loaded(finger, states.load), pulled, states.gravity)
        return predicted_markers(finger, states, q)[0]

    def change(slack: int) -> Array:
        pairs = [(place, markers(states, slack)) for states, place in zip(recordings, places, strict=True)]
        return np.concatenate([(without - place)[in_balance(place)] for place, without in pairs])

    places = [markers(states) for states in recordings]
    if not any(in_balance(place).any() for place in places):
        return []
    most = _SLACK_MOTION * finger.length  # what buckles without a tendon is NaN, and needs it
    return [
        tendon.name for i, tendon in enumerate(finger.tendons) if (np.linalg.norm(change(i), axis=-1) <= most).all()
    ]


def note_unbalanced(states: SettledStates, errors: Array) -> None:
    """Notes rows in which the finger finds no balance, by their errors, (R, M, 3)."""
    for row in np.flatnonzero(~in_balance(errors)):
        which = f"row {row + 1} of those used" if states.time is None else f"row at {states.time[row]:.6g} s"
        note(
            LEFT_OUT_OF_FILE,
            states.name,
            which,
            "",
            "the finger finds no shape in balance with its tendons and its weight",
        )


def root_mean_square(errors: Array) -> float:
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

    Args:
        finger: initial guess of the fit.
        names: the free keys, see `free_parameters`.
        fitted: recordings to fit to.
        tested: held-out recordings, of which only the placement is fitted.
        executor: runs the fits without a family.
        starts: number of fits, of which the best is kept; the first starts from the finger, the others near it.
        seed: seed of the random starts.
        report: called after each step of a search.
        setup: initial guess of the set-up; None: the default.

    Raises:
        InputError: if a key cannot be fitted, no row tightens a tendon, or no fit comes near the markers.
    """
    free = free_parameters(finger, names, [], setup)
    tendons = [tendon.name for tendon in finger.tendons]
    if len(slack_tendons(free.model, fitted)) == len(tendons):
        expected = "no row tightens any of them: do they pull the other way, or is their slack too large?"
        raise InputError(fitted[0].name, "tendons", ", ".join(tendons), expected)
    best = fit_states(free, fitted, report=report, starts=free.starts(starts, seed, _JITTER))
    own, others = _compared(best.model, fitted, FITTED), compared_states(best.model, tested)
    known = confidence_of(free, best.x, best.residuals, best.slopes, mean_correlation_time(by_rows(own.errors)))
    left_out = _left_out(best, names, [each.name for each in known.undetermined], fitted, executor)
    scores = list(own.scores)
    for of, error in zip(fitted, left_out, strict=True):
        families = [name for name in sorted(set(of.families)) if name]
        for name in families:
            scores += _scores(of, LEFT_OUT, name, error[of.families == name])
        scores += _scores(of, LEFT_OUT, _ALL, error[of.families != ""]) if families else []
    states, errors = own.states + others.states, own.errors + others.errors
    return IdentifiedStates(best.model, states, errors, (*scores, *others.scores), left_out, best, known)


def by_rows(errors: Sequence[Array]) -> list[Array]:
    """Errors of recordings, (R, M, 3), as series of the rows in which the finger found a balance."""
    return [error[in_balance(error)].reshape(-1, error[0].size) for error in errors]


def compared_states(model: Model, states: Sequence[SettledStates]) -> TestedStates:
    """Compares recordings with a finger in its set-up; only their placement is fitted."""
    return _compared(model, states, TESTED)


def _compared(model: Model, states: Sequence[SettledStates], role: str) -> TestedStates:
    errors = tuple(state_errors(model, of) for of in states)
    for of, error in zip(states, errors, strict=True):
        note_unbalanced(of, error)
    scores = [one for of, error in zip(states, errors, strict=True) for one in _scores(of, role, _ALL, error)]
    return TestedStates(model, tuple(states), errors, tuple(scores))


def _left_out(
    best: FingerFit[SettledStates],
    names: Sequence[str],
    undetermined: Sequence[str],
    fitted: Sequence[SettledStates],
    executor: Executor,
) -> tuple[Array, ...]:
    """Errors of every row by a fit without its family, which is placed as a recording of its own, (R, M, 3) m.

    The fits begin with the best one; what that could not determine stays as it is there, and if that is everything, the
    best one predicts them.
    """
    others = groups_left_out([states.families for states in fitted])
    found = tuple(np.full(states.markers.shape, np.nan) for states in fitted)
    if len(others) < 2:
        return found
    pending = [executor.submit(_fit_from, best.model, names, undetermined, fitted, rows) for rows in others]
    wait_for(pending, "left out", "family")
    for rows, future in zip(others, pending, strict=True):
        model = future.result()
        for errors, states, keep in zip(found, fitted, rows, strict=True):
            errors[~keep] = state_errors(model, states, ~keep)[~keep]
    return found


def _fit_from(
    model: Model, names: Sequence[str], undetermined: Sequence[str], fitted: Sequence[SettledStates], rows: Rows
) -> Model:
    free = free_parameters(model.finger, names, [], model.setup)
    free = free.fixing(free.start, undetermined)
    if not free.names:
        return free.model
    return fit_states(free, fitted, rows).model


def _scores(states: SettledStates, role: str, family: str, errors: Array) -> list[StateScore]:
    """Scores of all markers, and of each if there are several; rows without a balance do not count."""
    errors = errors[in_balance(errors)]
    if not len(errors):
        return []
    distances = 1e3 * np.linalg.norm(_centred(errors, errors), axis=-1)
    of_markers = {_ALL: distances}
    if len(states.names) > 1:
        of_markers |= dict(zip(states.names, distances.T, strict=True))
    return [
        StateScore(
            states.name, role, family, marker, len(errors), **error_columns(of, "rms_mm", "mean_mm", "percentile_95_mm")
        )
        for marker, of in of_markers.items()
    ]


_WIDTH, _HEIGHT = 3.0, 2.8  # inches, of a panel
_VIEWS = ((0, 1), (0, 2))  # axes of B: from the tip, and from the side


def states_figure(found: TestedStates) -> Figure:
    """Plots the places of the last marker, measured and predicted, seen along the finger and from the side.

    A row for each recording; beside it the distribution of the errors.
    """
    count = len(found.states)
    with plt.rc_context(STYLE):
        figure, axes = plt.subplots(
            count, 3, figsize=(3 * _WIDTH, count * _HEIGHT), squeeze=False, constrained_layout=True
        )
        fitted = found.left_out if isinstance(found, IdentifiedStates) else ()
        left_out: list[Array | None] = [*fitted, *[None] * count]
        for row, states, errors, without in zip(axes, found.states, found.errors, left_out, strict=False):
            for panel, (i, j) in zip(row, _VIEWS, strict=False):
                _draw_places(panel, states.markers[:, -1], errors[:, -1], i, j)
            _draw_errors(row[2], errors, "held out" if without is None else "fitted", ESTIMATOR_COLORS[2])
            if without is not None and in_balance(without).any():
                _draw_errors(row[2], without, "left out", ESTIMATOR_COLORS[5])
            row[0].set_title(states.name)
            row[1].legend(frameon=False, markerscale=3, loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=2)
            row[2].set(xlabel="error [mm]", ylabel="share of the rows [%]", ylim=(0, 100), xlim=(0, None))
            row[2].legend(frameon=False, loc="lower right")
    plt.close(figure)
    return figure


def _draw_places(panel: Axes, measured: Array, errors: Array, i: int, j: int) -> None:
    for place, away in zip(1e3 * measured, 1e3 * errors, strict=True):
        panel.plot(place[i] + [0, away[i]], place[j] + [0, away[j]], color="0.75", lw=0.5, zorder=0)
    panel.plot(*(1e3 * measured[:, [i, j]]).T, ".", ms=2.5, color="0.35", label="measured")
    panel.plot(*(1e3 * (measured + errors)[:, [i, j]]).T, ".", ms=1.5, color=ESTIMATOR_COLORS[5], label="predicted")
    panel.set(xlabel=f"{'xyz'[i]} [mm]", ylabel=f"{'xyz'[j]} [mm]", aspect="equal")


def _draw_errors(panel: Axes, errors: Array, label: str, color: str) -> None:
    distances = np.sort(1e3 * np.linalg.norm(errors[in_balance(errors)], axis=-1).ravel())
    shares, rms = np.arange(1, len(distances) + 1) / len(distances), error_columns(distances, "rms")["rms"]
    panel.plot(distances, 100 * shares, color=color, label=f"{label}: {rms:.1f} mm r.m.s.")
