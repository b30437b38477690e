"""ForceEstimator: shape and driving torque -> external torque at every joint, at rest and in motion.

The external torque on a finger, at rest and in motion (paper, II.D), is the part that its known torques do not explain.

At every joint i, with D'Alembert's weight m (g - a) on every link beyond it,

    elastic(q_i) + d_i dq_i/dt = u_i + sum over links of  m (r x (g - a))  + external_i ,

with the driving torque u, where r leads from the joint to a point of the link. Positive is what closes the finger.
Accelerations are differences of estimated positions in the world, so that the motion of the base counts as bending
does.

Differences need samples on both sides: the result belongs to the middle one of five, two samples ago. Every term is
smoothed alike, by 2 3 2 over 7; the second difference of three samples becomes that of a parabola through five,
which has a fifth of its noise.

This is torque at the joints, not contact force: the location and direction of the contact remain unknown. Motion
within the five samples that is not parabolic, such as a pressure jump, causes an error, which `tolerance` bounds.
Nothing is measured or estimated outside the bending plane.

Leading axes are free; 5 samples, N joints, P = 2 N points.
"""

from dataclasses import dataclass
from functools import cached_property
from operator import attrgetter
from typing import NamedTuple

import numpy as np

from soft_gripper.array_block import ArrayBlock
from soft_gripper.arrays import Array, Planar
from soft_gripper.estimators.driving_torque import DRIVING_TORQUE
from soft_gripper.estimators.finger_shape import ANGLES
from soft_gripper.fingers.finger import Finger
from soft_gripper.fingers.kinematics import as_points, rotated

SAMPLES = 5
DELAY = SAMPLES // 2  # delay of the result, samples
_SMOOTHING_WEIGHTS = np.array([2.0, 3.0, 2.0]) / 7
# Over three samples, a second difference is a mean of the acceleration; this is the same mean of a value.
_VALUE_FILTER = np.convolve(_SMOOTHING_WEIGHTS, np.array([1.0, 10.0, 1.0]) / 12)
_ACCELERATION_FILTER = np.convolve(_SMOOTHING_WEIGHTS, [1.0, -2.0, 1.0])
# A real finger is damped at its current rate, a plant with steps of one period at the rate half a period later. The
# rate is taken midway between, and its change from there to either counts as tolerance.
_MIDWAY_FILTER = _ACCELERATION_FILTER / 4
_RATE_FILTER = np.convolve(_SMOOTHING_WEIGHTS, [-0.5, 0.0, 0.5]) + _MIDWAY_FILTER
_RATE_FILTERS = np.array([_RATE_FILTER, _MIDWAY_FILTER])

# Other residuals without contact, as fractions of the terms that are known less accurately.
_INERTIA_UNCERTAINTY = 0.1  # of the torque of inertia
_DRIVING_UNCERTAINTY = 0.15  # of the change of the driving torque over the samples


class Motion(NamedTuple):
    """Samples of a finger, from `TorqueBalance.samples`; leading axes are free."""

    q: Array  # (..., N) rad, joint angles
    driving: Array  # (..., N) N m, driving torque
    X_WB: Array  # (..., 3, 4) pose of the base, [R | p]
    moving: Array  # (..., N) rad, joint angles whose motion stands for the finger's
    vectors: Array  # (..., 2 N + 1, 3) in the world: along links bent by `moving`, across them; m, to the first joint


@dataclass(frozen=True, eq=False)
class ExternalTorque:
    """The balance at every joint, at the middle of five samples."""

    torque: Array  # (..., N) N m, positive if it closes the finger
    inertia: Array  # (..., N) N m, of the motion
    damping_change: Array  # (..., N) N m, timing error of the damping torque
    driving_change: Array  # (..., N) N m, change of the driving torque over the five samples

    @property
    def tolerance(self) -> Array:
        """Largest residual expected without contact, N m, (..., N)."""
        motion_tolerance = np.abs(self.damping_change) + _INERTIA_UNCERTAINTY * np.abs(self.inertia)
        return motion_tolerance + _DRIVING_UNCERTAINTY * self.driving_change


