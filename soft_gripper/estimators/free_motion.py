"""Motion of a free finger under driving torque and weight, and its lag behind its position of rest.

At rest, driving torque and weight bend a free finger to the joint positions q_0. In motion it is drawn to p, where the
acceleration of its base counts as weight too, and is at q:

    M q'' + b K q' = K (p - q) ,   q_0 - q = b q' + K^-1 M q'' + q_0 - p ,

with M the mass matrix of the straight finger, K the stiffness and b the relaxation time: its bends lag behind those at
rest by what damping and inertia take. While p is held for a period, the step of this linear system is exact. All of the
base moves as the middle of the straight finger does; its acceleration is a difference of three samples.

A finger that touches something lags less, and its joints in other proportions. So the lag is no correction: it counts
as uncertainty, of all joints together and of each by itself,

    (d + i) (d + i)^T + diag(d^2 + i^2) ,   d = b q' , i = q_0 - q - d ,

which does not vanish where an oscillating finger passes its position of rest. Before the first sample, and after one
that is not finite, the finger is taken to rest.

Leading axes are free; T samples, D joint positions, one deformation after the other.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from soft_gripper.arrays import Array
from soft_gripper.estimators.mechanics import Mechanics, outer


class Lag(NamedTuple):
    """Distance of a free finger's joints from rest, each (..., D) rad, or m where they slide."""

    damping: Array
    inertia: Array

    def reading_covariance(self, slopes: Array) -> Array:
        """Covariance that the lag adds to readings with slopes (..., R, D) by the joints, (..., R, R)."""
        sums, scales = self.damping + self.inertia, np.hypot(self.damping, self.inertia)
        sum_changes = (slopes * sums[..., None, :]).sum(axis=-1)
        scale_changes = slopes * scales[..., None, :]
        return outer(sum_changes) + scale_changes @ np.swapaxes(scale_changes, -1, -2)


AT_REST, STILL = Lag(np.zeros(1), np.zeros(1)), np.zeros(())


def may_exceed(motion_covariance: Array, rest_covariance: Array, noise_threshold: Array) -> Array:
    """1 where the lag of a free finger could be taken for a contact, else 0, (...).

    Args:
        motion_covariance: covariance that the lag adds to readings, (..., R, R).
        rest_covariance: covariance of these otherwise.
        noise_threshold: of a misfit, (...).
    """
    expected = np.trace(np.linalg.solve(rest_covariance, motion_covariance), axis1=-2, axis2=-1)
    return np.where(expected > noise_threshold, 1.0, 0.0)


