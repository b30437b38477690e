"""Calibration from free bending: the response of every sensor, and how far a finger bends under pressure.

The stiffness of the nominal finger is scaled: the joint angles q of a finger at rest follow from

    f k(q) / (r (1 + v x)) = f g(p) + w(q) + t(q) ,

with k the elastic torque of a finger that has crept, g the torque of the pressure, w that of the weight, t that of a
measured force with friction on the face, x along the finger from -1 at its base to 1 at its tip; found are the ratio r,
its variation v, and, if forces are measured, the strength f and the friction. A finger that is assumed to creep must
rest for longer than its slowest branch. The sensor i reads the extension ratio

    1 + a_i (s_i + c s_i^2 + h l_i) + b_i + d_i t ,

with s_i the strain, l_i how far the play operators of `strain_errors` lag behind it in the course of the recording, the
gain a, the offset b, the drift d, and, one for all sensors of a finger, for they are those of the material, the width h
of the hysteresis loop as a share of the stroke and the curvature c of the response. The curvature, an offset of the
pressure sensor and the variation are 0 unless they are looked for.

Every hold of the pressure counts as one observation, the median of its samples: what is left is mostly what lasts
longer than a hold. Its standard deviation is estimated from what is left. All numbers have priors, `GAIN` of the gains
and so on, hence a posterior covariance; holds that do not fit count less (Huber). Strain and pressure alone cannot tell
larger gains of all sensors from a finger that bends further, or those of a section from one that bends further there:
these are known no better than the priors say, unless the place of the tip is measured too. A force tells nothing of
them either, since strain per force, like strain per pressure, is of a gain times a compliance: it tells f, by which
every estimated force is multiplied. What estimators trust, a gain times its bend, is known well in any case.

Leading axes are free; T samples, M holds, R readings.
"""

import warnings
from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

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
from soft_gripper.fingers.statics import FacePress, resting_angles, softened, strengthened
from soft_gripper.sensors.calibrated_states import DRIVE, KNOWN_DRIVE, CalibratedStates, distance_stds, state_spreads
from soft_gripper.sensors.fitted_states import FittedStates, Widths
from soft_gripper.sensors.response_curve import CalibratedResponse, ResponseCurve
from soft_gripper.sensors.sensor_layout import SensorLayout, extension_ratios
from soft_gripper.sensors.strain_errors import MINUTE, PLAYS, lagging_strain, moved_plays

# Standard deviations before anything is measured: of gains, of the logarithm of the bend per pressure.
GAIN, RATIO = 0.05, 0.5
OFFSET, DRIFT, HYSTERESIS = 0.1, 2e-3 / MINUTE, 0.02  # extension ratio, 1/s, share of the stroke
TIP = 5e-4  # m, standard deviation of a measured place of the tip, at least
# Pa, offset of its sensor; curvature of the response, over strain; share, of the bend from the middle to the tip
SOUGHT = {"pressure": 1000.0, "response": 0.2, "variation": 0.048}
STRENGTH = 0.2  # of the logarithm of f
_MOST_FRICTION = 3.0  # standard deviations, in the largest coefficient of friction
PLACE = 2e-3  # m, standard deviation of the place of a press, which is that of a recording
_FIXED_STD_SHARE = 1e-6  # share of these, where they are not looked for
_STEPS = {"ratio": 1e-4, "pressure": 100.0, "variation": 1e-3, "strength": 1e-3, "friction": 1e-3}  # for differences
_RATIOS = (0.2, 5.0)
_FIRST, _LEAST = 1e-3, 2e-5  # extension ratio, standard deviations of a median: guess, and least
_UNKNOWNS, _SHARED = 3.0, 4.0  # of a reading, on average; observations that readings share
_STD_PER_MEDIAN = 1.4826  # standard deviation over the median of the absolute values, of normal ones
_HUBER_DEVIATIONS = 2.0  # standard deviations, beyond which residuals count linearly
_DOUBTFUL_DEVIATIONS = 4.0  # beyond which a hold is not free bending
_PASSES = 5  # in which the noise is estimated


