"""Calibration from free bending: the response of every sensor, and how far a finger bends under pressure.

The stiffness of the nominal finger is scaled: the joint angles q of a finger at rest follow from

    f k(q) / (r (1 + v x)) = f g(p) + w(q) + t(q) ,

with k the elastic torque of a finger that has crept, g the torque of the pressure, w that of the weight, t that of a
measured force with friction on the face, x along the finger from -1 at its base to 1 at its tip. Fitted are the ratio
r, its variation v and, if forces are measured, the strength f and the friction. A finger that is assumed to creep must
rest for longer than its slowest branch. The sensor i reads the extension ratio

    1 + a_i (s_i + c s_i^2 + h l_i) + b_i + d_i t ,

with s_i the strain, l_i the lag of the play operators of `strain_errors` behind it in the course of the recording, the
gain a, the offset b, the drift d and, for the material of all sensors of a finger, the width h
of the hysteresis loop as a share of the stroke and the curvature c of the response. The curvature, an offset of the
pressure sensor and the variation are 0 unless they are sought.

Every hold of the pressure counts as one observation, the median of its samples: most of the residual lasts longer than
a hold. Its standard deviation is estimated from the residuals. All numbers have priors, `GAIN` of the gains
and so on, hence a posterior covariance; holds that do not fit count less (Huber). Strain and pressure alone cannot tell
larger gains of all sensors from a finger that bends further, or those of a section from one that bends further there:
only the priors tell them apart, unless the position of the tip is measured too. A force does not help either,
since strain per force, like strain per pressure, is a gain times a compliance: it determines f, by which
every estimated force is multiplied. A gain times its bend, which estimators use, is determined well in any case.

Leading axes are free; T samples, M holds, R readings. Another number of a finger is a field of `_Model`, an index of
`_UnknownIndices` and a prior.
"""

import warnings
from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from soft_gripper.arrays import Array, Planar
from soft_gripper.extras.hardware.fitted_range import (
    COVERAGE,
    LeftOut,
    fitted_disagreement,
    learned_widths,
    regions_left_out,
)
from soft_gripper.extras.hardware.least_squares import Fit, Problem, fit
from soft_gripper.fingers.finger import Finger
from soft_gripper.fingers.kinematics import forward_kinematics, gravity_torque
from soft_gripper.fingers.statics import FacePress, resting_angles, softened, strengthened
from soft_gripper.sensors.calibrated_states import DRIVE, KNOWN_DRIVE, CalibratedStates, distance_stds, state_spreads
from soft_gripper.sensors.fitted_states import FittedStates, Widths
from soft_gripper.sensors.response_curve import CalibratedResponse, ResponseCurve
from soft_gripper.sensors.sensor_layout import SensorLayout, extension_ratios
from soft_gripper.sensors.strain_errors import MINUTE, PLAYS, lagging_strain, moved_plays

GAIN, RATIO = 0.05, 0.5  # prior standard deviations: of gains, of the logarithm of the bend per pressure
OFFSET, DRIFT, HYSTERESIS = 0.1, 2e-3 / MINUTE, 0.02  # extension ratio, 1/s, share of the stroke
TIP = 5e-4  # m, least standard deviation of a measured position of the tip
# Pa, offset of its sensor; curvature of the response, over strain; share, of the bend from the middle to the tip
SOUGHT = {"pressure": 1000.0, "response": 0.2, "variation": 0.048}
STRENGTH = 0.2  # of the logarithm of f
_MAX_FRICTION_STDS = 3.0  # prior standard deviations in the largest coefficient of friction
PLACE = 2e-3  # m, standard deviation of the position of the presses of a recording
_FIXED_STD_SHARE = 1e-6  # share of the prior deviations, for numbers that are not sought
_DIFFERENCE_STEPS = {"ratio": 1e-4, "pressure": 100.0, "variation": 1e-3, "strength": 1e-3, "friction": 1e-3}
_RATIO_BOUNDS = (0.2, 5.0)
_FIRST_STD, _MIN_STD = 1e-3, 2e-5  # extension ratio, standard deviations of a median: first guess, least
_UNKNOWNS_PER_READING, _SHARED_HOLDS = 3.0, 4.0  # of a reading, on average; observations that readings share
_STD_PER_MEDIAN = 1.4826  # standard deviation over the median of the absolute values, of normal ones
_HUBER_DEVIATIONS = 2.0  # standard deviations; larger residuals count linearly
_DOUBTFUL_DEVIATIONS = 4.0  # standard deviations; a hold with larger residuals is not free bending
_NOISE_ITERATIONS = 5  # of the estimate of the noise


