"""Recursive estimation of the shape, with sensor errors and model errors estimated along the way.

A Kalman filter (Kalman 1960, doi 10.1115/1.3662552), extended for the gain of the sensors, whose state x is

    z     the load, as its strongest modes:  tau = V z  (`mechanics`); it changes slowly, or jumps
    r, d  how much more the finger bends than nominal, and the pressure that is measured too low:
          k q = u (1 + r) + g d + w + tau , with u the driving torque and g the pressure gain
    c, b  gain error and offset of every reading:  strain = (1 + c) h(q) + b + noise
    a     rate at which every offset drifts, where sensors drift:  b' = a , a' = noise

All but the load are slow: next to constant, the offsets drift at rates that change over hours, and the bend drifts as
far as the finger may creep in a way that its model does not know (`creep`). Gains and bend walk a little as well, but
become no more uncertain than they are declared to be. They are learnt in free motion alone. Whether the finger is free
is seen from what the readings differ from those of the free finger, averaged over some samples: as long as it is no
more than noise and the uncertainty of the slow states explain, the slow states are corrected, and cautiously, for
errors of sensors are not white. While the finger is loaded they are kept as they are, with their uncertainty counted
(Schmidt 1966, doi 10.1016/B978-1-4831-6716-9.50011-4): else a load that lasts would pass for an offset. The shape of a
sample has the r and d that its readings ask for beside the load, though nothing is learnt from them; else a finger that
is not as stiff as assumed would not have the shape that is read. What cannot be seen is a load that begins before
anything is learnt and looks like a finger that bends less than assumed, and offsets that drifted further while the
finger was loaded than their uncertainty allows: let the finger move freely first and often, or give a smaller
`bend_per_pressure`.

The innovation test says when readings are other than predicted: the squared innovation, normalised by its covariance,
over the limit that noise exceeds in one of 1000 samples (Bar-Shalom, Li and Kirubarajan 2001, section 5.4).

A reading that is NaN is left out, and one that no load explains is taken for an outlier: both widen the covariance.
While the bend of a section is hardly read nothing is learnt, and when that lasts the finger counts as loaded.

Hysteresis is a share of the stroke, and remains where the strain is less: a finger that was just released may differ
from a free one by as much, while it is straight again. It is no load, and counts as an error that lasts. And it lags
alike in all sections, so that in free motion it passes for a bend of the finger: that of a free one, which is where its
drive takes it, is known to that share at best.

Away from the states of a calibration (`Mechanics.away`) errors of drive and readings last as long as the finger stays
there. They are never averaged: a free finger may differ from the predicted one by as much, little is learnt of it, and
shape and contact are as much less certain.

V follows the bent chain where it leaves its plane, and as that couples the ways in which its joints yield, readings
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

Leading axes are free; R readings, S values, D joints, way after way, M modes of the load, n states.

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
from operator import attrgetter
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from soft_gripper.array_block import ArrayBlock
from soft_gripper.arrays import Array
from soft_gripper.estimators.batches import in_parts, shared
from soft_gripper.estimators.contact import Explained, SurfaceContact, Unexplained
from soft_gripper.estimators.estimate import ShapeEstimate
from soft_gripper.estimators.force_posterior import ContactPosterior
from soft_gripper.estimators.gaussian import gain_of
from soft_gripper.estimators.mechanics import Away, Mechanics, outer
from soft_gripper.estimators.uncertainty import Uncertainty
from soft_gripper.sensors.measurement import MeasurementModel
from soft_gripper.sensors.strain_errors import MINUTE

EFFECTIVE_DRIVING_TORQUE = "effective_driving_torque"
_LOAD_CHANGE = 0.15  # 1/sqrt(s), random walk of a load, as a share of a usual one
_LOAD_JUMP = 0.2  # of a usual load: standard deviation of a jump within one sample
_AVERAGE = 0.1  # weight of the newest sample in the average that is compared with the free finger
# Samples and s, at most, for which an error of a sensor is taken to last when slow states are corrected.
_CAUTION, _CORRELATED = 30.0, 0.6
_SLOW_GAIN, _SLOW_BEND = 1e-3, 1e-3  # 1/sqrt(s), random walks of c and of r
_STEADY = 3600.0  # s, in which the rate of a drift changes by as much as it is
_BLIND_SAMPLES = 5  # samples without a reading of a bend after which a load can no longer be ruled out
_OUTLIER = 6.0  # standard deviations
_MISSING_VARIANCE = 1e6  # variance of an omitted reading
_NO_VARIANCE = 1e-30  # of what is declared exact
_CHANCE = 1e-3  # that noise exceeds the limit of an innovation
_REMAINING = 0.3  # of the noise of one sample, in a value's change by the load
_LEAST_SLOPE = 1e-3  # of the largest slope of the readings by a bend: less is not seen at all


class Changes(NamedTuple):
    """How far finger and sensors have moved since the nominal model, or its calibration, and standard deviations."""

    bend_change: Array  # (...) share by which the finger bends further under the same pressure: its stiffness is less
    bend_change_std: Array
    pressure_change: Array  # (...) Pa, by which the measured pressure is too low
    pressure_change_std: Array
    gain_changes: Array  # (..., R) share
    gain_changes_std: Array
    offset_changes: Array  # (..., R) extension ratio
    offset_changes_std: Array


class Filter(NamedTuple):
    """State of knowledge after a sample."""

    mean: Array  # (..., n)
    covariance: Array  # (..., n, n)
    difference: Array  # (..., R) averaged deviation of the readings from those of the free finger
    loaded: NDArray[np.bool_]  # (...)
    innovation: Array  # (...) squared and normalised, 1 where noise leaves more in 1 of 1000 samples
    drive: Array  # (..., 2) r and d of this sample
    q: Array  # (..., D) rad, and m where joints slide
    away: Array  # (..., 1 + S) the standard deviations of `Away`; 0 of a finger that is not calibrated
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
        gravity, wanted = np.broadcast_to(gravity, (*driving.shape[:-1], 3)), set(rows.tolist())
        passed = self._passed(0, readings, driving, gravity)
        known = _together(known for i, known in enumerate(passed) if i in wanted)
        return self.estimate(known, driving[rows])

    def over_time(self, readings: Array, driving: Array, gravity: Array) -> Filter:
        """State of knowledge after each sample of a recording, (T, ...); the first of them leaves no trace."""
        return _together(self._passed(1, readings, driving, gravity))

    def _passed(self, kept_from: int, readings: Array, driving: Array, gravity: Array) -> Iterator[Filter]:
        """State of knowledge after each sample; those before the one `kept_from` leave no trace."""
        begin = known = self.begin(driving.shape[1:-1])
        for i, sample in enumerate(zip(readings, driving, gravity, strict=True)):
            known = self.step(known if i > kept_from else begin, *sample)
            yield known

    def begin(self, shape: tuple[int, ...] = ()) -> Filter:
        """Initial state of knowledge of a straight finger, with leading axes."""
        states = self._states
        covariance = np.broadcast_to(np.diag(self._before), (*shape, states, states))
        nothing = np.zeros((*shape, self.layout.readings))
        return Filter(
            *(np.zeros((*shape, states)), covariance, nothing, np.zeros(shape, bool)),
            *(np.zeros(shape), np.zeros((*shape, 2)), np.zeros((*shape, len(self.layout.straight)))),
            *(np.zeros((*shape, 1 + self._values)), nothing),
        )

    def step(self, before: Filter, readings: Array, driving: Array, gravity: Array) -> Filter:
        """State of knowledge after one more sample.

        Where driving torque or gravity is not finite, so are the joints, and the readings teach nothing.
        """
        from scipy.special import chdtri

        layout, mechanics = self.layout, self.mechanics
        is_driven = np.isfinite((driving**2).sum(axis=-1) + (gravity**2).sum(axis=-1))[..., None]
        if not is_driven.all():
            readings = np.where(is_driven, readings, np.nan)
            driving, gravity = (np.where(is_driven, values, 0.0) for values in (driving, gravity))
        mean, covariance = self._drifted(before.mean, before.covariance)
        at = mechanics.posture(np.where(np.isfinite(before.q), before.q, 0.0))
        weight, modes = mechanics.weight(at, gravity), mechanics.load_modes(at)
        strain, by_load, by_state = self._expected(mean, driving, weight, modes)
        difference: Array = layout.measured(readings) - (1 + self._gains(mean)) * strain - self._offsets(mean)
        read = np.isfinite(difference)
        difference = np.where(read, difference, 0.0)
        noise, away = np.where(read, self.uncertainty.reading**2, _MISSING_VARIANCE), before.away
        if layout.calibrated is not None:
            away = _row(shared(Mechanics.away, mechanics, readings, driving, gravity))
        bent = np.abs(strain + by_load / (1 + self._gains(mean)))
        stroke = np.maximum(before.stroke, bent)
        lasting = self._lasting(away, by_state, stroke**2 - bent**2)
        innovation = self._innovation(difference - by_load, noise, covariance, by_state, lasting)
        jumped = innovation > _limits(noise.shape[-1])[0]
        covariance = covariance + jumped[..., None, None] * np.diag(_LOAD_JUMP**2 * self._before * ~self._is_slow)
        outlier = self._is_outlier(difference - by_load, noise, covariance, by_state, lasting)
        noise, difference = np.where(outlier, _MISSING_VARIANCE, noise), np.where(outlier, 0.0, difference)
        average = before.difference + _AVERAGE * (difference - before.difference) * (noise < _MISSING_VARIANCE)
        loaded = self._is_loaded(before, average, difference, covariance, by_state, noise, lasting)
        blind = self._is_blind(noise < _MISSING_VARIANCE)
        loaded |= blind & (covariance[..., 0, 0] > _BLIND_SAMPLES * self._walks[0])
        left = difference - by_load * (loaded | blind)[..., None]
        known = mean, covariance, left, by_state, noise, lasting
        mean, covariance, drive = self._update(*known, loaded, blind & ~loaded)
        q = mechanics.free(self.effective_driving(drive, driving) + weight + self._torque(modes, mean))
        q = np.where(is_driven, q, np.nan)
        limit = chdtri(np.maximum(read.sum(axis=-1), 1), _CHANCE)
        return Filter(mean, covariance, average, loaded, innovation / limit, drive, q, away, stroke)

    def _lasting(self, away: Array, by_state: Array, straightened: Array) -> Array:
        """Covariance of the errors of the readings that last, (..., R, R).

        They are those away from a calibration, and what hysteresis leaves of the stroke: `straightened` is the square
        of the largest strain so far, less that of the strain, which counts as a state, the gain.
        """
        of_drive = by_state[..., self._modes + 1] * away[..., :1]
        of_readings = np.abs(self.layout.sensitivity) * away[..., None, 1:]
        each = of_readings.reshape(*of_drive.shape) ** 2 + self.uncertainty.gain**2 * straightened
        return outer(of_drive) + each[..., None] * np.eye(each.shape[-1])

    def estimate(self, known: Filter, driving: Array) -> ShapeEstimate:
        """The shape and the contact after a sample at a driving torque, (..., D)."""
        found: ShapeEstimate = in_parts(self._estimate, *self._parts(known), known.loaded.astype(float), driving)
        return found

    def posterior(self, known: Filter, driving: Array) -> ContactPosterior:
        """Posterior of one contact after a sample at a driving torque, (..., D)."""
        found: ContactPosterior = in_parts(self._posterior, *self._parts(known), driving)
        return found

    @staticmethod
    def _parts(known: Filter) -> tuple[Array, ...]:
        return known.q, known.mean, known.covariance, known.away

    def _estimate(
        self, q: Array, mean: Array, covariance: Array, away: Array, loaded: Array, driving: Array
    ) -> ShapeEstimate:
        explained, by_joint = shared(RecursiveShape._explained, self, q, mean, covariance, away, driving)
        contact, _ = self.contact.stated(explained)
        of_joints = by_joint @ covariance @ np.swapaxes(by_joint, -1, -2) + self.mechanics.deviations
        of_joints = of_joints + outer((1 - loaded)[..., None] * self.uncertainty.gain * q)
        if self.layout.calibrated is not None:
            of_joints = of_joints + self._away_from_states(explained.left, away, loaded) + self.mechanics.of_scale(q)
        return ShapeEstimate(q, of_joints, contact)

    def _posterior(self, q: Array, mean: Array, covariance: Array, away: Array, driving: Array) -> ContactPosterior:
        explained, _ = shared(RecursiveShape._explained, self, q, mean, covariance, away, driving)
        return self.contact.posterior(explained)

    def _explained(
        self, q: Array, mean: Array, covariance: Array, away: Array, driving: Array
    ) -> tuple[Explained, Array]:
        """The forces in all cells, and the Jacobian of the joints with respect to the states."""
        left, by_joint = self._unexplained(q, mean, covariance, away, driving)
        return self.contact.explain(left), by_joint

    def _away_from_states(self, left: Unexplained, away: Array, loaded: Array) -> Array:
        """Covariance of the joints, (..., D, D), due to errors away from a calibration.

        A free finger is where its drive takes it, and a loaded one where its readings are explained.
        """
        gain, _ = gain_of(left.slopes, self.mechanics.of_load(left.at, left.q), self._noise)
        gain, of_drive = gain * loaded[..., None, None], self._moved_by_drive(left.q, away)
        of_values = gain * away[..., None, 1:]
        of_drive = of_drive - (gain @ (left.slopes @ of_drive[..., None]))[..., 0]
        return outer(of_drive) + of_values @ np.swapaxes(of_values, -1, -2)

    def _moved_by_drive(self, q: Array, away: Array) -> Array:
        """Standard deviation of the joints by errors of the drive away from a calibration, common to all, (..., D)."""
        return np.asarray(self.mechanics.compliance(q) * self.mechanics.pressure_gain * away[..., :1])

    def _unexplained(
        self, q: Array, mean: Array, covariance: Array, away: Array, driving: Array
    ) -> tuple[Unexplained, Array]:
        """The change of the values by the load, and the Jacobian of the joints with respect to the states.

        The stiffness may be as wrong as the bend per driving torque still is: then a share of all values is.
        """
        M, at, (values, A) = self._modes, self.mechanics.posture(q), self.layout.values_at(q)
        by_joint = self._joints_by_state(q, driving, self.mechanics.load_modes(at))
        by_load = A @ by_joint[..., :M]
        of_load = by_load @ covariance[..., :M, :M] @ np.swapaxes(by_load, -1, -2)
        of_load = of_load + A @ self.mechanics.deviations @ np.swapaxes(A, -1, -2)
        stiffness = np.sqrt(covariance[..., M, M])[..., None] * values
        spread = of_load + np.diag(_REMAINING**2 * self._noise)
        explained = np.trace(np.linalg.solve(spread, of_load), axis1=-2, axis2=-1)
        residual = (by_load @ mean[..., :M, None])[..., 0]
        read = np.maximum(explained, self.contact.fewest)
        spread = spread + outer(stiffness)
        if self.layout.calibrated is not None:
            of_drive = (A @ self._moved_by_drive(q, away)[..., None])[..., 0]
            spread = spread + outer(of_drive) + away[..., None, 1:] ** 2 * np.eye(self._values)
        return Unexplained(q, at, A, read, residual, spread), by_joint

    @cached_property
    def _noise(self) -> Array:
        """Variance of the noise of the values in one sample, (S,)."""
        return self.layout.values(self.layout.read(self.layout.straight), self.uncertainty.reading).variance

    @cached_property
    def _values(self) -> int:
        """S."""
        return self.layout.sensitivity.shape[-1]

    def changes(self, known: Filter) -> Changes:
        """How far finger and sensors have moved, as learnt in free motion."""
        readings, std = self.layout.readings, np.sqrt(np.diagonal(known.covariance, axis1=-2, axis2=-1))
        M = self._modes
        gains, offsets = (slice(M + 2 + begin, M + 2 + begin + readings) for begin in (0, readings))
        parts = M, M + 1, gains, offsets
        return Changes(*(values[..., part] for part in parts for values in (known.mean, std)))

    def effective_driving(self, drive: Array, driving: Array) -> Array:
        """The driving torque of the nominal finger at the pressure that drives it, (..., D), by r and d, (..., 2)."""
        return driving * (1 + drive[..., :1]) + drive[..., 1:] * self.mechanics.pressure_gain

    def _drive(self, mean: Array) -> Array:
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

    @property
    def _modes(self) -> int:
        """M."""
        return len(self.mechanics.load_variances)

    @property
    def _states(self) -> int:
        return self._modes + 2 + 2 * self.layout.readings + self._rates

    @property
    def _rates(self) -> int:
        """Number of rates of drift among the states."""
        return self.layout.readings if self.uncertainty.drift else 0

    def declare(self, block: ArrayBlock, driving: str) -> ShapeEstimate:
        """Declares what a block around it computes; see `shape_estimator.Filter`.

        Beside the shape it puts out `effective_driving_torque` (N) N m in bending, `loaded` (1) 0 or 1: something bends
        the finger, `innovation` (1) above 1: the readings are not those predicted, and the fields of `Changes`.
        """
        start, joints, layout = self.begin(), range(self.layout.finger.segments), self.layout
        block.remember(
            "known",
            lambda before, *sample: self.step(_unflat(before, start), *sample),
            *(layout.quantity, driving, "gravity"),
            begin=_flat(start),
            keep=_flat,
            over_time=self.over_time,
        )
        block.derive("q", attrgetter("q"), "known")
        block.derive("shape", self.estimate, "known", driving)
        block.derive("posterior", self.posterior, "known", driving)
        block.put_out(
            EFFECTIVE_DRIVING_TORQUE,
            lambda known, driving: self.effective_driving(known.drive, driving)[..., : len(joints)],
            *("known", driving),
            unit="N m",
            joint=joints,
        )
        block.put_out("innovation", lambda known: known.innovation, "known")
        block.put_out("loaded", lambda known: known.loaded.astype(float), "known", meanings=("free", "loaded"))
        block.derive("changes", self.changes, "known")
        for name in Changes._fields:
            unit = {"pressure": "Pa", "offset": layout.unit}.get(name.partition("_")[0], "1")
            axes = layout.axes if "changes" in name else {}
            block.put_out(name, attrgetter(name), "changes", unit=unit, **axes)
        return self.estimate(start, layout.straight)

    @cached_property
    def _is_slow(self) -> NDArray[np.bool_]:
        return np.arange(self._states) >= self._modes

    @cached_property
    def _before(self) -> Array:
        """Variances of the states before the first sample, (n,)."""
        assumed, readings = self.uncertainty, self.layout.readings
        slow = [assumed.bend_per_pressure, assumed.pressure]
        slow += [assumed.gain] * readings + [assumed.offset] * readings
        slow += [assumed.drift / math.sqrt(MINUTE)] * self._rates
        return np.concatenate([self.mechanics.load_variances, np.square(slow)])

    @cached_property
    def _walks(self) -> Array:
        """Variances added per period, (n,)."""
        assumed, readings = self.uncertainty, self.layout.readings
        slow = [math.hypot(_SLOW_BEND, assumed.creep), 0.0]
        slow += [_SLOW_GAIN] * readings + [0.0] * readings + [assumed.drift / math.sqrt(MINUTE * _STEADY)] * self._rates
        variances = np.concatenate([_LOAD_CHANGE**2 * self.mechanics.load_variances, np.square(slow)])
        return variances * self.period

    @property
    def _caution(self) -> float:
        """Factor on the variance of the noise where slow states are corrected."""
        return min(_CAUTION, max(_CORRELATED / self.period, 1.0))

    def _drifted(self, mean: Array, covariance: Array) -> tuple[Array, Array]:
        """Mean and covariance of the states a period later."""
        covariance = covariance + np.diag(self._walks)
        if self._rates:
            mean, covariance = mean @ self._moved.T, self._moved @ covariance @ self._moved.T
        excess = np.diagonal(covariance, axis1=-2, axis2=-1) / self._most
        if (excess <= 1).all():
            return mean, covariance
        shrunk = np.sqrt(np.maximum(excess, 1.0))
        return mean, covariance / (shrunk[..., :, None] * shrunk[..., None, :])

    @cached_property
    def _most(self) -> Array:
        """Variances above which no state rises, (n,): of gains and bend, those before the first sample."""
        most = np.full(self._states, np.inf)
        most[self._bounded] = np.maximum(self._before[self._bounded], _NO_VARIANCE)
        return most

    @cached_property
    def _bounded(self) -> list[int]:
        """The states that are never less known than before the first sample: the gains and, without creep, the bend."""
        M, readings = self._modes, self.layout.readings
        return [*([] if self.uncertainty.creep else [M]), *range(M + 2, M + 2 + readings)]

    @cached_property
    def _moved(self) -> Array:
        """From the states to those a period later, but for their walks, (n, n)."""
        moved, rates = np.eye(self._states), np.arange(self._states - self._rates, self._states)
        moved[rates - self._rates, rates] = self.period
        return moved

    def _joints_by_state(self, q: Array, driving: Array, modes: Array) -> Array:
        """Jacobian of the joint positions with respect to the states, (..., D, n)."""
        compliance, M = self.mechanics.compliance(q), self._modes
        moved = np.zeros((*q.shape, self._states))
        moved[..., :M] = compliance[..., None] * modes
        moved[..., M + 1] = compliance * self.mechanics.pressure_gain
        moved[..., M] = compliance * driving
        return moved

    def _by_state(self, q: Array, strain: Array, slopes: Array, mean: Array, driving: Array, modes: Array) -> Array:
        """Jacobian of the measured strains with respect to the states, (..., R, n), at q."""
        readings, after = np.arange(self.layout.readings), self._modes + 2
        moved = (1 + self._gains(mean))[..., None] * (slopes @ self._joints_by_state(q, driving, modes))
        moved[..., readings, after + readings] = strain
        moved[..., readings, after + len(readings) + readings] = 1.0
        return moved

    def _expected(self, mean: Array, driving: Array, weight: Array, modes: Array) -> tuple[Array, Array, Array]:
        """Strains of the free finger, (..., R), what the load adds to the readings, (..., R), and their Jacobian."""
        known = self.effective_driving(self._drive(mean), driving) + weight
        strain = self.layout.predict(self.mechanics.free(known))
        bent = self.mechanics.free(known + self._torque(modes, mean))
        loaded, H = self.layout.linearized(bent)
        by_load = (1 + self._gains(mean)) * (loaded - strain)
        return strain, by_load, self._by_state(bent, loaded, H, mean, driving, modes)

    def _innovation(self, left: Array, noise: Array, covariance: Array, by_state: Array, lasting: Array) -> Array:
        """The squared innovation, normalised by its covariance, (...)."""
        spread = by_state @ covariance @ np.swapaxes(by_state, -1, -2) + lasting
        return _size(left, spread + noise[..., None] * np.eye(noise.shape[-1]))

    def _is_outlier(
        self, left: Array, noise: Array, covariance: Array, by_state: Array, lasting: Array
    ) -> NDArray[np.bool_]:
        """Readings that no change of the load can explain."""
        variance = ((by_state @ covariance) * by_state).sum(axis=-1) + noise
        variance = variance + np.diagonal(lasting, axis1=-2, axis2=-1)
        outlier: NDArray[np.bool_] = np.abs(left) > _OUTLIER * np.sqrt(variance)
        return outlier

    def _is_loaded(
        self,
        before: Filter,
        average: Array,
        difference: Array,
        covariance: Array,
        by_state: Array,
        noise: Array,
        lasting: Array,
    ) -> NDArray[np.bool_]:
        """Whether noise, slow states and lasting errors cannot explain the readings, recently or suddenly."""
        slow, identity = by_state * self._is_slow, np.eye(noise.shape[-1])
        spread = slow @ covariance @ np.swapaxes(slow, -1, -2) + lasting
        noises = noise[..., None] * identity
        of_late = _size(average, spread + _AVERAGE / (2 - _AVERAGE) * noises)
        begin, end, at_once = _limits(noise.shape[-1])
        loaded = np.where(before.loaded, of_late > end, of_late > begin)
        return loaded | (_size(difference, spread + noises) > at_once)

    def _is_blind(self, read: NDArray[np.bool_]) -> NDArray[np.bool_]:
        """Whether the bend of any section is barely measured, in either plane."""
        information = self._of_bends
        return np.asarray(np.any(read @ information < 0.5 * information.sum(axis=0), axis=-1))

    @cached_property
    def _of_bends(self) -> Array:
        """Information of the readings on the bends of the sections, in both planes as far as they are seen, (R, B)."""
        layout = self.layout
        sections = layout.joint_sections[:, None] == np.arange(layout.sections)
        bent = [way in ("bending", "sideways") for way in layout.ways]
        by_bend = layout.jacobian @ np.kron(np.eye(len(bent))[:, bent], sections / layout.joints_per_section)
        seen = np.abs(by_bend).max(axis=0) > _LEAST_SLOPE * np.abs(by_bend).max()
        return np.asarray(by_bend[:, seen] ** 2)

    def _update(
        self,
        mean: Array,
        covariance: Array,
        left: Array,
        by_state: Array,
        noise: Array,
        lasting: Array,
        loaded: NDArray[np.bool_],
        blind: NDArray[np.bool_],
    ) -> tuple[Array, Array, Array]:
        """Mean and covariance for the next sample, and r and d of this one.

        Loaded: the load corrected, slow states kept. Free: no load, slow states corrected. Blind: all kept.
        """
        loads = (loaded | blind)[..., None] | self._is_slow
        mean = mean * loads
        covariance = covariance * (loads[..., :, None] & loads[..., None, :])
        noise = np.where(loaded[..., None], noise, self._caution * noise)
        noises = noise[..., None] * np.eye(noise.shape[-1]) + lasting * ~loaded[..., None, None]
        crossed = covariance @ np.swapaxes(by_state, -1, -2)
        spread = by_state @ crossed + noises
        gain = np.swapaxes(np.linalg.solve(spread, np.swapaxes(crossed, -1, -2)), -1, -2)
        gain = gain * ~blind[..., None, None]
        drive = self._drive(mean + (gain @ left[..., None])[..., 0])
        gain = gain * (loaded[..., None] != self._is_slow)[..., None]
        keep = np.eye(self._states) - gain @ by_state
        covariance = keep @ covariance @ np.swapaxes(keep, -1, -2)
        covariance = covariance + gain @ noises @ np.swapaxes(gain, -1, -2)
        return mean + (gain @ left[..., None])[..., 0], covariance, drive


def _size(difference: Array, spread: Array) -> Array:
    """Normalised squared difference, (...)."""
    size: Array = (difference * np.linalg.solve(spread, difference[..., None])[..., 0]).sum(axis=-1)
    return size


def _row(away: Away | None) -> Array:
    """The standard deviations in a row, (..., 1 + S)."""
    assert away is not None
    return np.concatenate([away.pressure[..., None], away.values], axis=-1)


@cache
def _limits(readings: int) -> Array:
    """Thresholds of normalised differences: where a load begins, where it ends, and where it is present at once."""
    from scipy.special import chdtri

    limits: Array = chdtri(readings, [0.01, 0.1, 1e-4])
    return limits


def _together(passed: Iterable[Filter]) -> Filter:
    """States after several samples as one, with a leading axis."""
    return Filter(*(np.array(part) for part in zip(*passed, strict=True)))


def _flat(known: Filter) -> Array:
    """All parts in a row, (..., n)."""
    leading = known.loaded.shape
    return np.concatenate([np.reshape(part, (*leading, -1)).astype(float) for part in known], axis=-1)


def _unflat(numbers: Array, like: Filter) -> Filter:
    """The inverse of flattening, with the part sizes of another filter state, which has no leading axes."""
    ends = np.cumsum([np.size(part) for part in like])[:-1]
    parts = np.split(numbers, ends, axis=-1)
    shaped = (part.reshape((*numbers.shape[:-1], *np.shape(own))) for part, own in zip(parts, like, strict=True))
    found = Filter(*shaped)
    return found._replace(loaded=found.loaded > 0)
