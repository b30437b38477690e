"""Estimates the probability of each fault, from sample to sample: a bank of tests, one per hypothesis of `faults`.

Ten samples make a window: their mean is compared with the readings that every hypothesis predicts, by a Kalman filter
(extended where the load multiplies the fault) over the bends of the load, lasting errors of the sensors, the error of
the nominal bend per pressure, and the parameters of the fault. The load changes with the drive, as a blocked finger
does, along the shapes that contact forces bend it into (`gaussian`), and now and then at any time; lasting errors
change with the strain, by the assumed gain error and hysteresis. The bend per pressure errs by one fraction along the
whole finger, permanently, with the assumed standard deviation: a finger softer or stiffer than its nominal model by
about as much is neither cut nor leaking, nor held. While the drive changes the finger lags, which counts as noise. So
does the extrapolation error of a drive away from its calibration (`CalibratedStates`): a finger is not faulty because
its nominal model is no longer good. The distance of the readings does not count, or a faulty sensor would excuse
itself.

Evidence for a fault k is the logarithm of the ratio of its likelihood and that of the healthy finger since its onset,
which is unknown: after every window the better of continuing and restarting is kept,

    e_k = max(e_k, 0) + log p(window | k) - log p(window | healthy)

(Page 1954, Continuous inspection schemes, doi 10.1093/biomet/41.1-2.100; Willsky and Jones 1976, doi
10.1109/TAC.1976.1101146, with the fault's size integrated out instead of maximised). A restart begins from the
healthy filter's state before the window. With the odds  o_k  before,  P_k  is proportional to  o_k exp(e_k).

Two things count beyond means. A reading that repeats itself to the last bit while others change is not that of a
working sensor with noise: its past repetitions give the probability. And for all faults the load is one contact at
most, with the misfit X that `force_posterior` finds for the best one: it multiplies the likelihood by exp(-X / 2) once
a second, as consecutive windows at one contact are not independent. Only `held` allows any load, at a fixed price.

R readings, S values, N joints, K hypotheses, n = 2 S + R + 3 states.
"""

import math
from dataclasses import dataclass, field
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.special import log_ndtr

from soft_gripper.arrays import Array
from soft_gripper.estimators.contact import SurfaceContact
from soft_gripper.estimators.force_posterior import one_contact_misfit
from soft_gripper.estimators.mechanics import Mechanics, outer
from soft_gripper.estimators.uncertainty import Uncertainty
from soft_gripper.extras.health.faults import FAULTS, Hypotheses
from soft_gripper.sensors.measurement import MeasurementModel

WINDOW_SAMPLES = 10  # samples
_LAG_RATIO = 0.3  # standard deviation of the lag common to all sections, per change of the free bends in a window
_MODEL_STD = 1e-4  # standard deviation of the model itself, of the full scale
_LOAD_RATE_CHANGE = 0.1  # of the load's rate from window to window, in usual loads per usual pressure
_UNEVEN_LAG_RATIO = 0.1  # standard deviation of the independent lag of a section, per the same change
_JUMP_PROBABILITY = 0.02  # of a jump of the load at a window without the drive
_OFFSET_WALK = 0.1  # random walk of lasting errors per window, of the reading's standard deviation
_BEND_WALK = 3e-4  # rad, random walk of the load's bends at rest
_EXTENDED_CONTACT_STD = 0.03  # deviation of an extended contact from a single force, of the load's bends
_UNEVEN_BEND_STD = 0.005  # model error that is not common to all sections, of the free bends
_LOAD_MISFIT_PRICE = 7.0  # price of any load, as a misfit
_MAX_MISFIT = 80.0  # of a load; larger ones count as this
_STUCK_PROBABILITY = 0.98  # P(a stuck sensor repeats itself)
_LOST_PROBABILITY = 0.02  # P(a working sensor is not read)
_MIN_EVIDENCE = 0.3  # of hypotheses whose load is examined; others take that of the healthy finger
_PRIOR_REPEATS = np.array([[0.3], [3.0]])  # samples at which a reading repeated itself, and changed, before any is read
_MAX_EVIDENCE = 200.0
_MIN_LIMIT = 0.05  # of the full scale
_CUT_LAG_FACTOR = 2.0  # lag of a cut finger by that of one as built
_CUT_CHANGE_ERROR = 0.05  # deviation of a cut's effect from proportional, of the effect
_CUT_WEIGHT_ERROR = 0.05  # deviation of a cut's effect by the changed weight, of the full scale
_ABSURD_DEVIATIONS = 3.0  # standard deviations
_LIMIT_EVIDENCE = 2.5  # evidence that a reading that stays at its extreme is at a limit
_MISSING_VARIANCE = 1e4  # variances of the full scale of a reading that is not finite