@dataclass(frozen=True)
class FreeBending:
    """A recording of T samples and M pressure holds, in which a finger bends freely or under a known force."""

    time: Array  # (T) s
    pressure: Array  # (T) Pa
    gravity: Planar  # (T) in the bending plane, z + i x in B, m/s^2
    ratios: Array  # (T, R) extension ratios that the nominal sensors read, NaN where there is none
    hold: NDArray[np.int_]  # (T) number of the hold in which the finger rests, -1 where it moves
    tip: Planar | None = None  # (T) m, measured tip in the bending plane, z + i x in B; NaN where there is none
    press: FacePress | None = None  # (T) measured force; 0 N without contact

    @property
    def pressed(self) -> NDArray[np.bool_]:
        """Mask of the samples with a contact, (T,)."""
        return np.zeros(len(self.time), bool) if self.press is None else self.press.force != 0


class _Holds(NamedTuple):
    """M pressure holds of all recordings."""

    strain: Array  # (M, R) read, NaN where nothing is
    recording: NDArray[np.int_]  # (M)
    time: Array  # (M) s since the recording began
    tip: Planar  # (M) m, NaN where it is not measured
    pressed: NDArray[np.bool_]  # (M)


class _Model(NamedTuple):
    """Numbers on which the bend of a finger depends; see the module."""

    ratio: float  # logarithm of r
    pressure: float  # Pa, offset of its sensor
    variation: float
    strength: float  # logarithm of f
    friction: float
    places: tuple[float, ...]  # m, of the presses of each recording from their stated position

    def changed(self, name: str, step: float) -> "_Model":
        """Copy with one number, or all places, increased by a step."""
        value = getattr(self, name)
        changed_value: Any = tuple(place + step for place in value) if name == "places" else value + step
        return self._replace(**{name: changed_value})

    def finger(self, nominal: Finger) -> Finger:
        """Copy of a nominal finger with these numbers."""
        softened_finger = softened(nominal, float(np.exp(self.ratio)), self.variation)
        return replace(strengthened(softened_finger, float(np.exp(self.strength))), pressure_offset=self.pressure)


class _Predicted(NamedTuple):
    """Predictions for a finger of some bend per pressure in the holds."""

    strain: Array  # (M, R)
    lag: Array  # (M, R) of a loop as wide as the stroke
    tip: Planar  # (M) m

    def slope(self, reference: "_Predicted", step: float) -> "_Predicted":
        """Difference quotient by a number that is larger by `step` here than in `reference`."""
        strain, lag, tip = self.strain - reference.strain, self.lag - reference.lag, self.tip - reference.tip
        return _Predicted(strain / step, lag / step, tip / step)

    def extrapolated(self, slope: "_Predicted", change: Array, holds: "_Holds") -> "_Predicted":
        """Predictions after a change of a number, or one for each recording, by the derivative with respect to it."""
        hold_change = change[holds.recording] if np.ndim(change) else change
        column = np.reshape(hold_change, (-1, 1))
        strain, lag = self.strain + column * slope.strain, self.lag + column * slope.lag
        return _Predicted(strain, lag, self.tip + hold_change * slope.tip)


class _Linearized(NamedTuple):
    """Predictions that are linear in the numbers of a finger."""

    model: _Model  # about which they are
    predicted: _Predicted  # there
    slopes: dict[str, _Predicted]  # derivatives with respect to its numbers, and to the places of all presses
    holds: _Holds

    def predict(self, model: _Model) -> _Predicted:
        """Predictions for other numbers."""
        predicted = self.predicted
        for name, slope in self.slopes.items():
            change = np.subtract(getattr(model, name), getattr(self.model, name))
            predicted = predicted.extrapolated(slope, change, self.holds)
        return predicted


