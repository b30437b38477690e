"""How probable each fault is, from sample to sample: a bank of tests, one for every hypothesis of `faults`.

Ten samples make a look: their mean is compared with the readings that every hypothesis predicts, by a Kalman filter
(extended where the load multiplies the fault) over the bends of the load, lasting errors of the sensors, the error of
the nominal bend per pressure, and the parameters of the fault. The load changes with the drive, as a blocked finger
does, along the shapes that contact forces bend it into (`gaussian`), and now and then at any time; lasting errors
change with the strain, by the gain error and hysteresis assumed. The bend per pressure is off by one share along the
whole finger, for good, with the standard deviation that is assumed: a finger that is softer or stiffer than its nominal
model by about so much is neither cut nor leaking, nor held. While the drive changes the finger lags, which counts as
noise. So does what a calibration does not say of a drive that is far from those in it (`CalibratedStates`): a finger
whose drive leaves its calibration is not faulty because its nominal model is no longer good. How far the readings are
from it does not count, or a faulty sensor would excuse itself.

Evidence for a fault k is the logarithm of the ratio of its likelihood and that of the healthy finger since its onset,
which is unknown: after every look the better of going on and beginning anew is kept,

    e_k = max(e_k, 0) + log p(look | k) - log p(look | healthy)

(Page 1954, Continuous inspection schemes, doi 10.1093/biomet/41.1-2.100; Willsky and Jones 1976, doi
10.1109/TAC.1976.1101146, with the fault's size integrated out instead of maximised). Beginning anew starts from what
the healthy filter knew before the look. With the odds  o_k  before,  P_k  is proportional to  o_k exp(e_k).

Two things that means do not show count as well. A reading that repeats itself to the last bit while others change is
not that of a working sensor with noise: how often it repeated itself so far says how improbable that is. And whatever
the faults, the load is one contact at most, with the misfit X that `force_posterior` finds for the best of them: it
multiplies the likelihood by exp(-X / 2) once a second, as consecutive looks at one contact are not independent.
Only under `held` any load may be, for a fixed price.

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

LOOK = 10  # samples
_LAG = 0.3  # of the change of the free bends within a look: standard deviation of the lag, common to all sections
_EXACT = 1e-4  # of the full scale: standard deviation of the model itself
_LOAD_RATE_CHANGE = 0.1  # of a usual load per usual pressure: how the load's rate changes from look to look
_UNEVEN = 0.1  # likewise, independent
_SUDDEN = 0.02  # probability that the load jumps at a look without the drive
_WALK = 0.1  # of the reading's standard deviation: random walk of lasting errors from look to look
_REST = 3e-4  # rad, random walk of the load's bends at rest
_SPREAD = 0.03  # of the load's bends: how far a spread contact is from a single force
_UNSHARED = 0.005  # of the free bends: error of the model that is not common to all sections
_LOAD_PRICE = 7.0  # price of any load, as a misfit
_LARGEST_MISFIT = 80.0  # of a misfit: beyond, no assumption is good enough to be counted
_STUCK, _LOST = 0.98, 0.02  # probabilities that a stuck sensor repeats itself, and that a working one is not read
_LEAST_EVIDENCE = 0.3  # evidence of hypotheses whose load is examined; of others it is that of the healthy finger
_PRIOR_REPEATS = np.array([[0.3], [3.0]])  # samples at which a reading repeated itself, and changed, before any is read
_MOST_EVIDENCE = 200.0
_LEAST_LIMIT = 0.05  # of the full scale
_OTHER_MOTION = 2.0  # times the lag of a finger as built: that of a cut one
_INEXACT = 0.05  # of what a cut changes: how far that is from proportional
_WEIGHED = 0.05  # of the full scale: how far it is from that because the weight pulls otherwise
_ABSURD_DEVIATIONS = 3.0  # standard deviations
_LIMIT_EVIDENCE = 2.5  # evidence that a reading that stays at its extreme is at a limit
_MISSING_VARIANCE = 1e4  # variances of the full scale of a reading that is not finite


class Known(NamedTuple):
    """Memory from sample to sample."""

    mean: Array  # (K, n) of load, lasting errors, fault, its slope, stiffness, load's slope
    covariance: Array  # (K, n, n)
    evidence: Array  # (K)
    age: Array  # (K) looks since the onset
    free: Array  # (S) rad, bends of the free finger at the last look
    driving: Array  # (N) N m, likewise
    begun: Array  # (S) rad, bends of the free finger at the first sample of this look
    counts: Array  # (2, R) samples so far at which a reading repeated itself, and changed
    last: Array  # (R) the last reading, NaN before the first
    sums: Array  # (4, R) of this look: measured quantity; samples finite, repeated, changed
    total: Array  # (N) N m, sum of driving torque and weight over this look
    sums_of_driving: Array  # (N) N m
    samples: Array  # () of this look
    most: Array  # (2, R) least and greatest mean of a look


@dataclass(frozen=True)
class HealthFilter:
    """The health of one finger and its sensors."""

    layout: MeasurementModel
    uncertainty: Uncertainty = field(default_factory=Uncertainty)
    period: float = 0.01  # s

    @cached_property
    def hypotheses(self) -> Hypotheses:
        """Hypotheses of what may be wrong."""
        return Hypotheses(self.layout, load_pressure=self.uncertainty.load_pressure)

    def begin(self) -> Known:
        """Before the first sample; the finger is straight and nothing is wrong."""
        layout, count = self.layout, len(self.hypotheses.kind)
        values, readings, joints = len(layout.matrix), layout.readings, layout.finger.segments
        variance = np.zeros(self._states)
        variance[values : values + readings] = self.uncertainty.offset**2 + (_WALK * self.uncertainty.reading) ** 2
        variance[values + readings + 2] = self.uncertainty.bend_per_pressure**2
        mean, covariance = self._born(np.zeros(self._states), np.diag(variance))
        nothing, torque = np.zeros(readings), np.zeros(joints)
        return Known(
            *(mean, covariance, np.zeros(count), np.zeros(count), np.zeros(values), torque, np.zeros(values)),
            *(np.zeros((2, readings)), nothing + np.nan, np.zeros((4, readings)), torque, torque, np.zeros(())),
            np.zeros((2, readings)),
        )

    def step(self, known: Known, readings: Array, driving: Array, gravity: Array) -> Known:
        """Memory after one more sample; see ShapeFunction for the inputs.

        A sample whose driving torque or gravity is not finite, or of which the squares overflow, is left out.
        """
        if not np.isfinite((driving**2).sum() + (gravity**2).sum()):
            return known
        layout, finger = self.layout, self.layout.finger
        known = self._begun(known) if known.samples >= LOOK else known
        weight = self._mechanics.weight(self._mechanics.posture(finger.angle(driving)), gravity)
        free = layout.matrix @ finger.angle(driving + weight)
        finite = np.isfinite(readings**2)
        repeated = readings == known.last
        changed = finite & np.isfinite(known.last) & ~repeated
        repeated &= changed.any()
        measured = np.where(finite, layout.measured(np.where(finite, readings, layout.read(layout.straight))), 0.0)
        known = known._replace(
            begun=free if known.samples == 0 else known.begun,
            last=np.where(finite, readings, known.last),
            sums=known.sums + np.array([measured, finite, repeated, changed]),
            total=known.total + driving + weight,
            sums_of_driving=known.sums_of_driving + driving,
            samples=known.samples + 1,
        )
        return self._look(known, free, gravity) if known.samples >= LOOK else known

    def _begun(self, known: Known) -> Known:
        """Memory at the beginning of the next look."""
        torque = np.zeros_like(known.total)
        return known._replace(
            sums=np.zeros_like(known.sums), total=torque, sums_of_driving=torque, samples=np.zeros(())
        )

    def probabilities(self, known: Known) -> Array:
        """Probabilities of every kind of FAULTS, (len(FAULTS),)."""
        found: Array = (self.hypotheses.kind == np.arange(len(FAULTS))[:, None]) @ self._weights(known)
        return found

    def of_readings(self, known: Known) -> Array:
        """Probability that each sensor is at fault, (R,)."""
        found: Array = (self.hypotheses.reading == np.arange(self.layout.readings)[:, None]) @ self._weights(known)
        return found

    def _weights(self, known: Known) -> Array:
        """The probability of every hypothesis, (K,)."""
        logs = self.hypotheses.log_prior + np.maximum(known.evidence, 0.0)
        weights = np.exp(logs - logs.max())
        found: Array = weights / weights.sum()
        return found

    def _look(self, known: Known, free: Array, gravity: Array) -> Known:
        """After the last sample of a look."""
        q = self.layout.finger.angle(known.total / LOOK)
        now = self.layout.matrix @ q
        driving = known.sums_of_driving / LOOK
        look = self._seen(known, q, free - known.begun, self._away(q, driving, gravity))
        change, drive = now - known.free, self._pressures(driving - known.driving)
        born_mean, born_covariance = self._born(known.mean[0], known.covariance[0])
        mean = np.stack([known.mean, born_mean])
        covariance = np.stack([known.covariance, born_covariance])
        mean, covariance = self._predicted(mean, covariance, change, drive, known.age)
        by_state = self._beyond_free(q, driving)
        found = _updated(mean, covariance, self._observation(mean, look, q, by_state))
        before = np.stack([known.evidence, np.zeros_like(known.evidence)])
        total = before + found.log_likelihood + self._of_repetitions(found, mean, look, by_state)
        total[1, 0] = -np.inf  # that nothing is wrong has no onset
        best, every = total.argmax(axis=0), np.arange(total.shape[1])
        mean, covariance = found.mean[best, every], found.covariance[best, every]
        evidence = total[best, every] - total[0, 0]
        evidence = evidence + self._of_contact(mean, covariance, q, evidence)
        evidence[self._is_absurd(mean, covariance)] = -_MOST_EVIDENCE
        evidence = evidence - max(float(evidence.max()) - _MOST_EVIDENCE, 0.0)
        evidence[0] = 0.0
        return known._replace(
            mean=mean,
            covariance=covariance,
            evidence=evidence,
            age=np.where(best == 0, known.age + 1, 0.0),
            free=now,
            driving=driving,
            counts=known.counts + known.sums[2:],
            most=np.array([np.fmin(known.most[0], look.measured), np.fmax(known.most[1], look.measured)]),
        )

    def _is_absurd(self, mean: Array, covariance: Array) -> NDArray[np.bool_]:
        """Whether the parameter of a hypothesis surely has the wrong sign, (K,)."""
        f, sign = self._values + self.layout.readings, self.hypotheses.sign
        absurd: NDArray[np.bool_] = sign * mean[:, f] < -_ABSURD_DEVIATIONS * np.sqrt(covariance[:, f, f])
        return absurd & (sign != 0)

    def _away(self, q: Array, driving: Array, gravity: Array) -> Array:
        """Standard deviation of strains where the drive is away from its calibration, common to all, (R,)."""
        unread = np.full(self.layout.readings, np.nan)
        away = self._mechanics.away(unread, driving, gravity)
        if away is None:
            return np.zeros(self.layout.readings)
        moved = self._mechanics.compliance(q) * away.pressure * self._mechanics.pressure_gain
        return np.asarray(self.hypotheses.by_load @ (self.layout.matrix @ moved))

    def _seen(self, known: Known, q: Array, moved: Array, away: Array) -> "_Look":
        measured, finite, repeated, changed = known.sums
        read = finite > 0
        mean = np.where(read, measured / np.maximum(finite, 1), np.nan)
        before = known.counts + _PRIOR_REPEATS
        working = (np.array([repeated, changed]) * np.log(before / before.sum(axis=0))).sum(axis=0)
        stuck = repeated * math.log(_STUCK) + changed * math.log(1 - _STUCK)
        lost = LOOK - finite
        silent = lost * math.log(_STUCK) + finite * math.log(1 - _STUCK)
        of_lost = lost * math.log(_LOST) + finite * math.log(1 - _LOST)
        return _Look(
            mean,
            self.layout.predict(q),
            read,
            np.clip(1 + changed, 1, np.maximum(finite, 1)),
            moved,
            away,
            working + of_lost,
            np.maximum(stuck + of_lost, silent + working),
            stuck + of_lost,
            (repeated > LOOK / 2) & (np.abs(mean) > _LEAST_LIMIT * self.hypotheses.full_scale),
            (repeated > 0) & (repeated <= LOOK / 2),
            np.where(mean > 0, mean > known.most[1], mean < known.most[0]),
        )

    def _predicted(
        self, mean: Array, covariance: Array, change: Array, drive: float, age: Array
    ) -> tuple[Array, Array]:
        """A look later, for a load that follows the drive and one that jumps, (2, ...) more."""
        values, readings, hypotheses = self._values, self.layout.readings, self.hypotheses
        assumed, size, dt = self.uncertainty, hypotheses.size[1], LOOK * self.period
        walk = np.zeros((2, *covariance.shape[-3:]))
        of_load = self._of_usual_load
        driven = abs(drive)
        steady = _LOAD_RATE_CHANGE * driven, _LOAD_RATE_CHANGE * min(driven / dt, 1)
        shares = steady, (max(driven, 0.2), 1.0)
        for load, (of_bend, of_slope) in enumerate(shares):
            walk[load, :, :values, :values] = of_bend**2 * of_load + (_REST**2) * np.eye(values)
            walk[load, :, -values:, -values:] = of_slope**2 * of_load
        expected = hypotheses.by_load @ change
        lasting = (_WALK * assumed.reading) ** 2 + (assumed.gain * expected) ** 2 + assumed.drift**2 * dt
        bends, cut = np.arange(values), hypotheses.of("cut")[:, None]
        walk[:, cut, bends, bends] += (_INEXACT * change) ** 2
        i = np.arange(values, values + readings)
        walk[:, :, i, i] += lasting
        f = values + readings
        resting = (_WALK * assumed.reading) ** 2 + _REST**2 * (hypotheses.by_load**2).sum(axis=-1)
        for name in ("dead", "saturated"):
            of = hypotheses.of(name)
            walk[:, of, f, f] += resting[hypotheses.reading[of]]
        for name in ("offset", "loose"):  # the first look may hold the onset: what it says of the size is wrong
            of = hypotheses.of(name)
            of = of[age[of] == 0]
            walk[1, of, f, f] += size[of, 0] ** 2
        of = hypotheses.of("drifting")
        walk[:, of, f + 1, f + 1] += (0.02 * size[of, 1]) ** 2
        F = np.eye(self._states)
        F[f, f + 1] = dt
        F[:values, -values:] = drive * np.eye(values)
        covariance = F @ covariance @ F.T
        return mean @ F.T, covariance[None] + walk[:, None]

    def _observation(self, mean: Array, look: "_Look", q: Array, by_state: Array) -> "_Observation":
        """How a look depends on the states of every hypothesis, linearised at their means, (B, K, n)."""
        hypotheses, values, B = self.hypotheses, self._values, self.hypotheses.by_load
        f, beyond = values + self.layout.readings, mean @ by_state.T
        H = np.tile(B @ by_state, (*mean.shape[:-1], 1, 1))
        H[..., values:f] = np.eye(self.layout.readings)
        z = np.tile(np.where(look.read, look.measured - look.expected, 0.0), (*mean.shape[:-1], 1))
        lag, white = B @ look.moved, self.uncertainty.reading**2 / look.apart
        common, away = (np.tile(each, (len(hypotheses.kind), 1)) for each in (_LAG * lag, look.away))
        floor = (_EXACT * hypotheses.full_scale) ** 2
        noise = np.tile(white + (_UNEVEN * lag) ** 2 + floor, (len(hypotheses.kind), 1))
        for name in ("offset", "drifting"):
            k = hypotheses.of(name)
            H[:, k, hypotheses.reading[k], f] = 1
        k = hypotheses.of("loose")
        i = hypotheses.reading[k]
        H[:, k, i, f] = (look.expected + beyond @ B.T)[:, k, i]
        k = hypotheses.of("leak")
        H[..., f][:, k] = -(B @ by_state[:, f + 2])
        k = hypotheses.of("cut")
        softer = np.arange(len(q)) >= hypotheses.joint[k][:, None]
        by_angles, size = (B @ self.layout.matrix) * softer[:, None], mean[:, k, f]
        by_bends = size[..., None, None] * (by_angles @ self._shared)
        H[..., f][:, k] = (by_angles @ (q + beyond[:, k] @ self._shared.T)[..., None])[..., 0]
        H[:, k] += by_bends @ by_state
        z[:, k] += (by_bends @ beyond[:, k, :, None])[..., 0]
        common[k] *= _OTHER_MOTION
        noise[k] += (_OTHER_MOTION * _UNEVEN * lag) ** 2
        for k in (hypotheses.of("dead"), self._at_limit(look)):
            i = hypotheses.reading[k]
            H[:, k, i, :], H[:, k, i, f] = 0, 1
            z[:, k, i] = np.where(look.read[i], look.measured[i], 0.0)
            common[k, i], away[k, i], noise[k, i] = 0, 0, white[i]
        saturated = hypotheses.of("saturated")
        partly = saturated[look.partly[hypotheses.reading[saturated]]]
        noise[partly, hypotheses.reading[partly]] = hypotheses.full_scale**2
        noise[:, ~look.read] = _MISSING_VARIANCE * hypotheses.full_scale**2
        each = noise[..., :, None] * np.eye(self.layout.readings)
        return _Observation(H, z, outer(common) + outer(away) + each)

    def _beyond_free(self, q: Array, driving: Array) -> Array:
        """From the states to the bends beyond those of the nominal free finger, rad, (S, n)."""
        by_state = np.zeros((self._values, self._states))
        by_state[:, : self._values] = np.eye(self._values)
        driven = self.layout.matrix @ (self._mechanics.compliance(q) * driving)
        by_state[:, self._values + self.layout.readings + 2] = driven
        return by_state

    def _at_limit(self, look: "_Look") -> NDArray[np.int_]:
        """The hypotheses of a sensor that is at its limit in a look."""
        saturated = self.hypotheses.of("saturated")
        limited: NDArray[np.int_] = saturated[look.at_limit[self.hypotheses.reading[saturated]]]
        return limited

    def _of_repetitions(self, found: "_Updated", mean: Array, look: "_Look", by_state: Array) -> Array:
        """Log-likelihood of what repeated itself and of what was not read, (B, K), and of limits being exceeded."""
        hypotheses, by_state = self.hypotheses, self.hypotheses.by_load @ by_state
        likelihood = np.full(found.log_likelihood.shape, look.working.sum())
        dead, limited = hypotheses.of("dead"), self._at_limit(look)
        i = hypotheses.reading[dead]
        likelihood[:, dead] += look.stuck[i] - look.working[i]
        i = hypotheses.reading[limited]
        likelihood[:, limited] += look.limited[i] - look.working[i]
        likelihood[1, limited] += _LIMIT_EVIDENCE * look.furthest[i]
        beyond = np.sign(look.measured[i]) * (look.expected + mean @ by_state.T - look.measured)[:, limited, i]
        variance = np.einsum("ki,bkij,kj->bk", by_state[i], found.covariance[:, limited], by_state[i])
        likelihood[:, limited] += log_ndtr(beyond / np.sqrt(variance + self.uncertainty.reading**2 / look.apart[i]))
        return likelihood

    def _of_contact(self, mean: Array, covariance: Array, q: Array, evidence: Array) -> Array:
        """Evidence against every hypothesis from its load, relative to the healthy one, (K,)."""
        values, alive = self._values, evidence > _LEAST_EVIDENCE
        alive[0] = True
        load = mean[alive, :values]
        size = (load**2).sum(axis=-1)[:, None, None]
        shape = q + load[0] @ self._shared.T
        floor = (_UNSHARED * (self.layout.matrix @ q)) ** 2 + 1e-6
        cut = (self.hypotheses.joint >= 0)[:, None] * mean[:, values + self.layout.readings, None]
        bend = _WEIGHED * self.hypotheses.full_scale / np.abs(self.hypotheses.by_load).max()
        bend = bend * np.clip(cut[alive], 0, 1)
        cut = (_INEXACT * cut[alive] * (self.layout.matrix @ q)) ** 2 + bend**2
        spread = covariance[alive, :values, :values]
        spread = spread + (_SPREAD**2 * size + (floor + cut)[..., None]) * np.eye(values)
        cells = self._contact.cells(shape, self._mechanics.posture(shape), self.layout.matrix)
        X = np.zeros_like(evidence)
        X[alive] = np.minimum(one_contact_misfit(load, spread, cells, self.uncertainty.largest_force), _LARGEST_MISFIT)
        X[~alive] = X[0]
        X[self.hypotheses.of("held")] = np.minimum(X[0], _LOAD_PRICE)
        return (X[0] - X) / 2 * LOOK * self.period

    def _born(self, mean: Array, covariance: Array) -> tuple[Array, Array]:
        """Every hypothesis at its onset, from what the healthy filter knows."""
        average, std = self.hypotheses.size
        f = self._values + self.layout.readings
        count = len(average)
        means, covariances = np.tile(mean, (count, 1)), np.tile(covariance, (count, 1, 1))
        means[:, f : f + 2] = average
        covariances[:, f, f], covariances[:, f + 1, f + 1] = (std**2).T
        return means, covariances

    @property
    def _values(self) -> int:
        return len(self.layout.matrix)

    @property
    def _states(self) -> int:
        return 2 * self._values + self.layout.readings + 3

    def _pressures(self, torque: Array) -> float:
        """A torque of the drive as a share of that of the usual load pressure."""
        gain = self.layout.finger.pressure_gain
        return float(torque @ gain / (gain @ gain) / self.uncertainty.load_pressure)

    @cached_property
    def _shared(self) -> Array:
        """From bends to joint angles that share them equally, (N, S)."""
        return np.linalg.pinv(self.layout.matrix)

    @cached_property
    def _of_usual_load(self) -> Array:
        A, straight = self.layout.matrix, self.layout.straight
        return A @ self._mechanics.prior(self._mechanics.posture(straight), straight, straight) @ A.T

    @cached_property
    def _contact(self) -> SurfaceContact:
        return SurfaceContact(self._mechanics)

    @cached_property
    def _mechanics(self) -> Mechanics:
        return Mechanics(self.layout, self.uncertainty)


class _Look(NamedTuple):
    """The mean of some samples."""

    measured: Array  # (R)
    expected: Array  # (R) of the free finger
    read: NDArray[np.bool_]  # (R) whether any sample is finite
    apart: Array  # (R) number of samples that differ: those that repeat themselves average out no rounding
    moved: Array  # (S) rad, by which the free bends changed within the look
    away: Array  # (R) standard deviation, common to all, of what is not known away from a calibration
    working: Array  # (R) log-likelihoods of what repeated itself and what was lost: of a working sensor,
    stuck: Array  # (R) a dead
    limited: Array  # (R) and one at its limit
    at_limit: NDArray[np.bool_]  # (R)
    partly: NDArray[np.bool_]  # (R)
    furthest: NDArray[np.bool_]  # (R) whether it is beyond all looks before


class _Observation(NamedTuple):
    """z = H x + noise, of R readings."""

    by_state: Array  # H, (B, K, R, n)
    values: Array  # z, (B, K, R)
    noise: Array  # its covariance, (K, R, R)


class _Updated(NamedTuple):
    """After a look, for the likelier of the two loads."""

    mean: Array  # (B, K, n)
    covariance: Array  # (B, K, n, n)
    log_likelihood: Array  # (B, K)


def _updated(mean: Array, covariance: Array, look: _Observation) -> _Updated:
    """A Kalman update of means (B, K, n) with covariances (2, B, K, n, n), one for each load."""
    H, noise = look.by_state, look.noise
    crossed = covariance @ np.swapaxes(H, -1, -2)
    spread = H @ crossed + noise
    left, inverse = look.values - (H @ mean[..., None])[..., 0], np.linalg.inv(spread)
    square = (left * (inverse @ left[..., None])[..., 0]).sum(axis=-1)
    log_likelihood = np.log([1 - _SUDDEN, _SUDDEN])[:, None, None] - (square + np.linalg.slogdet(spread)[1]) / 2
    best = log_likelihood.argmax(axis=0)[None]

    def of_best(values: Array) -> Array:
        index = best.reshape(*best.shape, *[1] * (values.ndim - best.ndim))
        chosen: Array = np.take_along_axis(values, index, 0)[0]
        return chosen

    gain = of_best(crossed) @ of_best(inverse)
    keep = np.eye(H.shape[-1]) - gain @ H  # Joseph's form, which stays positive
    after = keep @ of_best(covariance) @ np.swapaxes(keep, -1, -2) + gain @ noise @ np.swapaxes(gain, -1, -2)
    return _Updated(mean + (gain @ left[..., None])[..., 0], after, of_best(log_likelihood))
