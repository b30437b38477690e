"""Calibration from free bending: the response of every sensor, and how far a finger bends under pressure.

The stiffness of the nominal finger is scaled: the joint angles q of a finger at rest follow from

    k(q) / r = g(p) + w(q) ,

with k the elastic torque of a finger that has crept, g the torque of the pressure, w that of the weight and r the ratio
that is found. A finger that is assumed to creep must rest for longer than its slowest branch. The sensor i reads the
extension ratio

    1 + a_i (s_i + c s_i^2 + h l_i) + b_i + d_i t ,

with s_i the strain, l_i how far the play operators of `strain_errors` lag behind it in the course of the recording, the
gain a, the offset b, the drift d, and, one for all sensors of a finger, for they are those of the material, the width h
of the hysteresis loop as a share of the stroke and the curvature c of the response. The curvature, and an offset of the
pressure sensor, are 0 unless they are looked for.

Every hold of the pressure counts as one observation, the median of its samples: what is left is mostly what lasts
longer than a hold. Its standard deviation is estimated from what is left. All numbers have priors, `GAIN` of the gains
and so on, hence a posterior covariance; holds that do not fit count less (Huber). Strain and pressure alone cannot tell
larger gains of all sensors from a finger that bends further, but for its weight, which is too weak to rely on: their
mean is known no better than the prior says, unless the place of the tip is measured too.

Leading axes are free; T samples, M holds, R readings.
"""

import warnings
from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from soft_gripper.arrays import Array, Planar
from soft_gripper.extras.hardware.least_squares import Fit, Problem, fit
from soft_gripper.extras.hardware.left_out_regions import (
    COVERAGE,
    LeftOut,
    fitted_disagreement,
    learned_widths,
    regions_left_out,
)
from soft_gripper.fingers.finger import Finger
from soft_gripper.fingers.kinematics import forward_kinematics, gravity_torque
from soft_gripper.fingers.statics import resting_angles, softened
from soft_gripper.sensors.calibrated_states import DRIVE, KNOWN_DRIVE, CalibratedStates, distance_stds, state_spreads
from soft_gripper.sensors.fitted_states import FittedStates, Widths
from soft_gripper.sensors.response_curve import CalibratedResponse, ResponseCurve
from soft_gripper.sensors.sensor_layout import SensorLayout, extension_ratios
from soft_gripper.sensors.strain_errors import MINUTE, PLAYS, lagging_strain, moved_plays

GAIN, RATIO = 0.05, 0.5  # standard deviations before anything is measured: of gains, of the logarithm of the bend ratio
OFFSET, DRIFT, HYSTERESIS = 0.1, 2e-3 / MINUTE, 0.02  # extension ratio, 1/s, share of the stroke
TIP = 5e-4  # m, standard deviation of a measured place of the tip, at least
SOUGHT = {"pressure": 1000.0, "response": 0.2}  # Pa, offset of its sensor; curvature of the response, over strain
_FIXED_STD_SHARE = 1e-6  # share of these, where they are not looked for
_PRESSURE_STEP = 100.0  # Pa, for differences
_RATIOS = (0.2, 5.0)
_FIRST, _LEAST = 1e-3, 2e-5  # extension ratio, standard deviations of a median: guess, and least
_UNKNOWNS, _SHARED = 3.0, 4.0  # of a reading, on average; observations that readings share
_STD_PER_MEDIAN = 1.4826  # standard deviation over the median of the absolute values, of normal ones
_HUBER_DEVIATIONS = 2.0  # standard deviations, beyond which residuals count linearly
_DOUBTFUL_DEVIATIONS = 4.0  # beyond which a hold is not free bending
_PASSES, _STEP = 5, 1e-4  # in which the noise is estimated; of the logarithm of r, for differences


@dataclass(frozen=True)
class FreeBending:
    """A recording of T samples in which a finger bends freely, in M holds of its pressure."""

    time: Array  # (T) s
    pressure: Array  # (T) Pa
    gravity: Planar  # (T) in the bending plane, z + i x in B, m/s^2
    ratios: Array  # (T, R) extension ratios that the nominal sensors read, NaN where there is none
    hold: NDArray[np.int_]  # (T) number of the hold in which the finger rests, -1 where it moves
    tip: Planar | None = (
        None  # (T) measured place of the tip in the bending plane, z + i x in B, m; NaN where there is none
    )