class FilterMemory(NamedTuple):
    """Memory of a HealthFilter from sample to sample."""

    mean: Array  # (K, n) of load, lasting errors, fault, its slope, stiffness, load's slope
    covariance: Array  # (K, n, n)
    evidence: Array  # (K)
    age: Array  # (K) windows since the onset
    free: Array  # (S) rad, bends of the free finger at the last window
    driving: Array  # (N) N m, driving torque at the last window
    first_free_bends: Array  # (S) rad, bends of the free finger at the first sample of this window
    counts: Array  # (2, R) samples so far at which a reading repeated itself, and changed
    last: Array  # (R) the last reading, NaN before the first
    sums: Array  # (4, R) of this window: measured quantity; samples finite, repeated, changed
    total: Array  # (N) N m, sum of driving torque and weight over this window
    driving_sum: Array  # (N) N m
    samples: Array  # () of this window
    extremes: Array  # (2, R) least and greatest mean of a window


@dataclass(frozen=True)
class HealthFilter:
    """Filter for the health of one finger and its sensors."""

    layout: MeasurementModel
    uncertainty: Uncertainty = field(default_factory=Uncertainty)
    period: float = 0.01  # s

    @cached_property
    def hypotheses(self) -> Hypotheses:
        """Hypotheses about the faults of the finger and its sensors."""
        return Hypotheses(self.layout, load_pressure=self.uncertainty.load_pressure)

    def begin(self) -> FilterMemory:
        """Memory before the first sample; the finger is straight and healthy."""
        layout = self.layout
        count = len(self.hypotheses.kind)
        values = len(layout.matrix)
        readings = layout.readings
        joints = layout.finger.segments
        variance = np.zeros(self._states)
        variance[values : values + readings] = (
            self.uncertainty.offset**2 + (_OFFSET_WALK * self.uncertainty.reading) ** 2
        )
        variance[values + readings + 2] = self.uncertainty.bend_per_pressure**2
        mean, covariance = self._onset_states(np.zeros(self._states), np.diag(variance))
        zeros = np.zeros(readings)
        torque = np.zeros(joints)
        return FilterMemory(
            *(mean, covariance, np.zeros(count), np.zeros(count), np.zeros(values), torque, np.zeros(values)),
            *(np.zeros((2, readings)), zeros + np.nan, np.zeros((4, readings)), torque, torque, np.zeros(())),
            np.zeros((2, readings)),
        )

    def step(self, memory: FilterMemory, readings: Array, driving: Array, gravity: Array) -> FilterMemory:
        """Memory after one more sample; see ShapeFunction for the inputs.

        A sample is skipped if its driving torque or gravity is not finite, or their squares overflow.
        """
        if not np.isfinite((driving**2).sum() + (gravity**2).sum()):
            return memory
        layout = self.layout
        finger = self.layout.finger
        memory = self._begin_window(memory) if memory.samples >= WINDOW_SAMPLES else memory
        weight = self._mechanics.weight(self._mechanics.bent_finger(finger.angle(driving)), gravity)
        free_bends = layout.matrix @ finger.angle(driving + weight)
        finite = np.isfinite(readings**2)
        is_repeated = readings == memory.last
        changed = finite & np.isfinite(memory.last) & ~is_repeated
        is_repeated &= changed.any()
        strains = np.where(finite, layout.measured(np.where(finite, readings, layout.read(layout.straight))), 0.0)
        memory = memory._replace(
            first_free_bends=free_bends if memory.samples == 0 else memory.first_free_bends,
            last=np.where(finite, readings, memory.last),
            sums=memory.sums + np.array([strains, finite, is_repeated, changed]),
            total=memory.total + driving + weight,
            driving_sum=memory.driving_sum + driving,
            samples=memory.samples + 1,
        )
        return self._update(memory, free_bends, gravity) if memory.samples >= WINDOW_SAMPLES else memory

    def _begin_window(self, memory: FilterMemory) -> FilterMemory:
        """Memory at the beginning of the next window."""
        torque = np.zeros_like(memory.total)
        return memory._replace(sums=np.zeros_like(memory.sums), total=torque, driving_sum=torque, samples=np.zeros(()))

    def probabilities(self, memory: FilterMemory) -> Array:
        """Probabilities of every kind of FAULTS, (len(FAULTS),)."""
        return (self.hypotheses.kind == np.arange(len(FAULTS))[:, None]) @ self._weights(memory)

    def sensor_probabilities(self, memory: FilterMemory) -> Array:
        """Probability that each sensor is at fault, (R,)."""
        return (self.hypotheses.reading == np.arange(self.layout.readings)[:, None]) @ self._weights(memory)

    def _weights(self, memory: FilterMemory) -> Array:
        """Probability of every hypothesis, (K,)."""
        logs = self.hypotheses.log_prior + np.maximum(memory.evidence, 0.0)
        weights = np.exp(logs - logs.max())
        return weights / weights.sum()

    def _update(self, memory: FilterMemory, free_bends: Array, gravity: Array) -> FilterMemory:
        """Memory after the last sample of a window."""
        q = self.layout.finger.angle(memory.total / WINDOW_SAMPLES)
        bends = self.layout.matrix @ q
        driving = memory.driving_sum / WINDOW_SAMPLES
        window = self._summarize(
            memory, q, free_bends - memory.first_free_bends, self._extrapolation_std(q, driving, gravity)
        )
        bend_change = bends - memory.free
        pressure_change = self._pressures(driving - memory.driving)
        born_mean, born_covariance = self._onset_states(memory.mean[0], memory.covariance[0])
        mean = np.stack([memory.mean, born_mean])
        covariance = np.stack([memory.covariance, born_covariance])
        mean, covariance = self._predict(mean, covariance, bend_change, pressure_change, memory.age)
        state_map = self._bend_map(q, driving)
        update = _update_states(mean, covariance, self._observation(mean, window, q, state_map))
        evidence_before = np.stack([memory.evidence, np.zeros_like(memory.evidence)])
        odds = evidence_before + update.log_likelihood + self._repetition_likelihood(update, mean, window, state_map)
        odds[1, 0] = -np.inf  # health has no onset
        best_loads = odds.argmax(axis=0)
        hypotheses = np.arange(odds.shape[1])
        mean, covariance = update.mean[best_loads, hypotheses], update.covariance[best_loads, hypotheses]
        evidence = odds[best_loads, hypotheses] - odds[0, 0]
        evidence = evidence + self._contact_evidence(mean, covariance, q, evidence)
        evidence[self._is_absurd(mean, covariance)] = -_MAX_EVIDENCE
        evidence = evidence - max(float(evidence.max()) - _MAX_EVIDENCE, 0.0)
        evidence[0] = 0.0
        return memory._replace(
            mean=mean,
            covariance=covariance,
            evidence=evidence,
            age=np.where(best_loads == 0, memory.age + 1, 0.0),
            free=bends,
            driving=driving,
            counts=memory.counts + memory.sums[2:],
            extremes=np.array(
                [np.fmin(memory.extremes[0], window.measured), np.fmax(memory.extremes[1], window.measured)]
            ),
        )

    def _is_absurd(self, mean: Array, covariance: Array) -> NDArray[np.bool_]:
        """Mask of hypotheses whose parameter almost surely has the wrong sign, (K,)."""
        f = self._value_count + self.layout.readings
        sign = self.hypotheses.sign
        is_absurd: NDArray[np.bool_] = sign * mean[:, f] < -_ABSURD_DEVIATIONS * np.sqrt(covariance[:, f, f])
        return is_absurd & (sign != 0)

    def _extrapolation_std(self, q: Array, driving: Array, gravity: Array) -> Array:
        """Standard deviation of strains where the drive is away from its calibration, common to all, (R,)."""
        no_readings = np.full(self.layout.readings, np.nan)
        extrapolation = self._mechanics.extrapolation(no_readings, driving, gravity)
        if extrapolation is None:
            return np.zeros(self.layout.readings)
        angle_stds = self._mechanics.compliance(q) * extrapolation.pressure * self._mechanics.pressure_gain
        return np.asarray(self.hypotheses.load_response @ (self.layout.matrix @ angle_stds))

    def _summarize(self, memory: FilterMemory, q: Array, free_change: Array, extrapolation_std: Array) -> "_Window":
        reading_sums, finite_counts, repeat_counts, changes = memory.sums
        is_read = finite_counts > 0
        means = np.where(is_read, reading_sums / np.maximum(finite_counts, 1), np.nan)
        totals = memory.counts + _PRIOR_REPEATS
        working_likelihood = (np.array([repeat_counts, changes]) * np.log(totals / totals.sum(axis=0))).sum(axis=0)
        stuck_likelihood = repeat_counts * math.log(_STUCK_PROBABILITY) + changes * math.log(1 - _STUCK_PROBABILITY)
        losses = WINDOW_SAMPLES - finite_counts
        silent_likelihood = losses * math.log(_STUCK_PROBABILITY) + finite_counts * math.log(1 - _STUCK_PROBABILITY)
        lost_likelihood = losses * math.log(_LOST_PROBABILITY) + finite_counts * math.log(1 - _LOST_PROBABILITY)
        return _Window(
            means,
            self.layout.predict(q),
            is_read,
            np.clip(1 + changes, 1, np.maximum(finite_counts, 1)),
            free_change,
            extrapolation_std,
            working_likelihood + lost_likelihood,
            np.maximum(stuck_likelihood + lost_likelihood, silent_likelihood + working_likelihood),
            stuck_likelihood + lost_likelihood,
            (repeat_counts > WINDOW_SAMPLES / 2) & (np.abs(means) > _MIN_LIMIT * self.hypotheses.full_scale),
            (repeat_counts > 0) & (repeat_counts <= WINDOW_SAMPLES / 2),
            np.where(means > 0, means > memory.extremes[1], means < memory.extremes[0]),
        )

    def _predict(self, mean: Array, covariance: Array, change: Array, drive: float, age: Array) -> tuple[Array, Array]:
        """Predicts states a window later, (2, B, K, ...), for a load that follows the drive and one that jumps."""
        value_count = self._value_count
        readings = self.layout.readings
        hypotheses = self.hypotheses
        uncertainty = self.uncertainty
        size = hypotheses.onset_prior[1]
        dt = WINDOW_SAMPLES * self.period
        walk = np.zeros((2, *covariance.shape[-3:]))
        load_covariance = self._usual_load_covariance
        drive_size = abs(drive)
        steady_rates = _LOAD_RATE_CHANGE * drive_size, _LOAD_RATE_CHANGE * min(drive_size / dt, 1)
        rate_changes = steady_rates, (max(drive_size, 0.2), 1.0)
        bend_walk = _BEND_WALK**2 * np.eye(value_count)
        for load, (bend_rate, slope_rate) in enumerate(rate_changes):
            walk[load, :, :value_count, :value_count] = bend_rate**2 * load_covariance + bend_walk
            walk[load, :, -value_count:, -value_count:] = slope_rate**2 * load_covariance
        strain_changes = hypotheses.load_response @ change
        error_walk = (_OFFSET_WALK * uncertainty.reading) ** 2 + (uncertainty.gain * strain_changes) ** 2
        error_walk = error_walk + uncertainty.drift**2 * dt
        bends = np.arange(value_count)
        cut_hypotheses = hypotheses.indices_of("cut")[:, None]
        walk[:, cut_hypotheses, bends, bends] += (_CUT_CHANGE_ERROR * change) ** 2
        i = np.arange(value_count, value_count + readings)
        walk[:, :, i, i] += error_walk
        f = value_count + readings
        response_squares = (hypotheses.load_response**2).sum(axis=-1)
        variance = (_OFFSET_WALK * uncertainty.reading) ** 2 + _BEND_WALK**2 * response_squares
        for name in ("dead", "saturated"):
            k = hypotheses.indices_of(name)
            walk[:, k, f, f] += variance[hypotheses.reading[k]]
        for name in ("offset", "loose"):  # the first window may hold the onset, and misjudge the size
            k = hypotheses.indices_of(name)
            k = k[age[k] == 0]
            walk[1, k, f, f] += size[k, 0] ** 2
        k = hypotheses.indices_of("drifting")
        walk[:, k, f + 1, f + 1] += (0.02 * size[k, 1]) ** 2
        F = np.eye(self._states)
        F[f, f + 1] = dt
        F[:value_count, -value_count:] = drive * np.eye(value_count)
        covariance = F @ covariance @ F.T
        return mean @ F.T, covariance[None] + walk[:, None]

    def _observation(self, mean: Array, window: "_Window", q: Array, state_map: Array) -> "_Observation":
        """Observation of a window, linearised at the means of the states of every hypothesis, (B, K, n)."""
        hypotheses = self.hypotheses
        value_count = self._value_count
        B = self.hypotheses.load_response
        f = value_count + self.layout.readings
        bends = mean @ state_map.T
        H = np.tile(B @ state_map, (*mean.shape[:-1], 1, 1))
        H[..., value_count:f] = np.eye(self.layout.readings)
        z = np.tile(np.where(window.read, window.measured - window.expected, 0.0), (*mean.shape[:-1], 1))
        lag_strains = B @ window.free_change
        white_variance = self.uncertainty.reading**2 / window.distinct
        common_stds = np.tile(_LAG_RATIO * lag_strains, (len(hypotheses.kind), 1))
        common_extrapolation = np.tile(window.extrapolation_std, (len(hypotheses.kind), 1))
        floor = (_MODEL_STD * hypotheses.full_scale) ** 2
        noise = np.tile(white_variance + (_UNEVEN_LAG_RATIO * lag_strains) ** 2 + floor, (len(hypotheses.kind), 1))
        for name in ("offset", "drifting"):
            k = hypotheses.indices_of(name)
            H[:, k, hypotheses.reading[k], f] = 1
        k = hypotheses.indices_of("loose")
        i = hypotheses.reading[k]
        H[:, k, i, f] = (window.expected + bends @ B.T)[:, k, i]
        k = hypotheses.indices_of("leak")
        H[..., f][:, k] = -(B @ state_map[:, f + 2])
        k = hypotheses.indices_of("cut")
        is_softer = np.arange(len(q)) >= hypotheses.joint[k][:, None]
        angle_response = (B @ self.layout.matrix) * is_softer[:, None]
        size = mean[:, k, f]
        bend_response = size[..., None, None] * (angle_response @ self._angle_map)
        H[..., f][:, k] = (angle_response @ (q + bends[:, k] @ self._angle_map.T)[..., None])[..., 0]
        H[:, k] += bend_response @ state_map
        z[:, k] += (bend_response @ bends[:, k, :, None])[..., 0]
        common_stds[k] *= _CUT_LAG_FACTOR
        noise[k] += (_CUT_LAG_FACTOR * _UNEVEN_LAG_RATIO * lag_strains) ** 2
        for k in (hypotheses.indices_of("dead"), self._limited_hypotheses(window)):
            i = hypotheses.reading[k]
            H[:, k, i, :], H[:, k, i, f] = 0, 1
            z[:, k, i] = np.where(window.read[i], window.measured[i], 0.0)
            common_stds[k, i], common_extrapolation[k, i], noise[k, i] = 0, 0, white_variance[i]
        saturated_hypotheses = hypotheses.indices_of("saturated")
        partly_saturated = saturated_hypotheses[window.is_partly_limited[hypotheses.reading[saturated_hypotheses]]]
        noise[partly_saturated, hypotheses.reading[partly_saturated]] = hypotheses.full_scale**2
        noise[:, ~window.read] = _MISSING_VARIANCE * hypotheses.full_scale**2
        independent_covariance = noise[..., :, None] * np.eye(self.layout.readings)
        return _Observation(H, z, outer(common_stds) + outer(common_extrapolation) + independent_covariance)

    def _bend_map(self, q: Array, driving: Array) -> Array:
        """Matrix from states to bends beyond those of the nominal free finger, rad, (S, n)."""
        state_map = np.zeros((self._value_count, self._states))
        state_map[:, : self._value_count] = np.eye(self._value_count)
        drive_bends = self.layout.matrix @ (self._mechanics.compliance(q) * driving)
        state_map[:, self._value_count + self.layout.readings + 2] = drive_bends
        return state_map

    def _limited_hypotheses(self, window: "_Window") -> NDArray[np.int_]:
        """Hypotheses of sensors at their limits in a window."""
        candidates = self.hypotheses.indices_of("saturated")
        return candidates[window.is_at_limit[self.hypotheses.reading[candidates]]]

    def _repetition_likelihood(self, update: "_Update", mean: Array, window: "_Window", state_map: Array) -> Array:
        """Log-likelihood of repeated readings, lost readings and exceeded limits, (B, K)."""
        hypotheses = self.hypotheses
        state_map = self.hypotheses.load_response @ state_map
        likelihood = np.full(update.log_likelihood.shape, window.working_likelihood.sum())
        dead_hypotheses = hypotheses.indices_of("dead")
        k = self._limited_hypotheses(window)
        i = hypotheses.reading[dead_hypotheses]
        likelihood[:, dead_hypotheses] += window.dead_likelihood[i] - window.working_likelihood[i]
        i = hypotheses.reading[k]
        likelihood[:, k] += window.limit_likelihood[i] - window.working_likelihood[i]
        likelihood[1, k] += _LIMIT_EVIDENCE * window.is_extreme[i]
        excess = np.sign(window.measured[i]) * (window.expected + mean @ state_map.T - window.measured)[:, k, i]
        variance = np.einsum("ki,bkij,kj->bk", state_map[i], update.covariance[:, k], state_map[i])
        likelihood[:, k] += log_ndtr(excess / np.sqrt(variance + self.uncertainty.reading**2 / window.distinct[i]))
        return likelihood

    def _contact_evidence(self, mean: Array, covariance: Array, q: Array, evidence: Array) -> Array:
        """Evidence against every hypothesis from its load, relative to the healthy one, (K,)."""
        value_count = self._value_count
        is_likely = evidence > _MIN_EVIDENCE
        is_likely[0] = True
        load = mean[is_likely, :value_count]
        size = (load**2).sum(axis=-1)[:, None, None]
        shape = q + load[0] @ self._angle_map.T
        floor = (_UNEVEN_BEND_STD * (self.layout.matrix @ q)) ** 2 + 1e-6
        cut = (self.hypotheses.joint >= 0)[:, None] * mean[:, value_count + self.layout.readings, None]
        bend = _CUT_WEIGHT_ERROR * self.hypotheses.full_scale / np.abs(self.hypotheses.load_response).max()
        bend = bend * np.clip(cut[is_likely], 0, 1)
        cut = (_CUT_CHANGE_ERROR * cut[is_likely] * (self.layout.matrix @ q)) ** 2 + bend**2
        load_covariance = covariance[is_likely, :value_count, :value_count]
        load_covariance = load_covariance + (_EXTENDED_CONTACT_STD**2 * size + (floor + cut)[..., None]) * np.eye(
            value_count
        )
        cells = self._contact.cells(shape, self._mechanics.bent_finger(shape), self.layout.matrix)
        X = np.zeros_like(evidence)
        X[is_likely] = np.minimum(
            one_contact_misfit(load, load_covariance, cells, self.uncertainty.largest_force), _MAX_MISFIT
        )
        X[~is_likely] = X[0]
        X[self.hypotheses.indices_of("held")] = np.minimum(X[0], _LOAD_MISFIT_PRICE)
        return (X[0] - X) / 2 * WINDOW_SAMPLES * self.period

    def _onset_states(self, mean: Array, covariance: Array) -> tuple[Array, Array]:
        """States of every hypothesis at its onset, from those of the healthy finger."""
        average, std = self.hypotheses.onset_prior
        f = self._value_count + self.layout.readings
        count = len(average)
        means, covariances = np.tile(mean, (count, 1)), np.tile(covariance, (count, 1, 1))
        means[:, f : f + 2] = average
        covariances[:, f, f], covariances[:, f + 1, f + 1] = (std**2).T
        return means, covariances

    @property
    def _value_count(self) -> int:
        return len(self.layout.matrix)

    @property
    def _states(self) -> int:
        return 2 * self._value_count + self.layout.readings + 3

    def _pressures(self, torque: Array) -> float:
        """Driving torque over the torque of the usual load pressure."""
        gain = self.layout.finger.pressure_gain
        return float(torque @ gain / (gain @ gain) / self.uncertainty.load_pressure)

    @cached_property
    def _angle_map(self) -> Array:
        """Matrix from bends to joint angles, equal within a section, (N, S)."""
        return np.linalg.pinv(self.layout.matrix)

    @cached_property
    def _usual_load_covariance(self) -> Array:
        A = self.layout.matrix
        straight = self.layout.straight
        return A @ self._mechanics.prior(self._mechanics.bent_finger(straight), straight, straight) @ A.T

    @cached_property
    def _contact(self) -> SurfaceContact:
        return SurfaceContact(self._mechanics)

    @cached_property
    def _mechanics(self) -> Mechanics:
        return Mechanics(self.layout, self.uncertainty)