class _UnknownIndices:
    """Indices of the numbers in the vector of unknowns, which begins with the logarithm of the bend per pressure r.

    `bends` are the logarithms of  a r (1 + v x)  at the middles of the sections. Readings determine these well, but
    r and v poorly, so that a fit is easy in them.
    """

    def __init__(self, layout: SensorLayout, recordings: int, fitted: Collection[str]):
        self.fitted = fitted  # of `sought`: the others are 0
        self.readings = readings = layout.readings
        self.lag, self.pressure, self.response, self.variation, self.strength, self.friction = range(1, 7)
        self.sought = {name: getattr(self, name) for name in (*SOUGHT, "strength", "friction")}
        self.bends, self.offsets = (slice(7 + i * readings, 7 + (i + 1) * readings) for i in range(2))
        first_index = 7 + 2 * readings
        self.places = slice(first_index, first_index + recordings)
        self.drifts = slice(first_index + recordings, None)  # reading after reading, of one recording after the other
        middles = np.cumsum(layout.rest_lengths) - layout.rest_lengths / 2
        self.positions = np.tile(2 * middles / layout.finger.length - 1, layout.paths)  # of each reading, -1 to 1

    def model(self, x: Array) -> _Model:
        """The numbers of a finger."""
        numbers = {name: float(x[index]) for name, index in self.sought.items() if name in self.fitted}
        places = tuple(x[self.places].tolist()) if "places" in self.fitted else (0.0,) * len(x[self.places])
        finger_numbers = {name: numbers.get(name, 0.0) for name in _Model._fields[1:-1]}
        return _Model(ratio=float(x[0]), places=places, **finger_numbers)

    def gains(self, x: Array) -> Array:
        """Gains of the sensors, (R,)."""
        return np.exp(x[self.bends] - x[0] - x[self.variation] * self.positions)

    def to_gains(self, unknowns: int) -> Array:
        """Derivatives of the logarithms of the gains by the unknowns, (R, unknowns)."""
        rows = np.eye(unknowns)[self.bends]
        rows[:, 0], rows[:, self.variation] = -1.0, -self.positions
        return rows

    def begin(self, unknowns: int, log_ratio: float) -> Array:
        """Unknowns of ideal sensors."""
        x: Array = np.zeros(unknowns)
        x[self.bends] = x[0] = log_ratio
        return x


class Calibration(NamedTuple):
    """Estimates of a calibration, and standard deviations."""

    bend_ratio: float  # bend under a pressure over the nominal bend
    gains: Array  # (R)
    offsets: Array  # (R) extension ratio
    residual: float  # root mean square over the holds, extension ratio
    bend_ratio_std: float
    gain_stds: Array  # (R)
    offset_stds: Array  # (R)
    hysteresis: float  # share of the stroke
    drifts: Array  # (R) 1/s, mean of the recordings
    tip_measured: bool  # whether the position of the tip was measured
    doubtful: tuple[tuple[int, float], ...]  # recordings, from 0, and times, s, of holds that are not free bending
    pressure_offset: float  # Pa, of the sensor's reading from the pressure
    pressure_offset_std: float
    response_curvature: float
    response_curvature_std: float
    bend_variation: float  # relative change of the bend per pressure from the middle to the tip
    bend_variation_std: float
    strength: float  # of stiffness and pressure torque, over the nominal ones; 1 without measured forces
    strength_std: float  # 0 without them
    friction: float  # of the presses; 0 without them
    bend_gain_std: float  # of gain times bend of a reading, as a share
    states: CalibratedStates | None = None  # in which it was calibrated