class _Holds(NamedTuple):
    """M holds, of all recordings."""

    strain: Array  # (M, R) read, NaN where nothing is
    recording: NDArray[np.int_]  # (M)
    time: Array  # (M) s since the recording began
    tip: Planar  # (M) m, NaN where it is not measured


class _Predicted(NamedTuple):
    """Predictions for a finger of some bend ratio in the holds."""

    strain: Array  # (M, R)
    lag: Array  # (M, R) of a loop as wide as the stroke
    tip: Planar  # (M) m

    def less(self, other: "_Predicted", step: float) -> "_Predicted":
        """The derivative by what was larger by `step` here than there."""
        strain, lag, tip = self.strain - other.strain, self.lag - other.lag, self.tip - other.tip
        return _Predicted(strain / step, lag / step, tip / step)


class Calibration(NamedTuple):
    """Estimates of a calibration, and standard deviations."""

    bend_ratio: float  # how much further the finger bends under the same pressure than nominal
    gains: Array  # (R)
    offsets: Array  # (R) extension ratio
    residual: float  # root mean square of what is left of the holds, extension ratio
    bend_ratio_std: float
    gain_stds: Array  # (R)
    offset_stds: Array  # (R)
    hysteresis: float  # share of the stroke
    drifts: Array  # (R) 1/s, mean of the recordings
    tip_measured: bool  # whether the place of the tip was
    doubtful: tuple[tuple[int, float], ...]  # recordings, from 0, and times, s, of holds that are not free bending
    pressure_offset: float  # Pa, what the sensor reads too much
    pressure_offset_std: float
    response_curvature: float
    response_curvature_std: float
    states: CalibratedStates | None = None  # in which it was calibrated


def calibrate(layout: SensorLayout, recordings: Sequence[FreeBending], sought: Collection[str] = ()) -> Calibration:
    """Fits all numbers to recordings, robustly; `layout` is nominal, `sought` names those of SOUGHT to fit as well."""
    holds, parts = _holds(recordings), _Parts(layout.readings)
    prior = _prior(layout.readings, len(recordings), sought)
    known = np.isfinite(np.column_stack([holds.strain, holds.tip.real, holds.tip.imag]))
    noise = _Noise(np.full(layout.readings, _FIRST), TIP)
    weights: Array = np.ones(len(holds.time))
    x = _begin(parts, len(prior), _first_ratio(layout, recordings, holds))

    @lru_cache(maxsize=4)
    def predict(log_ratio: float) -> tuple[_Predicted, _Predicted | None]:
        return _predict_both(layout, recordings, log_ratio, "pressure" in sought)

    def left_at(x: Array) -> Array:
        return _left(x, parts.at(x, *predict(x[0])), holds, parts)

    def residuals(x: Array) -> Array:
        return np.concatenate([left_at(x)[known], prior @ x])

    def slopes(x: Array, residuals: Array) -> Array:
        here, beyond = (parts.at(x, *predict(log_ratio)) for log_ratio in (x[0], x[0] + _STEP))
        return np.vstack([-_slopes(x, here, beyond, predict(x[0])[1], holds, parts)[known], prior])

    most = np.append(np.log(_RATIOS[1]), np.full(len(x) - 1, np.inf))
    least = np.append(np.log(_RATIOS[0]), -most[1:])
    problem = Problem(np.asarray, residuals, slopes, bounds=(least, most), options={"x_scale": "jac"})
    for _ in range(_PASSES):
        scale = np.sqrt(weights)[:, None] / np.array([*noise.strain, noise.tip, noise.tip])
        found = fit(replace(problem, weights=np.append(scale[known], np.ones(len(prior)))), x)
        x = found.x.copy()
        noise, weights = _scatter(left_at(x))
    x[[at for name, at in parts.sought.items() if name not in sought]] = 0.0
    covariance = found.covariance
    left, gains = left_at(x), np.exp(x[parts.bends] - x[0])
    from_bends = np.eye(len(x))[parts.bends] - np.eye(len(x))[0]  # to the logarithms of the gains
    of_gains, stds = from_bends @ covariance @ from_bends.T, np.sqrt(np.diagonal(covariance))
    return Calibration(
        *(float(np.exp(x[0])), gains, x[parts.offsets], float(np.sqrt(np.nanmean(left[:, : layout.readings] ** 2)))),
        *(float(np.exp(x[0]) * stds[0]), gains * np.sqrt(np.diagonal(of_gains)), stds[parts.offsets]),
        *(float(x[parts.lag]), x[parts.drifts].reshape(-1, layout.readings).mean(axis=0)),
        bool(known[:, -1].any()),
        tuple(
            (int(holds.recording[i]), float(holds.time[i]))
            for i in np.flatnonzero(weights < _HUBER_DEVIATIONS / _DOUBTFUL_DEVIATIONS)
        ),
        *((float(x[parts.pressure]), float(stds[parts.pressure])) if "pressure" in sought else (0.0, 0.0)),
        *((float(x[parts.response]), float(stds[parts.response])) if "response" in sought else (0.0, 0.0)),
        _states(layout, recordings, found, known, x),
    )


