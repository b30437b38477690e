"""Recursive estimation of the shape, with sensor errors and model errors estimated along the way.

A Kalman filter (Kalman 1960, doi 10.1115/1.3662552), extended for the gain of the sensors, whose state x is

    z     the load, as its strongest modes:  tau = V z  (`mechanics`); it changes slowly, or jumps
    r, d  how much more the finger bends than nominal, and the pressure that is measured too low:
          k q = u (1 + r) + g d + w + tau , with u the driving torque and g the pressure gain
    c, b  gain error and offset of every reading:  strain = (1 + c) h(q) + b + noise
    a     rate at which every offset drifts, where sensors drift:  b' = a , a' = noise

All but the load are slow: next to constant, the offsets drift at rates that change over hours, and the bend drifts as
far as the finger may creep beyond its model (`creep`). Gains and bend walk a little as well, but become no more
uncertain than they are declared to be. They are learnt in free motion alone. Whether the finger is free is seen from
what the readings differ from those of the free finger, averaged over some samples: as long as it is no more than noise
and the uncertainty of the slow states explain, the slow states are corrected, and cautiously, for errors of sensors are
not white. While the finger is loaded they are kept as they are, with their uncertainty counted (Schmidt 1966, doi
10.1016/B978-1-4831-6716-9.50011-4): else a load that lasts would pass for an offset. The shape of a sample has the r
and d that its readings ask for beside the load, though nothing is learnt from them; else a finger that is not as stiff
as assumed would not have the shape that is read. A finger that bends further than nominal is taken to be softer by as
much, as `calibrate` takes it: the contact is that of its stiffness. Readings of a free finger do not tell whether its
stiffness or its drive differs: 0.5 % of doubt, that of a model which is declared exact, is left in any case. What
cannot be seen is a load that begins before anything is learnt and looks like a finger that bends less than assumed, and
offsets that drifted further while the finger was loaded than their uncertainty allows: let the finger move freely first
and often, or give a smaller `bend_per_pressure`.

Weaker modes of a load bend the finger between the sensors, and stronger ones are taken for the readings that these
change. They are no states, but both count in the covariance of a loaded finger's shape.

The innovation test says when readings are other than predicted: the squared innovation, normalised by its covariance,
over the limit that noise exceeds in one of 1000 samples (Bar-Shalom, Li and Kirubarajan 2001, section 5.4).

A reading that is NaN is left out, and one that no load explains is taken for an outlier: both widen the covariance.
While the bend of a section is hardly read nothing is learnt, and when that lasts the finger counts as loaded.

Hysteresis is a share of the stroke, and remains where the strain is less: a finger that was just released may differ
from a free one by as much, while it is straight again. It is no load, and counts as an error that lasts. And it lags
alike in all sections, so that in free motion it passes for a bend of the finger: that of a free one, which is where its
drive takes it, is known to that share at best.

Away from the states of a calibration (`Mechanics.extrapolation`) errors of drive and readings last as long as the
finger stays there. They are never averaged: a free finger may differ from the predicted one by as much, little is
learnt of it, and shape and contact are as much less certain.

V follows the bent chain where it leaves its plane, and as that couples the deformations of its joints, readings
are linearized about the finger under the load that is known; what the load adds to the readings is the difference
between that finger and the free one. The contact is that which explains the change of the values by the load
(`SurfaceContact`), r = A C V z , with the uncertainty of all states. There may be more values than a load changes
independently, so a little noise is added to each; of them count as many as the load explains, beside that noise.

A finger that bends a tenth less than its nominal model while its pressure rises to 60 kPa in 2 s:

    >>> import numpy as np
    >>> import soft_gripper as sg
    >>> finger = sg.make_station(sg.load_scenario("free_bending")).fingers[0].finger
    >>> layout = sg.sensors.SensorLayout(finger, sections=4)
    >>> driving = finger.pressure_torque(np.linspace(0, 60e3, 200))
    >>> q = finger.angle(0.9 * driving)
    >>> shape = sg.estimators.RecursiveShape(layout)(layout.read(q), driving, np.zeros(3))
    >>> print(f"off by {np.degrees(np.abs(shape.q - q).max()):.3f} degrees at most")
    off by 0.004 degrees at most

Leading axes are free; R readings, S values, D joints, one deformation after the other, M modes of the load, n states.

Symbols, beside those of `gaussian`: x the state, z its part that is the load, V the torques of a unit of each mode; r
relative change of the bend; d error of the pressure, Pa, g pressure gain, N m/Pa; c gain errors and b offsets of the
readings, a rates of these, h the extension ratios that joints give; C compliance of the joints.

The force estimate uses `effective_driving_torque`, which therefore moves as the finger does: noise, differentiated
twice, would amount to 8 mN m.
"""