def calibrate(
    layout: SensorLayout, recordings: Sequence[FreeBending], sought: Collection[str] = (), friction: float = 0.9
) -> Calibration:
    """Fits all numbers to recordings of a finger with a nominal layout, robustly.

    `sought` names those of SOUGHT to fit as well; `friction` is the largest coefficient between finger and instrument.
    """
    holds = _holds(recordings)
    fitted = {*sought, *(("strength", "friction", "places") if holds.pressed.any() else ())}
    indices = _UnknownIndices(layout, len(recordings), fitted)
    prior = _prior(indices, len(recordings), friction)
    is_measured = np.isfinite(np.column_stack([holds.strain, holds.tip.real, holds.tip.imag]))
    noise = _Noise(np.full(layout.readings, _FIRST_STD), TIP)
    weights: Array = np.ones(len(holds.time))
    x = indices.begin(len(prior), _first_ratio(layout, recordings, holds))

    def hold_residuals(x: Array) -> Array:
        return _residuals(x, linearized.predict(indices.model(x)), holds, indices)

    def residuals(x: Array) -> Array:
        return np.concatenate([hold_residuals(x)[is_measured], prior @ x])

    def slopes(x: Array, residuals: Array) -> Array:
        return np.vstack([-_slopes(x, linearized, indices)[is_measured], prior])

    upper_bounds = np.append(np.log(_RATIO_BOUNDS[1]), np.full(len(x) - 1, np.inf))
    lower_bounds = np.append(np.log(_RATIO_BOUNDS[0]), -upper_bounds[1:])
    problem = Problem(np.asarray, residuals, slopes, bounds=(lower_bounds, upper_bounds), options={"x_scale": "jac"})
    for _ in range(_NOISE_ITERATIONS):
        linearized = _linearize_holds(layout, recordings, holds, indices.model(x), fitted)
        scale = np.sqrt(weights)[:, None] / np.array([*noise.strain, noise.tip, noise.tip])
        solution = fit(replace(problem, weights=np.append(scale[is_measured], np.ones(len(prior)))), x)
        x = solution.x.copy()
        noise, weights = _estimate_noise(hold_residuals(x))
    x[[index for name, index in indices.sought.items() if name not in fitted]] = 0.0
    covariance = solution.covariance
    misfits, gains = hold_residuals(x), indices.gains(x)
    gain_covariance = indices.to_gains(len(x)) @ covariance @ indices.to_gains(len(x)).T
    stds = np.sqrt(np.diagonal(covariance))

    def with_std(name: str) -> tuple[float, float]:
        index = indices.sought[name]
        return (float(x[index]), float(stds[index])) if name in fitted else (0.0, 0.0)

    strength, strength_std = with_std("strength")
    residual = float(np.sqrt(np.nanmean(misfits[:, : layout.readings] ** 2)))
    doubtful = np.flatnonzero(weights < _HUBER_DEVIATIONS / _DOUBTFUL_DEVIATIONS)
    return Calibration(
        *(float(np.exp(x[0])), gains, x[indices.offsets], residual),
        *(float(np.exp(x[0]) * stds[0]), gains * np.sqrt(np.diagonal(gain_covariance)), stds[indices.offsets]),
        *(float(x[indices.lag]), x[indices.drifts].reshape(-1, layout.readings).mean(axis=0)),
        bool(is_measured[:, -1].any()),
        tuple((int(holds.recording[i]), float(holds.time[i])) for i in doubtful),
        *(*with_std("pressure"), *with_std("response"), *with_std("variation")),
        *(float(np.exp(strength)), float(np.exp(strength) * strength_std), with_std("friction")[0]),
        _weighted_std(stds[indices.bends], holds.strain - x[indices.offsets]),
        _calibrated_states(layout, recordings, holds, solution, is_measured, indices, x),
    )