def _states(
    layout: SensorLayout, recordings: Sequence[FreeBending], fit: Fit[Array], measured: NDArray[np.bool_], x: Array
) -> CalibratedStates | None:
    """Where the finger was calibrated; None if no hold has all readings.

    The residuals of the fit are first those that are `measured`, (M, R + 2), of the holds, then those of the prior.
    """
    parts, R = _Parts(layout.readings), layout.readings
    finger = replace(softened(layout.finger, float(np.exp(x[0]))), pressure_offset=float(x[parts.pressure]))
    gains, offsets = (tuple(each.tolist()) for each in (np.exp(x[parts.bends] - x[0]), x[parts.offsets]))
    response = CalibratedResponse(ResponseCurve(), gains, offsets, float(x[parts.response]))
    by_recording = [np.hstack([response.ratio(each.ratios - 1) - 1, _drive(finger, each)]) for each in recordings]
    states = np.array(
        [
            _median(of[each.hold == hold])
            for of, each in zip(by_recording, recordings, strict=True)
            for hold in range(each.hold.max() + 1)
        ]
    )
    whole = np.isfinite(states).all(axis=-1)
    if not whole.any():
        return None
    spread = state_spreads(states[whole, :R], states[whole, R:])

    def without(region: NDArray[np.bool_]) -> LeftOut:
        left_out = whole.copy()
        left_out[whole] = region
        near = replace(known, fitted=FittedStates(states[whole & ~left_out], spread))
        of_holds = np.broadcast_to(~left_out[:, None], measured.shape)[measured]
        kept = np.append(of_holds, np.ones(len(fit.residuals) - len(of_holds), bool))
        distance = distance_stds(near.state_distances(states[left_out]), layout.paths)
        return LeftOut(errors(fit.change_without(kept))[left_out].reshape(-1, 1), distance.reshape(-1, 1))

    def errors(moved: Array) -> Array:
        """Errors of the strains if the unknowns move, (M, R), NaN where nothing is read."""
        left = np.full(measured.shape, np.nan)
        left[measured] = np.abs(fit.residuals + fit.slopes @ moved)[: measured.sum()]
        return left[:, :-2]

    # Under a drive that is a little away from a fitted one, the readings are as far away again.
    read = [states[np.isfinite(states).all(axis=-1)] for states in by_recording]
    groups = read if len(read) > 1 else np.array_split(read[0], 2)
    apart = fitted_disagreement(groups, spread, R) + np.sqrt(2) * KNOWN_DRIVE
    known = CalibratedStates(FittedStates(states[whole], spread), Widths(np.zeros(1), 0.0), apart, layout.sections)
    fitted = errors(np.zeros(len(x)))[whole].reshape(-1, 1)  # sensors are alike, and holds too few for widths of each
    widths = learned_widths(fitted, [*regions_left_out([space.regions() for space in known.spaces], without)])
    holds_of = [each.hold for each in recordings]
    return replace(known, widths=widths, noise=_noise(by_recording, holds_of, layout.paths) / spread[0])