@dataclass(frozen=True)
class FreeBending:
    """A recording of T samples in which a finger bends freely, or under a known force, in M holds of its pressure."""

    time: Array  # (T) s
    pressure: Array  # (T) Pa
    gravity: Planar  # (T) in the bending plane, z + i x in B, m/s^2
    ratios: Array  # (T, R) extension ratios that the nominal sensors read, NaN where there is none
    hold: NDArray[np.int_]  # (T) number of the hold in which the finger rests, -1 where it moves
    tip: Planar | None = None  # (T) m, measured tip in the bending plane, z + i x in B; NaN where there is none
    press: FacePress | None = None  # (T) what a measured force does; 0 N where nothing is touched

    @property
    def pressed(self) -> NDArray[np.bool_]:
        """Whether something presses, (T,)."""
        return np.zeros(len(self.time), bool) if self.press is None else self.press.force != 0


class _Holds(NamedTuple):
    """M holds, of all recordings."""

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
    places: tuple[float, ...]  # m, of the presses of each recording from where they are said to be

    def changed(self, name: str, step: float) -> "_Model":
        """With one of the numbers, or all places, larger by a step."""
        value = getattr(self, name)
        larger: Any = tuple(each + step for each in value) if name == "places" else value + step
        return self._replace(**{name: larger})

    def finger(self, nominal: Finger) -> Finger:
        """The finger that they describe."""
        bent = softened(nominal, float(np.exp(self.ratio)), self.variation)
        return replace(strengthened(bent, float(np.exp(self.strength))), pressure_offset=self.pressure)


class _Predicted(NamedTuple):
    """Predictions for a finger of some bend per pressure in the holds."""

    strain: Array  # (M, R)
    lag: Array  # (M, R) of a loop as wide as the stroke
    tip: Planar  # (M) m

    def slope(self, before: "_Predicted", step: float) -> "_Predicted":
        """The derivative by a number that is larger by `step` here than before."""
        strain, lag, tip = self.strain - before.strain, self.lag - before.lag, self.tip - before.tip
        return _Predicted(strain / step, lag / step, tip / step)

    def extrapolated(self, slope: "_Predicted", change: Array, holds: "_Holds") -> "_Predicted":
        """Predictions after a change of a number, or one for each recording, by the derivative with respect to it."""
        by_hold = change[holds.recording] if np.ndim(change) else change
        column = np.reshape(by_hold, (-1, 1))
        return _Predicted(
            self.strain + column * slope.strain, self.lag + column * slope.lag, self.tip + by_hold * slope.tip
        )


class _Linearized(NamedTuple):
    """Predictions that are linear in the numbers of a finger."""

    model: _Model  # about which they are
    predicted: _Predicted  # there
    slopes: dict[str, _Predicted]  # derivatives with respect to its numbers, and to the places of all presses
    holds: _Holds

    def at(self, model: _Model) -> _Predicted:
        """Predictions for other numbers."""
        predicted = self.predicted
        for name, slope in self.slopes.items():
            change = np.subtract(getattr(model, name), getattr(self.model, name))
            predicted = predicted.extrapolated(slope, change, self.holds)
        return predicted