def _calibrated_states(
    layout: SensorLayout, recordings: Sequence[FreeBending], holds: _Holds, fit: Fit[Array],
    measured: NDArray[np.bool_], indices: _UnknownIndices, x: Array,
) -> CalibratedStates | None:  # fmt: skip
    """States in which the free finger was calibrated; None if no hold has all readings.

    The residuals of the fit are first those that are `measured`, (M, R + 2), of the holds, then those of the prior.
    """
    R, finger = layout.readings, indices.model(x).finger(layout.finger)
    gains, offsets = (tuple(run.tolist()) for run in (indices.gains(x), x[indices.offsets]))
    response = CalibratedResponse(ResponseCurve(), gains, offsets, float(x[indices.response]))
    recording_states = [np.hstack([response.ratio(run.ratios - 1) - 1, _drive(finger, run)]) for run in recordings]
    pairs = [*zip(recording_states, recordings, strict=True)]
    medians = [_median(rows[run.hold == hold]) for rows, run in pairs for hold in range(run.hold.max() + 1)]
    states = np.array(medians)
    whole = np.isfinite(states).all(axis=-1) & ~holds.pressed
    if not whole.any():
        return None
    units = state_spreads(states[whole, :R], states[whole, R:])

    def leave_out(region: NDArray[np.bool_]) -> LeftOut:
        left_out = whole.copy()
        left_out[whole] = region
        nearby = replace(reference, fitted=FittedStates(states[whole & ~left_out], units))
        kept_residuals = np.broadcast_to(~left_out[:, None], measured.shape)[measured]
        is_kept = np.append(kept_residuals, np.ones(len(fit.residuals) - len(kept_residuals), bool))
        distance = distance_stds(nearby.state_distances(states[left_out]), layout.paths)
        return LeftOut(errors(fit.change_without(is_kept))[left_out].reshape(-1, 1), distance.reshape(-1, 1))

    def errors(change: Array) -> Array:
        """Errors of the strains if the unknowns move, (M, R), NaN where a reading is missing."""
        residuals = np.full(measured.shape, np.nan)
        residuals[measured] = np.abs(fit.residuals + fit.slopes @ change)[: measured.sum()]
        return residuals[:, :-2]

    # Under a drive that is a little away from a fitted one, the readings are as far away again.
    free_masks = [run.press is None or (run.hold >= 0) & ~run.pressed for run in recordings]
    free_states = [
        rows[np.isfinite(rows).all(axis=-1) & is_free] for (rows, _), is_free in zip(pairs, free_masks, strict=True)
    ]
    groups = free_states if len(free_states) > 1 else np.array_split(free_states[0], 2)
    disagreement = fitted_disagreement(groups, units, R) + np.sqrt(2) * KNOWN_DRIVE
    fitted = FittedStates(states[whole], units)
    reference = CalibratedStates(fitted, Widths(np.zeros(1), 0.0), disagreement, layout.sections)
    errors_ = errors(np.zeros(len(x)))[whole].reshape(-1, 1)  # sensors are alike, and holds too few for widths of each
    widths = learned_widths(errors_, [*regions_left_out([space.regions() for space in reference.spaces], leave_out)])
    holds_ = [run.hold for run in recordings]
    return replace(reference, widths=widths, noise=_noise(recording_states, holds_, layout.paths) / units[0])


def _weighted_std(stds: Array, strain: Array) -> float:
    """Standard deviation of a gain of readings, (R,), weighted with their strains, (M, R)."""
    weights = np.nansum(strain**2, axis=0)
    return float(np.sqrt(weights @ stds**2 / weights.sum()))


def _median(values: Array) -> Array:
    """Medians of the finite numbers over the first axis; NaN without finite numbers."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)
        return np.asarray(np.nanmedian(values, axis=0))


def _noise(recording_states: Sequence[Array], holds: Sequence[NDArray[np.int_]], paths: int) -> float:
    """95th percentile of the distance of a section's readings from their medians at rest, strain."""
    distances = []
    for states, hold in zip(recording_states, holds, strict=True):
        for number in range(hold.max() + 1):
            readings = states[hold == number, :-DRIVE]
            deviations = (readings - _median(readings)).reshape(len(readings), paths, -1)
            distances.append(np.linalg.norm(deviations, axis=1).ravel())
    return float(np.nanquantile(np.concatenate(distances), COVERAGE))


def _drive(finger: Finger, recording: FreeBending) -> Array:
    """Drive of a finger at rest: torque at the first joint, N m, and gravity along x and z, m/s^2, (T, 3)."""
    q, g = resting_angles(finger, recording.pressure, recording.gravity), recording.gravity
    torque = finger.elastic_torque(q) - gravity_torque(finger, q, g[:, None])
    return np.column_stack([torque[:, 0], g.imag, g.real])