@dataclass(frozen=True)
class TorqueBalance:
    """The balance of one finger: every link is represented by two points that move with it in the bending plane.

    Together they have its mass, its centre and its moment of inertia about the bending axis. Beyond the first joint a
    point P of mass m_P lies at  b + sum_j L_Pj d_j , with b the first half link and d_j = z + i x the direction of
    link j; where the centre of mass is off the axis, L_Pj has an imaginary part, along the normal i d_j. So forces
    m (a - g) have at joint i the torque  sum over j >= i of  Im conj(d_j) sum_P m_P conj(L_Pj) (a_P - g) .
    """

    finger: Finger

    def samples(self, q: Array, driving: Array, X_WB: Array, moving: Array | None = None) -> Motion:
        """Samples of joint angles, driving torque and pose of the base; see `Motion`.

        `moving` None: the motion is that of `q` itself, whose noise accelerations multiply.
        """
        moving = q if moving is None else moving
        headings = moving.cumsum(axis=-1)[..., None]
        cos, sin = np.cos(headings), np.sin(headings)
        x, z, origin = (X_WB[..., None, :, i] for i in (0, 2, 3))
        first_joint = self.finger.segment_length / 2 * z + origin
        vectors = np.concatenate([cos * z + sin * x, cos * x - sin * z, first_joint], axis=-2)
        return Motion(q, driving, X_WB, moving, vectors)

    def external_torque(self, motion: Motion, gravity: Array, period: float) -> ExternalTorque:
        """External torque at the middle sample, (..., N) N m.

        Args:
            motion: five samples `period` s apart, (..., 5, ...) each.
            gravity: in the world, (3,) m/s^2.
            period: s.
        """
        finger = self.finger
        inertia, weight = self._inertia_and_weight(motion, gravity, period)
        damping = _RATE_FILTERS @ motion.moving * (finger.damping / period)
        elastic = finger.elastic_torque(_VALUE_FILTER @ motion.q)
        torque = elastic + damping[..., 0, :] - _VALUE_FILTER @ motion.driving + inertia - weight
        driving_change = motion.driving.max(axis=-2) - motion.driving.min(axis=-2)
        return ExternalTorque(torque, inertia, damping[..., 1, :], driving_change)

    def _inertia_and_weight(self, motion: Motion, gravity: Array, period: float) -> Array:
        """Torques of inertia and of weight at the middle sample, (2, ..., N) N m."""
        segments, plane = self.finger.segments, motion.X_WB[..., DELAY, :, 2::-2]  # z and x of the bending plane
        flat = motion.vectors.reshape(*motion.vectors.shape[:-2], -1)
        accelerations = (_ACCELERATION_FILTER / period**2 @ flat).reshape(*flat.shape[:-2], -1, 3)
        in_plane: Planar = (accelerations @ plane).view(complex)[..., 0]
        tangents, normals, first_joint = in_plane[..., :segments], in_plane[..., segments:-1], in_plane[..., -1:]
        headings = motion.q[..., DELAY, :].cumsum(axis=-1)
        if motion.moving is not motion.q:
            turn = headings - motion.moving[..., DELAY, :].cumsum(axis=-1)
            cos, sin = np.cos(turn), np.sin(turn)
            tangents, normals = tangents * cos + normals * sin, normals * cos - tangents * sin
        normal_levers, tangent_levers = self._inertia
        inertia = normals @ normal_levers + tangents @ tangent_levers + first_joint * self._moments
        weight = (gravity @ plane).view(complex) * self._moments
        torques = rotated(np.array([inertia, weight]), -headings).imag
        # Sums over each joint and all beyond it.
        return torques[..., ::-1].cumsum(axis=-1)[..., ::-1]

    @cached_property
    def _levers(self) -> Planar:
        """Lever of each point along the direction of each link beyond a joint, L, m, (P, N)."""
        finger = self.finger
        lengths, centers = np.diff(finger.link_ends)[1:], finger.link_centers[1:]
        radii = np.sqrt(finger.link_gyration[0] + finger.link_gyration[2])[1:]
        inner_lengths = np.tril(np.broadcast_to(lengths, (finger.segments,) * 2), -1)
        return np.concatenate([inner_lengths + np.diag(centers + radius) for radius in (-radii, radii)])

    @cached_property
    def _masses(self) -> Array:
        """Masses of the points, kg, (P,)."""
        return np.tile(self.finger.link_masses[1:] / 2, 2)

    @cached_property
    def _inertia(self) -> Planar:
        """sum_P L_Pi m_P conj(L_Pj), kg m^2, of the parts of L_Pi across and along link i, (2, N, N)."""
        return as_points(self._levers).T @ (self._masses[:, None] * self._levers.conj())

    @cached_property
    def _moments(self) -> Planar:
        """sum_P m_P conj(L_Pj), kg m, (N,)."""
        return self._masses @ self._levers.conj()