class _Parts:
    """Where in the vector of unknowns they are; first comes the logarithm of the bend per pressure r.

    `bends` are the logarithms of  a r (1 + v x)  in the middles of the sections: readings tell them well, and r and v
    themselves hardly, which makes a fit easy.
    """

    def __init__(self, layout: SensorLayout, recordings: int, fitted: Collection[str]):
        self.fitted = fitted  # of `sought`: the others are 0
        self.readings = readings = layout.readings
        self.lag, self.pressure, self.response, self.variation, self.strength, self.friction = range(1, 7)
        self.sought = {name: getattr(self, name) for name in (*SOUGHT, "strength", "friction")}
        self.bends, self.offsets = (slice(7 + i * readings, 7 + (i + 1) * readings) for i in range(2))
        first = 7 + 2 * readings
        self.places = slice(first, first + recordings)
        self.drifts = slice(first + recordings, None)  # reading after reading, of one recording after the other
        middles = np.cumsum(layout.rest_lengths) - layout.rest_lengths / 2
        self.along = np.tile(2 * middles / layout.finger.length - 1, layout.paths)  # of each reading, -1 to 1

    def model(self, x: Array) -> _Model:
        """The numbers of a finger."""
        numbers = {name: float(x[at]) for name, at in self.sought.items() if name in self.fitted}
        places = tuple(x[self.places].tolist()) if "places" in self.fitted else (0.0,) * len(x[self.places])
        of_finger = {name: numbers.get(name, 0.0) for name in _Model._fields[1:-1]}
        return _Model(ratio=float(x[0]), places=places, **of_finger)

    def gains(self, x: Array) -> Array:
        """Gains of the sensors, (R,)."""
        gains: Array = np.exp(x[self.bends] - x[0] - x[self.variation] * self.along)
        return gains

    def to_gains(self, unknowns: int) -> Array:
        """Derivatives of the logarithms of the gains by the unknowns, (R, unknowns)."""
        rows = np.eye(unknowns)[self.bends]
        rows[:, 0], rows[:, self.variation] = -1.0, -self.along
        return rows

    def begin(self, unknowns: int, log_ratio: float) -> Array:
        """Unknowns of ideal sensors."""
        x: Array = np.zeros(unknowns)
        x[self.bends] = x[0] = log_ratio
        return x


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
    bend_variation: float  # share by which the bend per pressure changes from the middle to the tip
    bend_variation_std: float
    strength: float  # of stiffness and pressure torque, over the nominal ones; 1 without measured forces
    strength_std: float  # 0 without them
    friction: float  # of the presses; 0 without them
    bend_gain_std: float  # of gain times bend of a reading, as a share
    states: CalibratedStates | None = None  # in which it was calibrated


def calibrate(
    layout: SensorLayout, recordings: Sequence[FreeBending], sought: Collection[str] = (), friction: float = 0.9
) -> Calibration:
    """Fits all numbers to recordings, robustly.

    Args:
        layout: nominal.
        recordings: of the finger.
        sought: names of those of SOUGHT to fit as well.
        friction: largest coefficient between the finger and what measures its force.
    """
    holds = _holds(recordings)
    fitted = {*sought, *(("strength", "friction", "places") if holds.pressed.any() else ())}
    parts = _Parts(layout, len(recordings), fitted)
    prior = _prior(parts, len(recordings), friction)
    known = np.isfinite(np.column_stack([holds.strain, holds.tip.real, holds.tip.imag]))
    noise = _Noise(np.full(layout.readings, _FIRST), TIP)
    weights: Array = np.ones(len(holds.time))
    x = parts.begin(len(prior), _first_ratio(layout, recordings, holds))

    def left_at(x: Array) -> Array:
        return _left(x, linearized.at(parts.model(x)), holds, parts)

    def residuals(x: Array) -> Array:
        return np.concatenate([left_at(x)[known], prior @ x])

    def slopes(x: Array, residuals: Array) -> Array:
        return np.vstack([-_slopes(x, linearized, parts)[known], prior])

    most = np.append(np.log(_RATIOS[1]), np.full(len(x) - 1, np.inf))
    least = np.append(np.log(_RATIOS[0]), -most[1:])
    problem = Problem(np.asarray, residuals, slopes, bounds=(least, most), options={"x_scale": "jac"})
    for _ in range(_PASSES):
        linearized = _linearize(layout, recordings, holds, parts.model(x), fitted)
        scale = np.sqrt(weights)[:, None] / np.array([*noise.strain, noise.tip, noise.tip])
        solution = fit(replace(problem, weights=np.append(scale[known], np.ones(len(prior)))), x)
        x = solution.x.copy()
        noise, weights = _scatter(left_at(x))
    x[[index for name, index in parts.sought.items() if name not in fitted]] = 0.0
    covariance = solution.covariance
    left, gains = left_at(x), parts.gains(x)
    gain_covariance = parts.to_gains(len(x)) @ covariance @ parts.to_gains(len(x)).T
    stds = np.sqrt(np.diagonal(covariance))

    def with_std(name: str) -> tuple[float, float]:
        index = parts.sought[name]
        return (float(x[index]), float(stds[index])) if name in fitted else (0.0, 0.0)

    strength, strength_std = with_std("strength")
    return Calibration(
        *(float(np.exp(x[0])), gains, x[parts.offsets], float(np.sqrt(np.nanmean(left[:, : layout.readings] ** 2)))),
        *(float(np.exp(x[0]) * stds[0]), gains * np.sqrt(np.diagonal(gain_covariance)), stds[parts.offsets]),
        *(float(x[parts.lag]), x[parts.drifts].reshape(-1, layout.readings).mean(axis=0)),
        bool(known[:, -1].any()),
        tuple(
            (int(holds.recording[i]), float(holds.time[i]))
            for i in np.flatnonzero(weights < _HUBER_DEVIATIONS / _DOUBTFUL_DEVIATIONS)
        ),
        *(*with_std("pressure"), *with_std("response"), *with_std("variation")),
        *(float(np.exp(strength)), float(np.exp(strength) * strength_std), with_std("friction")[0]),
        _weighted_std(stds[parts.bends], holds.strain - x[parts.offsets]),
        _states(layout, recordings, holds, solution, known, parts, x),
    )