class _Window(NamedTuple):
    """Summary of the samples of a window."""

    measured: Array  # (R)
    expected: Array  # (R) of the free finger
    read: NDArray[np.bool_]  # (R) whether any sample is finite
    distinct: Array  # (R) number of samples that differ: repeated ones average out no rounding
    free_change: Array  # (S) rad, change of the free bends within the window
    extrapolation_std: Array  # (R) away from a calibration, common to all
    working_likelihood: Array  # (R) log-likelihood of repeated and lost readings of a working sensor
    dead_likelihood: Array  # (R) of a dead one
    limit_likelihood: Array  # (R) of one at its limit
    is_at_limit: NDArray[np.bool_]  # (R)
    is_partly_limited: NDArray[np.bool_]  # (R)
    is_extreme: NDArray[np.bool_]  # (R) whether it is beyond all windows before


class _Observation(NamedTuple):
    """Linear model z = H x + noise of R readings."""

    state_map: Array  # H, (B, K, R, n)
    values: Array  # z, (B, K, R)
    noise: Array  # its covariance, (K, R, R)


class _Update(NamedTuple):
    """Posterior of every hypothesis after a window, for the likelier of its two loads."""

    mean: Array  # (B, K, n)
    covariance: Array  # (B, K, n, n)
    log_likelihood: Array  # (B, K)