def _median(values: Array) -> Array:
    """Medians over the first axis of what is finite, NaN where nothing is."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)
        return np.asarray(np.nanmedian(values, axis=0))


def _noise(by_recording: Sequence[Array], holds: Sequence[NDArray[np.int_]], paths: int) -> float:
    """How far 95 % of the readings of a section are from their medians while the finger rests, strain."""
    away = []
    for states, hold in zip(by_recording, holds, strict=True):
        for number in range(hold.max() + 1):
            readings = states[hold == number, :-DRIVE]
            apart = (readings - _median(readings)).reshape(len(readings), paths, -1)
            away.append(np.linalg.norm(apart, axis=1).ravel())
    return float(np.nanquantile(np.concatenate(away), COVERAGE))


def _drive(finger: Finger, recording: FreeBending) -> Array:
    """Drive of a finger at rest: torque at the first joint, N m, and gravity along x and z, m/s^2, (T, 3)."""
    q, pull = resting_angles(finger, recording.pressure, recording.gravity), recording.gravity
    torque = finger.elastic_torque(q) - gravity_torque(finger, q, pull[:, None])
    return np.column_stack([torque[:, 0], pull.imag, pull.real])


class _Parts:
    """Where in the vector of unknowns they are; first comes the logarithm of the bend ratio r.

    `bends` are the logarithms of  a r : readings tell them well, and r itself hardly, which makes a fit easy.
    """

    def __init__(self, readings: int):
        self.readings = readings
        self.lag, self.pressure, self.response = 1, 2, 3
        self.sought = {"pressure": self.pressure, "response": self.response}
        self.bends, self.offsets = (slice(4 + i * readings, 4 + (i + 1) * readings) for i in range(2))
        self.drifts = slice(4 + 2 * readings, None)  # reading after reading, of one recording after the other

    def at(self, x: Array, predicted: _Predicted, by_pressure: _Predicted | None) -> _Predicted:
        """Predictions at an offset of the pressure."""
        if by_pressure is None:
            return predicted
        return _Predicted(*(here + x[self.pressure] * by for here, by in zip(predicted, by_pressure, strict=True)))


def _prior(readings: int, recordings: int, sought: Collection[str]) -> Array:
    """Prior of the unknowns, in standard deviations: rows of a matrix, each expected to give 0."""
    each = [GAIN, OFFSET, *[DRIFT] * recordings]
    looked_for = [std * (1 if name in sought else _FIXED_STD_SHARE) for name, std in SOUGHT.items()]
    stds = [RATIO, HYSTERESIS, *looked_for, *(std for std in each for _ in range(readings))]
    rows = np.diag(1 / np.array(stds))
    rows[_Parts(readings).bends, 0] = -1 / GAIN  # gains, not bends, are about 1
    return rows


def _holds(recordings: Sequence[FreeBending]) -> _Holds:
    """The medians of all holds."""
    found: list[tuple[Array, int, float, complex]] = []
    for number, recording in enumerate(recordings):
        for hold in range(recording.hold.max() + 1):
            at = recording.hold == hold
            strain, tip = _median(recording.ratios[at]) - 1, complex(np.nan, np.nan)
            if recording.tip is not None:
                tip = complex(*_median(np.column_stack([recording.tip[at].real, recording.tip[at].imag])))
            found.append((strain, number, float(recording.time[at].mean() - recording.time[0]), tip))
    strains, numbers, times, tips = zip(*found, strict=True)
    return _Holds(np.array(strains), np.array(numbers), np.array(times), np.array(tips))


def _predict_both(
    layout: SensorLayout, recordings: Sequence[FreeBending], log_ratio: float, with_pressure: bool
) -> tuple[_Predicted, _Predicted | None]:
    """Predictions at a bend ratio and, if requested, their derivative by the offset of the pressure, 1/Pa."""
    finger = softened(layout.finger, float(np.exp(log_ratio)))
    here = _predict(layout, finger, recordings)
    if not with_pressure:
        return here, None
    there = _predict(layout, replace(finger, pressure_offset=_PRESSURE_STEP), recordings)
    return here, there.less(here, _PRESSURE_STEP)


def _predict(layout: SensorLayout, finger: Finger, recordings: Sequence[FreeBending]) -> _Predicted:
    """Means over the holds."""
    parts = []
    for recording in recordings:
        q = resting_angles(finger, recording.pressure, recording.gravity)
        strain = extension_ratios(layout, q) - 1
        tip = forward_kinematics(q, finger.segment_length).points[:, -1]
        lag = _lags(strain)
        for hold in range(recording.hold.max() + 1):
            at = recording.hold == hold
            parts.append((strain[at].mean(axis=0), lag[at].mean(axis=0), tip[at].mean()))
    return _Predicted(*(np.array(column) for column in zip(*parts, strict=True)))


def _lags(strain: Array) -> Array:
    """How far sensors with a loop as wide as the stroke are behind, (T, R)."""
    plays: Array = np.zeros((PLAYS, strain.shape[-1]))
    lags = np.empty_like(strain)
    for i, each in enumerate(strain):
        plays = moved_plays(plays, each)
        lags[i] = lagging_strain(plays, each, 1.0) - each
    return lags


def _begin(parts: _Parts, unknowns: int, log_ratio: float) -> Array:
    """Unknowns of ideal sensors."""
    x: Array = np.zeros(unknowns)
    x[parts.bends] = x[0] = log_ratio
    return x


def _first_ratio(layout: SensorLayout, recordings: Sequence[FreeBending], holds: _Holds) -> float:
    """The logarithm of the ratio of the strains read to those predicted, of the reading that moves most."""
    predicted = _predict(layout, layout.finger, recordings).strain
    strain = np.where(np.isfinite(holds.strain), holds.strain, predicted)
    most = int(np.ptp(predicted, axis=0).argmax())
    moved, read = (values[:, most] - values[:, most].mean() for values in (predicted, strain))
    return float(np.log(np.clip((moved @ read) / (moved @ moved), *_RATIOS)))


def _left(x: Array, at: _Predicted, holds: _Holds, parts: _Parts) -> Array:
    """Residuals of what is measured, (M, R + 2): strains, and the place of the tip; NaN if not measured."""
    drift = x[parts.drifts].reshape(-1, parts.readings)[holds.recording] * holds.time[:, None]
    strain = np.exp(x[parts.bends] - x[0]) * _responding(x, at, parts) + x[parts.offsets] + drift
    tip = holds.tip - at.tip
    return np.column_stack([holds.strain - strain, tip.real, tip.imag])


def _responding(x: Array, at: _Predicted, parts: _Parts) -> Array:
    """Strains to which sensors respond with their gains, (M, R)."""
    found: Array = at.strain + x[parts.response] * at.strain**2 + x[parts.lag] * at.lag
    return found


def _slopes(
    x: Array, at: _Predicted, beyond: _Predicted, by_pressure: _Predicted | None, holds: _Holds, parts: _Parts
) -> Array:
    """Derivatives of what is predicted by the unknowns, (M, R + 2, unknowns)."""
    R, M = parts.readings, len(holds.time)
    slopes = np.zeros((M, R + 2, len(x)))
    gains = np.exp(x[parts.bends] - x[0])
    here, there = (_responding(x, each, parts) for each in (at, beyond))
    by_ratio = gains * (there - (1 + _STEP) * here)
    tip = beyond.tip - at.tip
    slopes[..., 0] = np.column_stack([by_ratio, tip.real, tip.imag]) / _STEP
    i, drifts = np.arange(R), parts.drifts.start + R * holds.recording[:, None] + np.arange(R)
    slopes[:, i, parts.bends.start + i] = gains * here
    slopes[:, i, parts.offsets.start + i] = 1.0
    slopes[:, :R, parts.lag] = gains * at.lag
    slopes[:, :R, parts.response] = gains * at.strain**2
    if by_pressure is not None:
        by = by_pressure.strain * (1 + 2 * x[parts.response] * at.strain) + x[parts.lag] * by_pressure.lag
        tips = by_pressure.tip
        slopes[..., parts.pressure] = np.column_stack([gains * by, tips.real, tips.imag])
    slopes[np.arange(M)[:, None], i, drifts] = holds.time[:, None]
    return slopes


class _Noise(NamedTuple):
    """Standard deviations of what is left of a hold."""

    strain: Array  # (R)
    tip: float  # m


def _scatter(left: Array) -> tuple[_Noise, Array]:
    """The noise that follows from what is left, (M, R + 2), and the weights of the holds, (M).

    From medians, which holds that do not fit hardly move. Readings share some of what is known of their noise, for a
    few holds say little of it.
    """
    count = np.isfinite(left).sum(axis=0)
    free = np.maximum(count - _UNKNOWNS, 1.0)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)  # of a tip that is not measured
        deviations = _STD_PER_MEDIAN * np.nanmedian(np.abs(left), axis=0) * np.sqrt(count / free)
    strain, tip = deviations[:-2] ** 2, np.nan_to_num(deviations[-2:]).max()
    together = (free[:-2] @ strain) / free[:-2].sum()
    shared = np.sqrt((free[:-2] * strain + _SHARED * together) / (free[:-2] + _SHARED))
    noise = _Noise(np.maximum(shared, _LEAST), max(float(tip), TIP))
    relative = left / np.array([*noise.strain, noise.tip, noise.tip])
    return noise, np.minimum(1.0, _HUBER_DEVIATIONS / np.maximum(np.sqrt(np.nanmean(relative**2, axis=1)), 1e-9))
