"""The external torque on a finger, at rest and in motion (paper, II.D): what its known torques do not explain.

At every joint i, with D'Alembert's weight m (g - a) on every link beyond it,

    elastic(q_i) + d_i dq_i/dt = u_i + sum over links of  m (r x (g - a))  + external_i ,

with the driving torque u, where r leads from the joint to a point of the link. Positive is what closes the finger.
Accelerations are differences of estimated positions in the world, so that the motion of the base counts as bending
does.

Differences need samples on both sides: the result belongs to the middle one of five, two samples ago. Every term is
smoothed alike, by 2 3 2 over 7; the second difference of three samples becomes that of a parabola through five,
which has a fifth of its noise.

This is torque at the joints, not contact force: where and in which direction the finger is touched stays unknown.
Motion within the five samples that is no parabola, such as a jump of the pressure, is misjudged; `tolerance` bounds by
how much. Out of the bending plane nothing is measured, and nothing is said.

Leading axes are free; 5 samples, N joints, P = 2 N points.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from soft_gripper.arrays import Array, Planar
from soft_gripper.fingers.finger import Finger

SAMPLES = 5
DELAY = SAMPLES // 2  # samples, by which the result is late
_SMOOTHING = np.array([2.0, 3.0, 2.0]) / 7
# Over three samples, a second difference is a mean of the acceleration; this is the same mean of a value.
_VALUE = np.convolve(_SMOOTHING, np.array([1.0, 10.0, 1.0]) / 12)
_ACCELERATION = np.convolve(_SMOOTHING, [1.0, -2.0, 1.0])
# A real finger is damped at the rate of its moment, a plant in steps of a period at that of half a period later. The
# rate is taken midway between, and what it changes from there to either counts as tolerance.
_MIDWAY = _ACCELERATION / 4
_RATE = np.convolve(_SMOOTHING, [-0.5, 0.0, 0.5]) + _MIDWAY
_IN_PLANE = np.array([1j, 0, 1, 0])  # of the axes and the origin of a pose: z + i x
_FILTERS = np.array([_VALUE, _RATE, _MIDWAY])

# What else may remain without contact, as parts of what is known less well than the rest.
_OF_INERTIA = 0.1  # of the torque of inertia
_OF_DRIVING = 0.15  # of what the driving torque changes over the samples


class Motion(NamedTuple):
    """Samples of a finger, one after the other."""

    q: Array  # (..., 5, N) rad, joint angles
    driving: Array  # (..., 5, N) N m, driving torque
    X_WB: Array  # (..., 5, 3, 4) pose of the base, [R | p]


@dataclass(frozen=True, eq=False)
class ExternalTorque:
    """What remains at every joint, at the middle one of five samples."""

    torque: Array  # (..., N) N m, positive where it closes the finger
    inertia: Array  # (..., N) N m, of the motion
    damping_change: Array  # (..., N) N m, by which damping may be taken too early or too late
    driving_change: Array  # (..., N) N m, of the driving torque over the five samples

    @property
    def tolerance(self) -> Array:
        """What may remain without contact, N m, (..., N)."""
        of_motion = np.abs(self.damping_change) + _OF_INERTIA * np.abs(self.inertia)
        return of_motion + _OF_DRIVING * self.driving_change


@dataclass(frozen=True)
class TorqueBalance:
    """The balance of one finger: every link is two points that move in the bending plane as it does.

    Together they have its mass, its centre and its moment of inertia about the bending axis. Beyond the first joint a
    point P of mass m_P lies at  b + sum_j L_Pj d_j , with b the first half link and d_j = z + i x the direction of
    link j; where the centre of mass is off the axis, L_Pj has an imaginary part, along the normal i d_j. So forces
    m (a - g) have at joint i the torque  sum over j >= i of  Im conj(d_j) sum_P m_P conj(L_Pj) (a_P - g) .
    """

    finger: Finger

    def external_torque(
        self, motion: Motion, gravity: Array, period: float, moving: Array | None = None
    ) -> ExternalTorque:
        """What acts from outside.

        Args:
            motion: samples `period` s apart.
            gravity: in the world, (3,) m/s^2.
            period: s.
            moving: joint angles, rad, (..., 5, N), whose motion stands for the finger's; None: that of `motion` itself,
                whose noise accelerations multiply.
        """
        finger, moving = self.finger, motion.q if moving is None else moving
        filtered = _FILTERS @ moving
        inertia, weight = self._inertia_and_weight(motion._replace(q=moving), gravity, period)
        damping = filtered[..., 1:, :] * (finger.damping / period)
        elastic = finger.elastic_torque(_VALUE @ motion.q)
        torque = elastic + damping[..., 0, :] - _VALUE @ motion.driving + inertia - weight
        driving_change = motion.driving.max(axis=-2) - motion.driving.min(axis=-2)
        return ExternalTorque(torque, inertia, damping[..., 1, :], driving_change)

    def _inertia_and_weight(self, motion: Motion, gravity: Array, period: float) -> Array:
        """Torques of inertia and of weight at the middle sample, (2, ..., N) N m."""
        directions: Planar = np.exp(1j * motion.q.cumsum(axis=-1))
        # Axes and origin of B at every sample, (..., 5, 4), seen in the bending plane of the middle one: z + i x.
        plane = motion.X_WB[..., DELAY, :, :] @ _IN_PLANE
        frames = (plane[..., None, None, :] @ motion.X_WB)[..., 0, :]
        frames = frames * (_ACCELERATION / period**2)[:, None]
        x, z = frames[..., None, :, 0], frames[..., None, :, 2]
        turning = (z @ directions.real + x @ directions.imag)[..., 0, :]
        normals = (x @ directions.real - z @ directions.imag)[..., 0, :]
        base = np.add.reduce(frames, axis=-2)
        moving = self.finger.segment_length / 2 * base[..., 2] + base[..., 3]
        forces = np.empty((2, *turning.shape), dtype=complex)
        forces[0] = turning @ self._inertia[0] + normals @ self._inertia[1] + moving[..., None] * self._moments
        forces[1] = (plane @ gravity)[..., None] * self._moments
        forces *= directions[..., DELAY, :].conj()
        # Sums over each joint and all beyond it.
        beyond: Array = forces.imag[..., ::-1].cumsum(axis=-1)[..., ::-1]
        return beyond

    @cached_property
    def _levers(self) -> Planar:
        """How far the direction of each link beyond a joint carries each point, L, m, (P, N)."""
        finger = self.finger
        lengths, centers = np.diff(finger.link_ends)[1:], finger.link_centers[1:]
        radii = np.sqrt(finger.link_gyration[0] + finger.link_gyration[2])[1:]
        before = np.tril(np.broadcast_to(lengths, (finger.segments,) * 2), -1)
        return np.concatenate([before + np.diag(centers + radius) for radius in (-radii, radii)])

    @cached_property
    def _masses(self) -> Array:
        """Of the points, kg, (P,)."""
        return np.tile(self.finger.link_masses[1:] / 2, 2)

    @cached_property
    def _inertia(self) -> Planar:
        """sum_P L_Pi m_P conj(L_Pj), kg m^2, of the real and of the imaginary part of L_Pi, (2, N, N)."""
        parts = np.array([self._levers.real.T, self._levers.imag.T])
        inertia: Planar = parts @ (self._masses[:, None] * self._levers.conj())
        return inertia

    @cached_property
    def _moments(self) -> Planar:
        """sum_P m_P conj(L_Pj), kg m, (N,)."""
        return self._masses @ self._levers.conj()


def windows(samples: Array) -> Array:
    """All five samples that follow each other in a recording, (T, ...) -> (T - 4, 5, ...)."""
    moved = np.lib.stride_tricks.sliding_window_view(samples, SAMPLES, axis=0)
    return np.moveaxis(moved, -1, 1)