import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from functools import cache, cached_property
from itertools import accumulate
from operator import attrgetter
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from soft_gripper.array_block import ArrayBlock
from soft_gripper.arrays import Array
from soft_gripper.estimators.batches import LazyArray, map_batches, memoized
from soft_gripper.estimators.contact import LinearizedResidual, SingleForceFit, SurfaceContact
from soft_gripper.estimators.estimate import ShapeEstimate
from soft_gripper.estimators.force_posterior import ContactPosterior
from soft_gripper.estimators.gaussian import kalman_gain
from soft_gripper.estimators.mechanics import ExtrapolationStd, Mechanics, outer
from soft_gripper.estimators.shape_estimator import derive_estimates
from soft_gripper.estimators.uncertainty import EXACT, Uncertainty
from soft_gripper.sensors.measurement import MeasurementModel
from soft_gripper.sensors.strain_errors import MINUTE

EFFECTIVE_DRIVING_TORQUE = "effective_driving_torque"
_BEND_RATIOS = 0.5, 2.0  # beyond these no finger is taken to differ from its nominal model, as by `calibrate`
_LOAD_CHANGE = 0.15  # 1/sqrt(s), random walk of a load, as a share of a usual one
_LOAD_JUMP = 0.2  # of a usual load: standard deviation of a jump within one sample
_AVERAGE_WEIGHT = 0.1  # weight of the newest sample in the average that is compared with the free finger
# Maximum samples and s for which a sensor's error is taken to last when slow states are corrected.
_MAX_CORRELATED_SAMPLES, _CORRELATION_TIME = 30.0, 0.6
_SLOW_GAIN, _SLOW_BEND = 1e-3, 1e-3  # 1/sqrt(s), random walks of c and of r
_DRIFT_RATE_TIME = 3600.0  # s, in which the rate of a drift changes by as much as it is
_BLIND_SAMPLES = 5  # samples without a reading of a bend after which a load can no longer be ruled out
_OUTLIER_STDS = 6.0  # standard deviations, distance of an outlier
_MISSING_VARIANCE = 1e6  # variance of an omitted reading
_MIN_VARIANCE = 1e-30  # variance of a state that is declared exact
_FALSE_ALARM_RATE = 1e-3  # P(noise exceeds the limit of an innovation)
_RESIDUAL_NOISE_RATIO = 0.3  # noise in a value's change by the load, over that of one sample
_MIN_SLOPE_RATIO = 1e-3  # fraction of the largest slope by a bend, below which a bend is not seen at all


class Changes(NamedTuple):
    """Changes of finger and sensors since the nominal model, or its calibration, and their standard deviations."""

    bend_change: Array  # (...) share by which the finger bends further under the same pressure: its stiffness is less
    bend_change_std: Array
    pressure_change: Array  # (...) Pa, by which the measured pressure is too low
    pressure_change_std: Array
    gain_changes: Array  # (..., R) share
    gain_changes_std: Array
    offset_changes: Array  # (..., R) extension ratio
    offset_changes_std: Array


class FilterState(NamedTuple):
    """State of knowledge after a sample."""

    mean: Array  # (..., n)
    covariance: Array  # (..., n, n)
    difference: Array  # (..., R) averaged deviation of the readings from those of the free finger
    loaded: NDArray[np.bool_]  # (...)
    innovation: Array  # (...) squared and normalised, 1 where noise leaves more in 1 of 1000 samples
    drive_errors: Array  # (..., 2) r and d of this sample
    q: Array  # (..., D) rad, and m where joints slide
    extrapolation: Array  # (..., 1 + S) the fields of `ExtrapolationStd`; 0 of a finger that is not calibrated
    stroke: Array  # (..., R) the largest strain so far