def windows(samples: Array) -> Array:
    """Windows of five successive samples of a recording, (T, ...) -> (T - 4, 5, ...)."""
    views = np.lib.stride_tricks.sliding_window_view(samples, SAMPLES, axis=0)
    return np.moveaxis(views, -1, 1)


class ForceEstimator(ArrayBlock):
    """Estimates the external torque on a finger: beside driving torque, weight and motion (paper, II.D).

    ::

        estimated_joint_angles (N) rad ---> +----------------+ ---> free_bending_angles  (N) rad, driven and no more
        driving_torque (N) N m -----------> | ForceEstimator | ---> external_torque      (N) N m, positive closes
        X_WB (12) [R | p] ----------------> +----------------+ ---> torque_tolerance     (N) N m

    Torque at the joints, not contact force, from the dynamic balance of `TorqueBalance`: it belongs to two
    samples ago, and `torque_tolerance` says what inertia and steps of the pressure may leave in it without contact.
    NaN until there are five samples, and as long as one of the last five is not finite. Without gravity the
    weight of the finger stays in the result.

    Give it inputs that are sampled together every `period` s, from time 0, in discrete state.
    """

    def __init__(self, finger: Finger, gravity: Array, period: float, noisy: bool = False):
        """
        Args:
            finger: the nominal one.
            gravity: in the world, (3,) m/s^2, or zero for no compensation.
            period: of the samples, s.
            noisy: the joint angles are too noisy to be differentiated twice; the finger is taken to move as its
                driving torque alone moves it, besides the motion of its base.
        """
        super().__init__(period)
        self._finger, self._balance = finger, TorqueBalance(finger)
        self._gravity, self._period, self._noisy = gravity, period, noisy
        joints = finger.segments
        for name, size in {ANGLES: joints, DRIVING_TORQUE: joints, "X_WB": 12}.items():
            self.take(name, size)
        self.derive("present", self._present, ANGLES, DRIVING_TORQUE, "X_WB")
        begin = np.full((SAMPLES - 1, self._present(np.zeros(joints), np.zeros(joints), np.zeros(12)).size), np.nan)
        self.remember(
            "samples", _append_present, "present", begin=begin, keep=_drop_oldest, over_time=_recorded_samples
        )
        self.derive("external", self._external_torque, "samples")
        self.put_out("free_bending_angles", finger.angle, DRIVING_TORQUE, unit="rad", joint=range(joints))
        for name, part in (("external_torque", "torque"), ("torque_tolerance", "tolerance")):
            self.put_out(name, attrgetter(part), "external", unit="N m", joint=range(joints))

    def _present(self, q: Array, driving: Array, X_WB: Array) -> Array:
        """What a sample contributes to the balance, of inputs (..., size), side by side."""
        moving = self._finger.angle(driving) if self._noisy else None
        sample = self._balance.samples(q, driving, X_WB.reshape(*X_WB.shape[:-1], 3, 4), moving)
        others = () if moving is None else (moving,)
        return np.concatenate([q, driving, X_WB, sample.vectors.reshape(*q.shape[:-1], -1), *others], axis=-1)

    def _external_torque(self, samples: Array) -> ExternalTorque:
        """External torque at the middle of samples side by side, (..., 5, size)."""
        joints, axes = self._finger.segments, samples.shape[:-1]
        pose, vectors = 2 * joints, 2 * joints + 12
        q, X_WB = samples[..., :joints], samples[..., pose:vectors].reshape(*axes, 3, 4)
        end = vectors + 3 * (2 * joints + 1)
        moving = samples[..., end:] if self._noisy else q
        motion = Motion(q, samples[..., joints:pose], X_WB, moving, samples[..., vectors:end].reshape(*axes, -1, 3))
        return self._balance.external_torque(motion, self._gravity, self._period)


def _append_present(samples: Array, present: Array) -> Array:
    """The samples remembered and the present one, (..., 5, size)."""
    return np.concatenate([samples, present[..., None, :]], axis=-2)


def _drop_oldest(samples: Array) -> Array:
    return samples[..., 1:, :]


def _recorded_samples(present: Array) -> Array:
    """Samples that `_append_present` returns along a recording, (T, 5, size); the first is not kept."""
    return windows(np.concatenate([np.full((SAMPLES, present.shape[-1]), np.nan), present[1:]]))
