"""How a finger that nothing touches moves under its driving torque and weight, and how far it lags behind them.

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

Leading axes are free; T samples, D joint positions, way after way.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from soft_gripper.arrays import Array
from soft_gripper.estimators.mechanics import Mechanics, outer


class Lag(NamedTuple):
    """How far the joints of a free finger are from where they would rest, each (..., D) rad, or m where they slide."""

    damping: Array
    inertia: Array

    def seen_by(self, slopes: Array) -> Array:
        """The covariance that it adds to readings with slopes (..., R, D) by the joints, (..., R, R)."""
        together, each = self.damping + self.inertia, np.hypot(self.damping, self.inertia)
        seen = (slopes * together[..., None, :]).sum(axis=-1)
        apart = slopes * each[..., None, :]
        return outer(seen) + apart @ np.swapaxes(apart, -1, -2)


AT_REST, STILL = Lag(np.zeros(1), np.zeros(1)), np.zeros(())


def may_exceed(of_motion: Array, at_rest: Array, noise: Array) -> Array:
    """1 where the lag of a free finger could be taken for a contact, else 0, (...).

    Args:
        of_motion: covariance that the lag adds to readings, (..., R, R).
        at_rest: covariance of these otherwise.
        noise: what noise leaves at most of a misfit, (...).
    """
    expected = np.trace(np.linalg.solve(at_rest, of_motion), axis1=-2, axis2=-1)
    return np.where(expected > noise, 1.0, 0.0)


@dataclass(frozen=True)
class FreeMotion:
    """The motion of one free finger, from sample to sample, (..., 4, D): q, its rate, p and q_0."""

    mechanics: Mechanics
    period: float  # s, between samples

    @property
    def begin(self) -> Array:
        """Before the first sample."""
        return np.full((4, len(self.mechanics.layout.straight)), np.nan)

    def step(self, before: Array, driving: Array, gravity: Array, pull: Array) -> Array:
        """The motion at a sample, from that at the sample before; `pull` is gravity less the base's acceleration."""
        mechanics = self.mechanics
        q, rate, drawn, _ = np.moveaxis(before, -2, 0)
        moved = np.concatenate([q - drawn, rate], axis=-1) @ self._transition.T
        begins = ~np.isfinite(moved).all(axis=-1, keepdims=True)
        away, rate = np.split(np.where(begins, 0.0, moved), 2, axis=-1)
        q = np.where(begins, mechanics.free(driving), drawn + away)
        at = mechanics.posture(q)
        drawn, rest = (mechanics.free(driving + mechanics.weight(at, each)) for each in (pull, gravity))
        return np.stack(np.broadcast_arrays(np.where(begins, rest, q), rate, drawn, rest), axis=-2)

    def over_time(self, driving: Array, gravity: Array, pull: Array, first: int = 0) -> Array:
        """The motion at all samples of a recording, (T, ..., 4, D); those before the `first` one leave no trace."""
        motions: list[Array] = []
        for i, sample in enumerate(zip(driving, gravity, pull, strict=True)):
            motions.append(self.step(motions[-1] if i > first else self.begin, *sample))
        return np.array(motions)

    def middles(self, before: Array, X_WB: Array) -> Array:
        """The middle of the straight finger at a sample and the two before, the newest last, (..., 3, 3) m."""
        return np.concatenate([before, self._middle(X_WB)[..., None, :]], axis=-2)

    def middles_over_time(self, X_WB: Array) -> Array:
        """These at all samples of a recording, (T, ..., 3, 3) m; the first of them leaves no trace."""
        return _recorded_middles(self._middle(X_WB))

    def acceleration(self, middles: Array) -> Array:
        """Acceleration of the base in the world, (..., 3) m/s^2; 0 where it is not known."""
        return _acceleration(middles, self.period)

    def _middle(self, X_WB: Array) -> Array:
        pose = np.asarray(X_WB).reshape(*np.shape(X_WB)[:-1], 3, 4)
        return _middle(pose, self.mechanics.layout.finger.length)

    def lag(self, motion: Array) -> Lag:
        """How far a free finger lags behind."""
        q, rate, _, rest = np.moveaxis(motion, -2, 0)
        damping = self.mechanics.layout.finger.relaxation_time * rate
        return Lag(damping, rest - q - damping)

    @cached_property
    def _transition(self) -> Array:
        """Over a period, of distances from rest and rates, (2 D, 2 D)."""
        from scipy.linalg import expm

        finger, ways = self.mechanics.layout.finger, self.mechanics.layout.ways
        pull = np.linalg.solve(finger.mass_matrix(ways), np.diag(self.mechanics.stiffness))
        nothing, one = np.zeros_like(pull), np.eye(len(pull))
        flow = np.block([[nothing, one], [-pull, -finger.relaxation_time * pull]])
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
    before = np.concatenate([np.full((3, *middle.shape[1:]), np.nan), middle[1:]])
    return np.stack([before[:-2], before[1:-1], middle], axis=-2)


def _acceleration(middles: Array, period: float) -> Array:
    return np.nan_to_num(np.diff(middles, 2, axis=-2)[..., 0, :] / period**2, posinf=0.0, neginf=0.0)


def recorded_lag(function: object, driving: Array, gravity: Array, pull: Array) -> tuple[Lag, ...]:
    """Lag of the free finger at T samples, as the arguments that an estimator takes of it; none if it takes none.

    Args:
        function: an estimator.
        driving: torque, (T, D) N m.
        gravity: in B, (T, 3) m/s^2.
        pull: gravity less the acceleration of the base, likewise.
    """
    motion = motion_of(function)
    return () if motion is None else (motion.lag(motion.over_time(driving, gravity, pull)),)


def motion_of(function: object) -> FreeMotion | None:
    """The motion that an estimator follows, if it does."""
    motion = getattr(function, "motion", None)
    return motion if isinstance(motion, FreeMotion) else None