@dataclass(frozen=True)
class FreeMotion:
    """The motion of one free finger, from sample to sample, (..., 4, D): q, its rate, p and q_0."""

    mechanics: Mechanics
    period: float  # s, between samples

    @property
    def begin(self) -> Array:
        """State before the first sample."""
        return np.full((4, len(self.mechanics.layout.straight)), np.nan)

    def step(self, last_motion: Array, driving: Array, gravity: Array, apparent_gravity: Array) -> Array:
        """Advances the motion to the next sample; `apparent_gravity` is gravity less the base's acceleration."""
        mechanics = self.mechanics
        q, rate, equilibrium = (last_motion[..., i, :] for i in range(3))
        distance_and_rate = np.concatenate([q - equilibrium, rate], axis=-1) @ self._transition.T
        is_first = ~np.isfinite(distance_and_rate).all(axis=-1, keepdims=True)
        distance, rate = np.split(np.where(is_first, 0.0, distance_and_rate), 2, axis=-1)
        q = np.where(is_first, mechanics.positions_under(driving), equilibrium + distance)
        bent = mechanics.bent_finger(q)
        weights = mechanics.weight(bent, np.stack([apparent_gravity, gravity]))
        equilibrium, rest_q = mechanics.positions_under(driving + weights)
        return np.stack(np.broadcast_arrays(np.where(is_first, rest_q, q), rate, equilibrium, rest_q), axis=-2)

    def motion_over_time(self, driving: Array, gravity: Array, apparent_gravity: Array, first: int = 0) -> Array:
        """Motion at all samples of a recording, (T, ..., 4, D); samples before the `first` leave no trace."""
        motions: list[Array] = []
        for i, sample in enumerate(zip(driving, gravity, apparent_gravity, strict=True)):
            motions.append(self.step(motions[-1] if i > first else self.begin, *sample))
        return np.array(motions)

    def middles(self, earlier: Array, X_WB: Array) -> Array:
        """Middle of the straight finger at a sample and the two before, the newest last, (..., 3, 3) m."""
        return np.concatenate([earlier, self._middle(X_WB)[..., None, :]], axis=-2)

    def middles_over_time(self, X_WB: Array) -> Array:
        """Middles at all samples of a recording, (T, ..., 3, 3) m; the first sample leaves no trace."""
        return _recorded_middles(self._middle(X_WB))

    def acceleration(self, middles: Array) -> Array:
        """Acceleration of the base in the world, (..., 3) m/s^2; 0 where it is not known."""
        return _acceleration(middles, self.period)

    def _middle(self, X_WB: Array) -> Array:
        pose = np.asarray(X_WB).reshape(*np.shape(X_WB)[:-1], 3, 4)
        return _middle(pose, self.mechanics.layout.finger.length)

    def lag(self, motion: Array) -> Lag:
        """Lag of a free finger."""
        q, rate, _, rest = np.moveaxis(motion, -2, 0)
        damping = self.mechanics.layout.finger.relaxation_time * rate
        return Lag(damping, rest - q - damping)

    @cached_property
    def _transition(self) -> Array:
        """Transition of [q - p, q'] over a period, (2 D, 2 D)."""
        from scipy.linalg import expm

        finger, deformations = self.mechanics.layout.finger, self.mechanics.layout.deformations
        acceleration_gain = np.linalg.solve(finger.mass_matrix(deformations), np.diag(self.mechanics.stiffness))
        zeros, identity = np.zeros_like(acceleration_gain), np.eye(len(acceleration_gain))
        flow = np.block([[zeros, identity], [-acceleration_gain, -finger.relaxation_time * acceleration_gain]])
        return np.asarray(expm(self.period * flow))


def base_acceleration(X_WB: Array, length: float, period: float) -> Array:
    """Acceleration of the base at all samples, each once, (T, 3) m/s^2 in the world; 0 where it is not known.

    Args:
        X_WB: poses of the base, (T, 3, 4).
        length: of the finger, m.
        period: of the samples, s.
    """
    middle = _middle(X_WB, length)
    return _acceleration(_recorded_middles(np.concatenate([middle[:1], middle]))[1:], period)


def _middle(X_WB: Array, length: float) -> Array:
    """Middle of the straight finger in the world, (..., 3) m."""
    return np.asarray(X_WB[..., 3] + length / 2 * X_WB[..., 2])


def _recorded_middles(middle: Array) -> Array:
    """Middles at every sample of a recording and the two before, (T, ..., 3) -> (T, ..., 3, 3) m."""
    earlier = np.concatenate([np.full((3, *middle.shape[1:]), np.nan), middle[1:]])
    return np.stack([earlier[:-2], earlier[1:-1], middle], axis=-2)


def _acceleration(middles: Array, period: float) -> Array:
    return np.nan_to_num(np.diff(middles, 2, axis=-2)[..., 0, :] / period**2, posinf=0.0, neginf=0.0)


def recorded_lag(function: object, driving: Array, gravity: Array, apparent_gravity: Array) -> tuple[Lag, ...]:
    """Lag of the free finger at T samples, as further arguments of an estimator; none if it takes no lag.

    Args:
        function: an estimator.
        driving: torque, (T, D) N m.
        gravity: in B, (T, 3) m/s^2.
        apparent_gravity: gravity less the acceleration of the base, likewise.
    """
    motion = motion_of(function)
    return () if motion is None else (motion.lag(motion.motion_over_time(driving, gravity, apparent_gravity)),)


def motion_of(function: object) -> FreeMotion | None:
    """The motion that an estimator follows, if it does."""
    motion = getattr(function, "motion", None)
    return motion if isinstance(motion, FreeMotion) else None