def _states(
    layout: SensorLayout, recordings: Sequence[FreeBending], holds: _Holds, fit: Fit[Array],
    measured: NDArray[np.bool_], parts: _Parts, x: Array,
) -> CalibratedStates | None:  # fmt: skip
    """Where the free finger was calibrated; None if no hold has all readings.

    The residuals of the fit are first those that are `measured`, (M, R + 2), of the holds, then those of the prior.
    """
    R, finger = layout.readings, parts.model(x).finger(layout.finger)
    gains, offsets = (tuple(each.tolist()) for each in (parts.gains(x), x[parts.offsets]))
    response = CalibratedResponse(ResponseCurve(), gains, offsets, float(x[parts.response]))
    by_recording = [np.hstack([response.ratio(each.ratios - 1) - 1, _drive(finger, each)]) for each in recordings]
    states = np.array(
        [
            _median(of[each.hold == hold])
            for of, each in zip(by_recording, recordings, strict=True)
            for hold in range(each.hold.max() + 1)
        ]
    )
    whole = np.isfinite(states).all(axis=-1) & ~holds.pressed
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
    free = [each.press is None or (each.hold >= 0) & ~each.pressed for each in recordings]
    read = [of[np.isfinite(of).all(axis=-1) & at] for of, at in zip(by_recording, free, strict=True)]
    groups = read if len(read) > 1 else np.array_split(read[0], 2)
    apart = fitted_disagreement(groups, spread, R) + np.sqrt(2) * KNOWN_DRIVE
    known = CalibratedStates(FittedStates(states[whole], spread), Widths(np.zeros(1), 0.0), apart, layout.sections)
    fitted = errors(np.zeros(len(x)))[whole].reshape(-1, 1)  # sensors are alike, and holds too few for widths of each
    widths = learned_widths(fitted, [*regions_left_out([space.regions() for space in known.spaces], without)])
    holds_of = [each.hold for each in recordings]
    return replace(known, widths=widths, noise=_noise(by_recording, holds_of, layout.paths) / spread[0])


def _weighted_std(stds: Array, strain: Array) -> float:
    """Standard deviation of a gain of readings, (R,), weighted with their strains, (M, R)."""
    weights = np.nansum(strain**2, axis=0)
    return float(np.sqrt(weights @ stds**2 / weights.sum()))


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


def _prior(parts: _Parts, recordings: int, friction: float) -> Array:
    """Prior of the unknowns, in standard deviations: rows of a matrix, each expected to give 0."""
    priors = SOUGHT | {"strength": STRENGTH, "friction": friction / _MOST_FRICTION}
    looked_for = [std * (1 if name in parts.fitted else _FIXED_STD_SHARE) for name, std in priors.items()]
    of_readings, of_drifts = np.repeat([GAIN, OFFSET], parts.readings), [DRIFT] * recordings * parts.readings
    place = PLACE * (1 if "places" in parts.fitted else _FIXED_STD_SHARE)
    stds = [RATIO, HYSTERESIS, *looked_for, *of_readings, *[place] * recordings, *of_drifts]
    rows = np.diag(1 / np.array(stds))
    rows[parts.bends] = parts.to_gains(len(stds)) / GAIN  # gains, not bends, are about 1
    return rows