@dataclass(frozen=True)
class RecursiveShape:
    """The estimator `recursive` of one finger; a ShapeFunction of recordings, whose first axis is time."""

    layout: MeasurementModel
    uncertainty: Uncertainty = field(default_factory=Uncertainty)
    period: float = 0.01  # s, between samples

    def __call__(self, readings: Array, driving: Array, gravity: Array) -> ShapeEstimate:
        """Joint positions, covariance and contact of samples (T, ...) that follow each other; see ShapeFunction."""
        return self.at(np.arange(len(readings)), readings, driving, gravity)

    def at(self, rows: NDArray[np.int_], readings: Array, driving: Array, gravity: Array) -> ShapeEstimate:
        """Estimates at some of the samples, by increasing indices; all samples are processed."""
        gravity, row_set = np.broadcast_to(gravity, (*driving.shape[:-1], 3)), set(rows.tolist())
        states = self._filter_samples(0, readings, driving, gravity)
        chosen_states = _stack_states(state for i, state in enumerate(states) if i in row_set)
        return self.estimate(chosen_states, driving[rows])

    def over_time(self, readings: Array, driving: Array, gravity: Array) -> FilterState:
        """State of knowledge after each sample of a recording, (T, ...); the first of them leaves no trace."""
        return _stack_states(self._filter_samples(1, readings, driving, gravity))

    def _filter_samples(self, first: int, readings: Array, driving: Array, gravity: Array) -> Iterator[FilterState]:
        """The state after each sample; samples before the `first` leave no trace."""
        initial = state = self.begin(driving.shape[1:-1])
        for i, sample in enumerate(zip(readings, driving, gravity, strict=True)):
            state = self.step(state if i > first else initial, *sample)
            yield state

    def begin(self, shape: tuple[int, ...] = ()) -> FilterState:
        """Initial state of knowledge of a straight finger, with leading axes."""
        states = self._states
        covariance = np.broadcast_to(np.diag(self._initial_variances), (*shape, states, states))
        no_readings = np.zeros((*shape, self.layout.readings))
        return FilterState(
            *(np.zeros((*shape, states)), covariance, no_readings, np.zeros(shape, bool)),
            *(np.zeros(shape), np.zeros((*shape, 2)), np.zeros((*shape, len(self.layout.straight)))),
            *(np.zeros((*shape, 1 + self._values)), no_readings),
        )

    def step(self, last_state: FilterState, readings: Array, driving: Array, gravity: Array) -> FilterState:
        """State of knowledge after one more sample.

        Where driving torque or gravity is not finite, so are the joints, and the readings teach nothing.
        """
        from scipy.special import chdtri

        layout, mechanics = self.layout, self.mechanics
        is_driven = np.isfinite((driving**2).sum(axis=-1) + (gravity**2).sum(axis=-1))[..., None]
        if not is_driven.all():
            readings = np.where(is_driven, readings, np.nan)
            driving, gravity = (np.where(is_driven, values, 0.0) for values in (driving, gravity))
        mean, covariance = self._predict(last_state.mean, last_state.covariance)
        bent = mechanics.bent_finger(np.where(np.isfinite(last_state.q), last_state.q, 0.0))
        weight, modes = mechanics.weight(bent, gravity), mechanics.load_modes(bent)
        strain, load_change, jacobian = self._predict_readings(mean, driving, weight, modes)
        difference: Array = layout.measured(readings) - (1 + self._gains(mean)) * strain - self._offsets(mean)
        is_read = np.isfinite(difference)
        difference = np.where(is_read, difference, 0.0)
        noise = np.where(is_read, self.uncertainty.reading**2, _MISSING_VARIANCE)
        extrapolation = last_state.extrapolation
        if layout.calibrated is not None:
            extrapolation = _deviation_row(memoized(Mechanics.extrapolation, mechanics, readings, driving, gravity))
        size = np.abs(strain + load_change / (1 + self._gains(mean)))
        stroke = np.maximum(last_state.stroke, size)
        bias_covariance = self._bias_covariance(extrapolation, jacobian, stroke**2 - size**2)
        residual = difference - load_change
        innovation = self._innovation(residual, noise, covariance, jacobian, bias_covariance)
        jump = np.diag(_LOAD_JUMP**2 * self._initial_variances * ~self._is_slow)
        covariance = covariance + (innovation > _limits(noise.shape[-1])[0])[..., None, None] * jump
        is_outlier = self._is_outlier(residual, noise, covariance, jacobian, bias_covariance)
        noise, difference = np.where(is_outlier, _MISSING_VARIANCE, noise), np.where(is_outlier, 0.0, difference)
        average = last_state.difference
        average = average + _AVERAGE_WEIGHT * (difference - average) * (noise < _MISSING_VARIANCE)
        is_loaded = self._is_loaded(last_state, average, difference, covariance, jacobian, noise, bias_covariance)
        is_blind = self._is_blind(noise < _MISSING_VARIANCE)
        is_loaded |= is_blind & (covariance[..., 0, 0] > _BLIND_SAMPLES * self._walk_variances[0])
        residual = difference - load_change * (is_loaded | is_blind)[..., None]
        inputs = mean, covariance, residual, jacobian, noise, bias_covariance
        mean, covariance, drive_errors = self._correct(*inputs, is_loaded, is_blind & ~is_loaded)
        torque = self.effective_driving(drive_errors, driving) + weight + self._torque(modes, mean)
        q = np.where(is_driven, mechanics.positions_under(torque), np.nan)
        innovation /= chdtri(np.maximum(is_read.sum(axis=-1), 1), _FALSE_ALARM_RATE)
        return FilterState(mean, covariance, average, is_loaded, innovation, drive_errors, q, extrapolation, stroke)

    def _bias_covariance(self, extrapolation: Array, jacobian: Array, straightened: Array) -> Array:
        """Covariance of lasting errors of the readings, (..., R, R): away from a calibration, and by hysteresis.

        `straightened` is the square of the largest strain so far less that of the strain, (..., R).
        """
        drive_errors = jacobian[..., self._modes + 1] * extrapolation[..., :1]
        reading_errors = np.abs(self.layout.sensitivity) * extrapolation[..., None, 1:]
        variances = reading_errors.reshape(*drive_errors.shape) ** 2 + self.uncertainty.gain**2 * straightened
        return outer(drive_errors) + variances[..., None] * np.eye(variances.shape[-1])

    def estimate(self, state: FilterState, driving: Array) -> ShapeEstimate:
        """The shape and the contact after a sample at a driving torque, (..., D)."""
        return map_batches(self._estimate, *self._state_arrays(state), driving)

    def posterior(self, state: FilterState, driving: Array) -> ContactPosterior:
        """Posterior of one contact after a sample at a driving torque, (..., D)."""
        return map_batches(self._posterior, *self._state_arrays(state), driving)

    @staticmethod
    def _state_arrays(state: FilterState) -> tuple[Array, ...]:
        return state.q, state.mean, state.covariance, state.extrapolation, state.loaded.astype(float)

    def _estimate(
        self, q: Array, mean: Array, covariance: Array, extrapolation: Array, is_loaded: Array, driving: Array
    ) -> ShapeEstimate:
        explained = memoized(RecursiveShape._explain, self, q, mean, covariance, extrapolation, driving)
        return self._explained_shape(*explained, covariance, extrapolation, is_loaded)

    def _explained_shape(
        self, fit: SingleForceFit, joint_jacobian: Array, covariance: Array, extrapolation: Array, is_loaded: Array
    ) -> ShapeEstimate:
        q = fit.linearized.q
        contact, _ = self.contact.reported_contact(fit)
        joint_covariance = joint_jacobian @ covariance @ np.swapaxes(joint_jacobian, -1, -2) + self.mechanics.deviations
        joint_covariance = joint_covariance + outer((1 - is_loaded)[..., None] * self.uncertainty.gain * q)
        weak_mode_errors = is_loaded[..., None, None] * self._weak_mode_errors(fit.linearized, joint_jacobian)
        joint_covariance = joint_covariance + weak_mode_errors @ np.swapaxes(weak_mode_errors, -1, -2)
        if self.layout.calibrated is not None:
            joint_covariance += self._extrapolation_covariance(fit.linearized, extrapolation, is_loaded)
            joint_covariance = joint_covariance + self.mechanics.scale_covariance(q)
        return ShapeEstimate(q, joint_covariance, contact)

    def _posterior(
        self, q: Array, mean: Array, covariance: Array, extrapolation: Array, is_loaded: Array, driving: Array
    ) -> ContactPosterior:
        explained = memoized(RecursiveShape._explain, self, q, mean, covariance, extrapolation, driving)
        shape = LazyArray(lambda: self._explained_shape(*explained, covariance, extrapolation, is_loaded))
        return self.contact.posterior(explained[0])._replace(shape=shape)

    def _explain(
        self, q: Array, mean: Array, covariance: Array, extrapolation: Array, driving: Array
    ) -> tuple[SingleForceFit, Array]:
        """Fits forces in all cells; also returns the Jacobian of the joints by the states."""
        linearized, joint_jacobian = self._linearize(q, mean, covariance, extrapolation, driving)
        return self.contact.explain(linearized), joint_jacobian

    def _weak_mode_errors(self, linearized: LinearizedResidual, joint_jacobian: Array) -> Array:
        """Errors of the joints by one standard deviation of each weaker mode of a load, (..., D, W).

        They are its bends, less those of the stronger modes that its readings are taken for.
        """
        bends = self.mechanics.compliance(linearized.q)[..., None] * self.mechanics.weak_modes
        strong = joint_jacobian[..., : self._modes] * np.sqrt(self.mechanics.load_variances)
        gain, _ = kalman_gain(linearized.slopes, strong @ np.swapaxes(strong, -1, -2), self._noise)
        return np.asarray(bends - gain @ (linearized.slopes @ bends))

    def _extrapolation_covariance(
        self, linearized: LinearizedResidual, extrapolation: Array, is_loaded: Array
    ) -> Array:
        """Covariance of the joints, (..., D, D), due to errors away from a calibration.

        A free finger is where its drive takes it, and a loaded one where its readings are explained.
        """
        q, A, drive_std = linearized.q, linearized.slopes, self._drive_std(linearized.q, extrapolation)
        gain, _ = kalman_gain(A, self.mechanics.load_covariance(linearized.bent, q), self._noise)
        gain = gain * is_loaded[..., None, None]
        value_changes = gain * extrapolation[..., None, 1:]
        drive_std = drive_std - (gain @ (A @ drive_std[..., None]))[..., 0]
        return outer(drive_std) + value_changes @ np.swapaxes(value_changes, -1, -2)

    def _drive_std(self, q: Array, extrapolation: Array) -> Array:
        """Standard deviations of the joints, fully correlated, from drive errors outside a calibration, (..., D)."""
        return np.asarray(self.mechanics.compliance(q) * self.mechanics.pressure_gain * extrapolation[..., :1])

    def _linearize(
        self, q: Array, mean: Array, covariance: Array, extrapolation: Array, driving: Array
    ) -> tuple[LinearizedResidual, Array]:
        """Computes the load's change of the values, and the Jacobian of the joints by the states.

        The stiffness may be as wrong as the bend per driving torque still is: then a share of all values is.
        """
        M, bent, (values, A) = self._modes, self.mechanics.bent_finger(q), self.layout.values_at(q)
        joint_jacobian = self._joint_jacobian(q, driving, self.mechanics.load_modes(bent))
        # A finger that bends further is softer, as `calibrate` has it: its bends are due to so much less force.
        bend_ratio = np.clip(1 + mean[..., M, None, None], *_BEND_RATIOS)
        load_jacobian = A @ (joint_jacobian[..., :M] / bend_ratio)
        load_covariance = load_jacobian @ covariance[..., :M, :M] @ np.swapaxes(load_jacobian, -1, -2)
        load_covariance = load_covariance + A @ self.mechanics.deviations @ np.swapaxes(A, -1, -2)
        stiffness_changes = np.sqrt(covariance[..., M, M] + EXACT**2)[..., None] * values
        residual_covariance = load_covariance + np.diag(_RESIDUAL_NOISE_RATIO**2 * self._noise)
        explained_count = np.trace(np.linalg.solve(residual_covariance, load_covariance), axis1=-2, axis2=-1)
        residual = (load_jacobian @ mean[..., :M, None])[..., 0]
        read_count = np.maximum(explained_count, self.contact.min_read_count)
        residual_covariance = residual_covariance + outer(stiffness_changes)
        if self.layout.calibrated is not None:
            drive_changes = (A @ self._drive_std(q, extrapolation)[..., None])[..., 0]
            residual_covariance = (
                residual_covariance + outer(drive_changes) + extrapolation[..., None, 1:] ** 2 * np.eye(self._values)
            )
        return LinearizedResidual(q, bent, A, read_count, residual, residual_covariance), joint_jacobian

    @cached_property
    def _noise(self) -> Array:
        """Variance of the noise of the values in one sample, (S,)."""
        return self.layout.values(self.layout.read(self.layout.straight), self.uncertainty.reading).variance

    @cached_property
    def _values(self) -> int:
        """Number of values, S."""
        return self.layout.sensitivity.shape[-1]

    def changes(self, state: FilterState) -> Changes:
        """Changes of finger and sensors, as learnt in free motion."""
        readings = self.layout.readings
        std = np.sqrt(np.diagonal(state.covariance, axis1=-2, axis2=-1))
        M = self._modes
        gains, offsets = (slice(M + 2 + begin, M + 2 + begin + readings) for begin in (0, readings))
        state_indices = M, M + 1, gains, offsets
        return Changes(*(values[..., index] for index in state_indices for values in (state.mean, std)))

    def effective_driving(self, drive: Array, driving: Array) -> Array:
        """The driving torque of the nominal finger at the pressure that drives it, (..., D), by r and d, (..., 2)."""
        return driving * (1 + drive[..., :1]) + drive[..., 1:] * self.mechanics.pressure_gain

    def _drive_errors(self, mean: Array) -> Array:
        """r and d, (..., 2)."""
        return mean[..., self._modes : self._modes + 2]

    def _torque(self, modes: Array, mean: Array) -> Array:
        """Torque of the load at the joints, (..., D)."""
        return np.asarray((modes @ mean[..., : self._modes, None])[..., 0])

    def _gains(self, mean: Array) -> Array:
        return mean[..., self._modes + 2 : self._modes + 2 + self.layout.readings]

    def _offsets(self, mean: Array) -> Array:
        begin = self._modes + 2 + self.layout.readings
        return mean[..., begin : begin + self.layout.readings]

    @cached_property
    def mechanics(self) -> Mechanics:
        return Mechanics(self.layout, self.uncertainty)

    @cached_property
    def contact(self) -> SurfaceContact:
        """Contacts that explain a load."""
        return SurfaceContact(self.mechanics)

    @cached_property
    def _modes(self) -> int:
        """Number of load modes, M."""
        return len(self.mechanics.load_variances)

    @cached_property
    def _states(self) -> int:
        return self._modes + 2 + 2 * self.layout.readings + self._rates

    @property
    def _rates(self) -> int:
        """Number of rates of drift among the states."""
        return self.layout.readings if self.uncertainty.drift else 0

    def declare(self, block: ArrayBlock, driving: str) -> ShapeEstimate:
        """Declares the steps of a block around this filter; see `shape_estimator.Filter`.

        Further outputs are `effective_driving_torque` (N) N m in bending, `loaded` (1), 1 if a load bends the finger,
        `innovation` (1), above 1 if the readings are not those predicted, and the fields of `Changes`.
        """
        start, joints, layout = self.begin(), range(self.layout.finger.segments), self.layout
        block.remember(
            "state",
            lambda memory, *sample: self.step(_unflatten(memory, start), *sample),
            *(layout.quantity, driving, "gravity"),
            begin=_flatten(start),
            keep=_flatten,
            over_time=self.over_time,
            loops=True,
        )
        block.derive("q", attrgetter("q"), "state")
        derive_estimates(block, self.estimate, self.posterior, "state", driving)
        block.put_out(
            EFFECTIVE_DRIVING_TORQUE,
            lambda state, driving: self.effective_driving(state.drive_errors, driving)[..., : len(joints)],
            *("state", driving),
            unit="N m",
            joint=joints,
        )
        block.put_out("innovation", lambda state: state.innovation, "state")
        block.put_out("loaded", lambda state: state.loaded.astype(float), "state", meanings=("free", "loaded"))
        block.derive("changes", self.changes, "state")
        for name in Changes._fields:
            unit = {"pressure": "Pa", "offset": layout.unit}.get(name.partition("_")[0], "1")
            axes = layout.axes if "changes" in name else {}
            block.put_out(name, attrgetter(name), "changes", unit=unit, **axes)
        return self.estimate(start, layout.straight)

    @cached_property
    def _is_slow(self) -> NDArray[np.bool_]:
        return np.arange(self._states) >= self._modes

    @cached_property
    def _initial_variances(self) -> Array:
        """Variances of the states before the first sample, (n,)."""
        uncertainty, readings = self.uncertainty, self.layout.readings
        slow_stds = [uncertainty.bend_per_pressure, uncertainty.pressure]
        slow_stds += [uncertainty.gain] * readings + [uncertainty.offset] * readings
        slow_stds += [uncertainty.drift / math.sqrt(MINUTE)] * self._rates
        return np.concatenate([self.mechanics.load_variances, np.square(slow_stds)])

    @cached_property
    def _walk_variances(self) -> Array:
        """Variances added per period, (n,)."""
        uncertainty, readings = self.uncertainty, self.layout.readings
        slow_stds = [math.hypot(_SLOW_BEND, uncertainty.creep), 0.0]
        slow_stds += [_SLOW_GAIN] * readings + [0.0] * readings
        slow_stds += [uncertainty.drift / math.sqrt(MINUTE * _DRIFT_RATE_TIME)] * self._rates
        variances = np.concatenate([_LOAD_CHANGE**2 * self.mechanics.load_variances, np.square(slow_stds)])
        return variances * self.period

    @property
    def _noise_factor(self) -> float:
        """Factor on the variance of the noise where slow states are corrected."""
        return min(_MAX_CORRELATED_SAMPLES, max(_CORRELATION_TIME / self.period, 1.0))

    def _predict(self, mean: Array, covariance: Array) -> tuple[Array, Array]:
        """Mean and covariance of the states a period later."""
        covariance = covariance + np.diag(self._walk_variances)
        if self._rates:
            mean = mean @ self._transition.T
            covariance = self._transition @ covariance @ self._transition.T
        excess = np.diagonal(covariance, axis1=-2, axis2=-1) / self._max_variances
        if (excess <= 1).all():
            return mean, covariance
        ratio = np.sqrt(np.maximum(excess, 1.0))
        return mean, covariance / (ratio[..., :, None] * ratio[..., None, :])

    @cached_property
    def _max_variances(self) -> Array:
        """Variances above which no state rises, (n,): of gains and bend, those before the first sample."""
        variances = np.full(self._states, np.inf)
        variances[self._bounded_states] = np.maximum(self._initial_variances[self._bounded_states], _MIN_VARIANCE)
        return variances

    @cached_property
    def _bounded_states(self) -> list[int]:
        """The states that are never less known than before the first sample: the gains and, without creep, the bend."""
        M, readings = self._modes, self.layout.readings
        return [*([] if self.uncertainty.creep else [M]), *range(M + 2, M + 2 + readings)]

    @cached_property
    def _transition(self) -> Array:
        """State transition over a period, without walks, (n, n)."""
        transition, rates = np.eye(self._states), np.arange(self._states - self._rates, self._states)
        transition[rates - self._rates, rates] = self.period
        return transition

    def _joint_jacobian(self, q: Array, driving: Array, modes: Array) -> Array:
        """Jacobian of the joint positions with respect to the states, (..., D, n)."""
        compliance, M = self.mechanics.compliance(q), self._modes
        jacobian = np.zeros((*q.shape, self._states))
        jacobian[..., :M] = compliance[..., None] * modes
        jacobian[..., M + 1] = compliance * self.mechanics.pressure_gain
        jacobian[..., M] = compliance * driving
        return jacobian

    def _state_jacobian(
        self, q: Array, strain: Array, slopes: Array, mean: Array, driving: Array, modes: Array
    ) -> Array:
        """Jacobian of the measured strains with respect to the states, (..., R, n), at q."""
        readings, first_gain = np.arange(self.layout.readings), self._modes + 2
        jacobian = (1 + self._gains(mean))[..., None] * (slopes @ self._joint_jacobian(q, driving, modes))
        jacobian[..., readings, first_gain + readings] = strain
        jacobian[..., readings, first_gain + len(readings) + readings] = 1.0
        return jacobian

    def _predict_readings(self, mean: Array, driving: Array, weight: Array, modes: Array) -> tuple[Array, Array, Array]:
        """Strains of the free finger, (..., R), the load's change of the readings, (..., R), and their Jacobian."""
        torque = self.effective_driving(self._drive_errors(mean), driving) + weight
        strain = self.layout.predict(self.mechanics.positions_under(torque))
        bent = self.mechanics.positions_under(torque + self._torque(modes, mean))
        loaded_strain, H = self.layout.linearized(bent)
        load_change = (1 + self._gains(mean)) * (loaded_strain - strain)
        return strain, load_change, self._state_jacobian(bent, loaded_strain, H, mean, driving, modes)

    def _innovation(
        self, residual: Array, noise: Array, covariance: Array, jacobian: Array, bias_covariance: Array
    ) -> Array:
        """The squared innovation, normalised by its covariance, (...)."""
        innovation_covariance = jacobian @ covariance @ np.swapaxes(jacobian, -1, -2) + bias_covariance
        return _normalized_square(residual, innovation_covariance + noise[..., None] * np.eye(noise.shape[-1]))

    def _is_outlier(
        self, residual: Array, noise: Array, covariance: Array, jacobian: Array, bias_covariance: Array
    ) -> NDArray[np.bool_]:
        """Readings that no change of the load can explain."""
        variance = ((jacobian @ covariance) * jacobian).sum(axis=-1) + noise
        variance = variance + np.diagonal(bias_covariance, axis1=-2, axis2=-1)
        return np.abs(residual) > _OUTLIER_STDS * np.sqrt(variance)

    def _is_loaded(
        self,
        last_state: FilterState,
        average: Array,
        difference: Array,
        covariance: Array,
        jacobian: Array,
        noise: Array,
        bias_covariance: Array,
    ) -> NDArray[np.bool_]:
        """Whether noise, slow states and biases fail to explain the readings, recently or suddenly."""
        slow_jacobian, identity = jacobian * self._is_slow, np.eye(noise.shape[-1])
        difference_covariance = slow_jacobian @ covariance @ np.swapaxes(slow_jacobian, -1, -2) + bias_covariance
        noises = noise[..., None] * identity
        recent_square = _normalized_square(
            average, difference_covariance + _AVERAGE_WEIGHT / (2 - _AVERAGE_WEIGHT) * noises
        )
        begin_limit, end_limit, sudden_limit = _limits(noise.shape[-1])
        is_loaded = np.where(last_state.loaded, recent_square > end_limit, recent_square > begin_limit)
        return is_loaded | (_normalized_square(difference, difference_covariance + noises) > sudden_limit)

    def _is_blind(self, is_read: NDArray[np.bool_]) -> NDArray[np.bool_]:
        """Whether the bend of any section is barely measured, in either plane."""
        information = self._bend_information
        return np.asarray(np.any(is_read @ information < 0.5 * information.sum(axis=0), axis=-1))

    @cached_property
    def _bend_information(self) -> Array:
        """Information of the readings on the bends of the sections, in both planes as far as they are seen, (R, B)."""
        layout = self.layout
        sections = layout.joint_sections[:, None] == np.arange(layout.sections)
        bends = [deformation in ("bending", "sideways") for deformation in layout.deformations]
        bend_jacobian = layout.jacobian @ np.kron(np.eye(len(bends))[:, bends], sections / layout.joints_per_section)
        is_seen = np.abs(bend_jacobian).max(axis=0) > _MIN_SLOPE_RATIO * np.abs(bend_jacobian).max()
        return np.asarray(bend_jacobian[:, is_seen] ** 2)

    def _correct(
        self,
        mean: Array,
        covariance: Array,
        residual: Array,
        jacobian: Array,
        noise: Array,
        bias_covariance: Array,
        is_loaded: NDArray[np.bool_],
        is_blind: NDArray[np.bool_],
    ) -> tuple[Array, Array, Array]:
        """Mean and covariance for the next sample, and r and d of this one.

        Loaded: the load corrected, slow states kept. Free: no load, slow states corrected. Blind: all kept.
        """
        is_kept = (is_loaded | is_blind)[..., None] | self._is_slow
        mean = mean * is_kept
        covariance = covariance * (is_kept[..., :, None] & is_kept[..., None, :])
        noise = np.where(is_loaded[..., None], noise, self._noise_factor * noise)
        noises = noise[..., None] * np.eye(noise.shape[-1]) + bias_covariance * ~is_loaded[..., None, None]
        cross_covariance = covariance @ np.swapaxes(jacobian, -1, -2)
        innovation_covariance = jacobian @ cross_covariance + noises
        gain = np.swapaxes(np.linalg.solve(innovation_covariance, np.swapaxes(cross_covariance, -1, -2)), -1, -2)
        gain = gain * ~is_blind[..., None, None]
        drive_errors = self._drive_errors(mean + (gain @ residual[..., None])[..., 0])
        gain = gain * (is_loaded[..., None] != self._is_slow)[..., None]
        keep = np.eye(self._states) - gain @ jacobian
        covariance = keep @ covariance @ np.swapaxes(keep, -1, -2)
        covariance = covariance + gain @ noises @ np.swapaxes(gain, -1, -2)
        return mean + (gain @ residual[..., None])[..., 0], covariance, drive_errors