def _prior(indices: _UnknownIndices, recordings: int, friction: float) -> Array:
    """Prior of the unknowns, in standard deviations: rows of a matrix, each expected to give 0."""
    priors = SOUGHT | {"strength": STRENGTH, "friction": friction / _MAX_FRICTION_STDS}
    sought_stds = [std * (1 if name in indices.fitted else _FIXED_STD_SHARE) for name, std in priors.items()]
    reading_stds, drift_stds = np.repeat([GAIN, OFFSET], indices.readings), [DRIFT] * recordings * indices.readings
    place = PLACE * (1 if "places" in indices.fitted else _FIXED_STD_SHARE)
    stds = [RATIO, HYSTERESIS, *sought_stds, *reading_stds, *[place] * recordings, *drift_stds]
    rows = np.diag(1 / np.array(stds))
    rows[indices.bends] = indices.to_gains(len(stds)) / GAIN  # gains, not bends, are about 1
    return rows


def _holds(recordings: Sequence[FreeBending]) -> _Holds:
    """Medians of the recordings' signals in all holds."""
    medians: list[tuple[Array, int, float, complex, bool]] = []
    for number, recording in enumerate(recordings):
        for hold in range(recording.hold.max() + 1):
            rows = recording.hold == hold
            strain, tip = _median(recording.ratios[rows]) - 1, complex(np.nan, np.nan)
            if recording.tip is not None:
                tip = complex(*_median(np.column_stack([recording.tip[rows].real, recording.tip[rows].imag])))
            elapsed = float(recording.time[rows].mean() - recording.time[0])
            medians.append((strain, number, elapsed, tip, bool(recording.pressed[rows].any())))
    return _Holds(*(np.array(column) for column in zip(*medians, strict=True)))


def _predict_holds(
    layout: SensorLayout, finger: Finger, recordings: Sequence[FreeBending], model: _Model | None = None
) -> _Predicted:
    """Predicted means over the holds; without a model, the finger is not pressed."""
    hold_means = []
    for number, recording in enumerate(recordings):
        press = None if model is None else recording.press
        if press is not None and model is not None:
            place = np.clip(press.place + model.places[number], 0.0, finger.length)
            press = press._replace(friction=model.friction, place=place)
        q = resting_angles(finger, recording.pressure, recording.gravity, press)
        strain = extension_ratios(layout, q) - 1
        tip = forward_kinematics(q, finger.segment_length).points[:, -1]
        lags = _lags(strain)
        for hold in range(recording.hold.max() + 1):
            rows = recording.hold == hold
            hold_means.append((strain[rows].mean(axis=0), lags[rows].mean(axis=0), tip[rows].mean()))
    return _Predicted(*(np.array(column) for column in zip(*hold_means, strict=True)))


def _lags(strain: Array) -> Array:
    """Lag of sensors with a loop as wide as the stroke, (T, R)."""
    plays: Array = np.zeros((PLAYS, strain.shape[-1]))
    lags = np.empty_like(strain)
    for i, sample in enumerate(strain):
        plays = moved_plays(plays, sample)
        lags[i] = lagging_strain(plays, sample, 1.0) - sample
    return lags


def _first_ratio(layout: SensorLayout, recordings: Sequence[FreeBending], holds: _Holds) -> float:
    """Logarithm of the ratio of measured to predicted strains, of the reading that moves most."""
    predicted_strain = _predict_holds(layout, layout.finger, recordings).strain
    strain = np.where(np.isfinite(holds.strain), holds.strain, predicted_strain)
    reading = int(np.ptp(predicted_strain, axis=0).argmax())
    model, data = (values[:, reading] - values[:, reading].mean() for values in (predicted_strain, strain))
    return float(np.log(np.clip((model @ data) / (model @ model), *_RATIO_BOUNDS)))


def _residuals(x: Array, predicted: _Predicted, holds: _Holds, indices: _UnknownIndices) -> Array:
    """Residuals of R strains and of the tip's z and x, m, (M, R + 2); NaN if not measured."""
    drift = x[indices.drifts].reshape(-1, indices.readings)[holds.recording] * holds.time[:, None]
    strain = indices.gains(x) * _response_strains(x, predicted, indices) + x[indices.offsets] + drift
    tip = holds.tip - predicted.tip
    return np.column_stack([holds.strain - strain, tip.real, tip.imag])