def _update_states(mean: Array, covariance: Array, observation: _Observation) -> _Update:
    """Updates means, (B, K, n), with covariances (2, B, K, n, n), one for each load, by Kalman."""
    H = observation.state_map
    noise = observation.noise
    cross_covariance = covariance @ np.swapaxes(H, -1, -2)
    residual_covariance = H @ cross_covariance + noise
    residual = observation.values - (H @ mean[..., None])[..., 0]
    inverse = np.linalg.inv(residual_covariance)
    square = (residual * (inverse @ residual[..., None])[..., 0]).sum(axis=-1)
    log_likelihood = (
        np.log([1 - _JUMP_PROBABILITY, _JUMP_PROBABILITY])[:, None, None]
        - (square + np.linalg.slogdet(residual_covariance)[1]) / 2
    )
    best_loads = log_likelihood.argmax(axis=0)[None]

    def best_values(values: Array) -> Array:
        index = best_loads.reshape(*best_loads.shape, *[1] * (values.ndim - best_loads.ndim))
        return np.take_along_axis(values, index, 0)[0]

    gain = best_values(cross_covariance) @ best_values(inverse)
    keep = np.eye(H.shape[-1]) - gain @ H  # Joseph's form, which stays positive
    posterior = keep @ best_values(covariance) @ np.swapaxes(keep, -1, -2) + gain @ noise @ np.swapaxes(gain, -1, -2)
    return _Update(mean + (gain @ residual[..., None])[..., 0], posterior, best_values(log_likelihood))