def _normalized_square(difference: Array, covariance: Array) -> Array:
    """Normalised squared difference, (...)."""
    return (difference * np.linalg.solve(covariance, difference[..., None])[..., 0]).sum(axis=-1)


def _deviation_row(extrapolation: ExtrapolationStd | None) -> Array:
    """The standard deviations in a row, (..., 1 + S)."""
    assert extrapolation is not None
    return np.concatenate([extrapolation.pressure[..., None], extrapolation.values], axis=-1)


@cache
def _limits(readings: int) -> Array:
    """Thresholds of normalised differences: where a load begins, where it ends, and where it is present at once."""
    from scipy.special import chdtri

    return chdtri(readings, [0.01, 0.1, 1e-4])


def _stack_states(states: Iterable[FilterState]) -> FilterState:
    """Stacks the states of several samples along a leading axis."""
    return FilterState(*(np.array(part) for part in zip(*states, strict=True)))


def _flatten(state: FilterState) -> Array:
    """Puts all fields in a row, (..., n)."""
    leading_shape = state.loaded.shape
    return np.concatenate([np.reshape(part, (*leading_shape, -1)).astype(float) for part in state], axis=-1)


def _unflatten(numbers: Array, like: FilterState) -> FilterState:
    """The inverse of flattening, with the part sizes of another filter state, which has no leading axes."""
    sizes = [np.size(part) for part in like]
    parts = (numbers[..., end - size : end] for size, end in zip(sizes, accumulate(sizes), strict=True))
    shapes = ((*numbers.shape[:-1], *np.shape(part)) for part in like)
    state = FilterState(*(part.reshape(shape) for part, shape in zip(parts, shapes, strict=True)))
    return state._replace(loaded=state.loaded > 0)