def _response_strains(x: Array, predicted: _Predicted, indices: _UnknownIndices) -> Array:
    """Strains to which sensors respond with their gains, (M, R)."""
    return predicted.strain + x[indices.response] * predicted.strain**2 + x[indices.lag] * predicted.lag


def _linearize_holds(
    layout: SensorLayout, recordings: Sequence[FreeBending], holds: _Holds, model: _Model, fitted: Collection[str]
) -> _Linearized:
    """Linearizes predictions about a model in the numbers that are fitted."""

    def predict(model: _Model) -> _Predicted:
        return _predict_holds(layout, model.finger(layout.finger), recordings, model)

    predicted = predict(model)
    slopes = {
        name: predict(model.changed(name, step)).slope(predicted, step)
        for name, step in _DIFFERENCE_STEPS.items()
        if name in {"ratio", *fitted}
    }
    if "places" in fitted:  # over a whole link, as friction turns the joint that a place passes at once
        length = layout.finger.segment_length
        base_side, tip_side = (predict(model.changed("places", side * length / 2)) for side in (-1, 1))
        slopes["places"] = tip_side.slope(base_side, length)
    return _Linearized(model, predicted, slopes, holds)


def _slopes(x: Array, linearized: _Linearized, indices: _UnknownIndices) -> Array:
    """Derivatives of the predictions by the unknowns, (M, R + 2, unknowns)."""
    holds, predicted = linearized.holds, linearized.predict(indices.model(x))
    R, M = indices.readings, len(holds.time)
    slopes = np.zeros((M, R + 2, len(x)))
    gains, strains = indices.gains(x), _response_strains(x, predicted, indices)
    gain_slopes = {"ratio": np.ones(R), "variation": indices.positions}
    for name, slope in linearized.slopes.items():
        strain = slope.strain * (1 + 2 * x[indices.response] * predicted.strain) + x[indices.lag] * slope.lag
        strain = gains * (strain - gain_slopes.get(name, np.zeros(R)) * strains)
        column = np.column_stack([strain, slope.tip.real, slope.tip.imag])
        if name == "places":
            slopes[np.arange(M), :, indices.places.start + holds.recording] = column
        else:
            slopes[..., indices.sought.get(name, 0)] = column
    i, drifts = np.arange(R), indices.drifts.start + R * holds.recording[:, None] + np.arange(R)
    slopes[:, i, indices.bends.start + i] = gains * strains
    slopes[:, i, indices.offsets.start + i] = 1.0
    slopes[:, :R, indices.lag] = gains * predicted.lag
    slopes[:, :R, indices.response] = gains * predicted.strain**2
    slopes[np.arange(M)[:, None], i, drifts] = holds.time[:, None]
    return slopes


class _Noise(NamedTuple):
    """Standard deviations of the residuals of a hold."""

    strain: Array  # (R)
    tip: float  # m


def _estimate_noise(residuals: Array) -> tuple[_Noise, Array]:
    """Noise from the residuals, (M, R + 2), and weights of the holds, (M).

    Medians hardly depend on holds that do not fit. Readings share some of the information on their noise, as a
    few holds say little of it.
    """
    counts = np.isfinite(residuals).sum(axis=0)
    freedom = np.maximum(counts - _UNKNOWNS_PER_READING, 1.0)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)  # of a tip that is not measured
        deviations = _STD_PER_MEDIAN * np.nanmedian(np.abs(residuals), axis=0) * np.sqrt(counts / freedom)
    strain, tip = deviations[:-2] ** 2, np.nan_to_num(deviations[-2:]).max()
    mean = (freedom[:-2] @ strain) / freedom[:-2].sum()
    stds = np.sqrt((freedom[:-2] * strain + _SHARED_HOLDS * mean) / (freedom[:-2] + _SHARED_HOLDS))
    noise = _Noise(np.maximum(stds, _MIN_STD), max(float(tip), TIP))
    relative = residuals / np.array([*noise.strain, noise.tip, noise.tip])
    return noise, np.minimum(1.0, _HUBER_DEVIATIONS / np.maximum(np.sqrt(np.nanmean(relative**2, axis=1)), 1e-9))