def _holds(recordings: Sequence[FreeBending]) -> _Holds:
    """The medians of all holds."""
    found: list[tuple[Array, int, float, complex, bool]] = []
    for number, recording in enumerate(recordings):
        for hold in range(recording.hold.max() + 1):
            at = recording.hold == hold
            strain, tip = _median(recording.ratios[at]) - 1, complex(np.nan, np.nan)
            if recording.tip is not None:
                tip = complex(*_median(np.column_stack([recording.tip[at].real, recording.tip[at].imag])))
            elapsed = float(recording.time[at].mean() - recording.time[0])
            found.append((strain, number, elapsed, tip, bool(recording.pressed[at].any())))
    return _Holds(*(np.array(column) for column in zip(*found, strict=True)))


def _predict(
    layout: SensorLayout, finger: Finger, recordings: Sequence[FreeBending], model: _Model | None = None
) -> _Predicted:
    """Means over the holds, of a finger that is not pressed without a model."""
    parts = []
    for number, recording in enumerate(recordings):
        press = None if model is None else recording.press
        if press is not None and model is not None:
            place = np.clip(press.place + model.places[number], 0.0, finger.length)
            press = press._replace(friction=model.friction, place=place)
        q = resting_angles(finger, recording.pressure, recording.gravity, press)
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
    strain = parts.gains(x) * _responding(x, at, parts) + x[parts.offsets] + drift
    tip = holds.tip - at.tip
    return np.column_stack([holds.strain - strain, tip.real, tip.imag])


def _responding(x: Array, at: _Predicted, parts: _Parts) -> Array:
    """Strains to which sensors respond with their gains, (M, R)."""
    found: Array = at.strain + x[parts.response] * at.strain**2 + x[parts.lag] * at.lag
    return found


def _linearize(
    layout: SensorLayout,
    recordings: Sequence[FreeBending],
    holds: _Holds,
    model: _Model,
    fitted: Collection[str],
) -> _Linearized:
    """Linearizes predictions about a model in the numbers that are fitted."""

    def predict(model: _Model) -> _Predicted:
        return _predict(layout, model.finger(layout.finger), recordings, model)

    predicted = predict(model)
    slopes = {
        name: predict(model.changed(name, step)).slope(predicted, step)
        for name, step in _STEPS.items()
        if name in {"ratio", *fitted}
    }
    if "places" in fitted:  # over a whole link, as friction turns the joint that a place passes at once
        length = layout.finger.segment_length
        low, high = (predict(model.changed("places", side * length / 2)) for side in (-1, 1))
        slopes["places"] = high.slope(low, length)
    return _Linearized(model, predicted, slopes, holds)


def _slopes(x: Array, linearized: _Linearized, parts: _Parts) -> Array:
    """Derivatives of what is predicted with respect to the unknowns, (M, R + 2, unknowns)."""
    holds, at = linearized.holds, linearized.at(parts.model(x))
    R, M = parts.readings, len(holds.time)
    slopes = np.zeros((M, R + 2, len(x)))
    gains, here = parts.gains(x), _responding(x, at, parts)
    of_gains = {"ratio": np.ones(R), "variation": parts.along}
    for name, by in linearized.slopes.items():
        strain = by.strain * (1 + 2 * x[parts.response] * at.strain) + x[parts.lag] * by.lag
        strain = gains * (strain - of_gains.get(name, np.zeros(R)) * here)
        column = np.column_stack([strain, by.tip.real, by.tip.imag])
        if name == "places":
            slopes[np.arange(M), :, parts.places.start + holds.recording] = column
        else:
            slopes[..., parts.sought.get(name, 0)] = column
    i, drifts = np.arange(R), parts.drifts.start + R * holds.recording[:, None] + np.arange(R)
    slopes[:, i, parts.bends.start + i] = gains * here
    slopes[:, i, parts.offsets.start + i] = 1.0
    slopes[:, :R, parts.lag] = gains * at.lag
    slopes[:, :R, parts.response] = gains * at.strain**2
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
