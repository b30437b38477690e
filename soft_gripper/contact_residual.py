"""The maths of touch: the torque on a moving finger that its pressure, its weight and its motion do not explain.

In motion the torques at a joint cancel as they do at rest (see `external_torque`), once damping is counted with the
elastic torque and every link has D'Alembert's weight, m (g - a). Accelerations are differences of estimated
positions in the world, so that the motion of the base counts as bending does. What remains is contact.

Only the section at the base is asked, which feels all that hangs beyond it. Every term is smoothed alike, by 2 3 2
over 7: what remains is the smoothed remainder. The second difference of three samples becomes that of a parabola
through five, which has a fifth of its noise and tells of the middle one.

Leading axes are free; 5 samples, S sections, N joints, P = 2 N points.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from soft_gripper.arrays import Array, Planar
from soft_gripper.external_torque import mean_joint_angles
from soft_gripper.kinematics import as_planar, as_points
from soft_gripper.sensor_layout import SensorLayout

SAMPLES = 5
_MIDDLE = SAMPLES // 2
_SMOOTHING = np.array([2.0, 3.0, 2.0]) / 7
# Over three samples, a second difference is a mean of the acceleration; this is the same mean of a value.
_VALUE = np.convolve(_SMOOTHING, np.array([1.0, 10.0, 1.0]) / 12)
_ACCELERATION = np.convolve(_SMOOTHING, [1.0, -2.0, 1.0])
# A real finger is damped at the rate of its moment, a plant in steps of a period at that of half a period later. The
# rate is taken midway between, and what it changes from there to either counts as tolerance.
_MIDWAY = _ACCELERATION / 4
_RATE = np.convolve(_SMOOTHING, [-0.5, 0.0, 0.5]) + _MIDWAY

# What else may remain without contact, as parts of what is known less well than the rest.
_OF_INERTIA = 0.1  # of the torque of inertia
_OF_PRESSURE = 0.15  # of what the torque of the pressure changes over the samples


class Motion(NamedTuple):
    """Samples of a finger, one after the other."""

    theta: Array  # (..., 5, S) rad, estimated bend of the sections
    pressure: Array  # (..., 5) Pa
    X_WB: Array  # (..., 5, 3, 4) pose of the base, [R | p]


class ContactResidual(NamedTuple):
    """Mean torque on the joints of the section at the base."""

    torque: Array  # (...) N m, unexplained; positive where it closes the finger
    tolerance: Array  # (...) N m, what may be unexplained without contact


@dataclass(frozen=True)
class BaseSection:
    """The section at the base, and what hangs on it: two points a link that move in the bending plane as it does.

    Together they have its mass, its middle and its moment of inertia about the bending axis.
    """

    layout: SensorLayout

    @cached_property
    def mean(self) -> Array:
        """Weights that make torques at the joints their mean over the section, (N,)."""
        joints = self.layout.joints_per_section[0]
        return (np.arange(self.layout.finger.segments) < joints) / joints

    @cached_property
    def levers(self) -> Array:
        """How far the direction of each link beyond a joint carries each point, m, (P, N)."""
        finger = self.layout.finger
        ends = finger.link_ends[1:]
        lengths, middles = np.diff(ends), (ends[:-1] + ends[1:]) / 2
        radii = np.sqrt((lengths**2 + finger.interpolate("thickness", middles) ** 2) / 12)
        before = np.tril(np.broadcast_to(lengths, (finger.segments,) * 2), -1)
        return np.concatenate([before + np.diag(lengths / 2 + radius) for radius in (-radii, radii)])

    @cached_property
    def moments(self) -> Array:
        """Mass times lever about the joints of the section, their mean, kg m, (P, N)."""
        masses = np.tile(self.layout.finger.link_masses[1:] / 2, 2)
        return masses[:, None] * self.levers * self.mean.cumsum()

    @cached_property
    def damping(self) -> Array:
        """Mean damping torque by the rates of the joints, N m s/rad, (N,)."""
        return self.layout.finger.damping * self.mean

    @cached_property
    def pressure_gain(self) -> float:
        """Mean torque of the pressure, N m/Pa."""
        return float(self.layout.finger.pressure_gain @ self.mean)


def contact_residual(section: BaseSection, motion: Motion, gravity: Array, period: float) -> ContactResidual:
    """The residual at the middle one of five samples, `period` s apart; `gravity` in the world, (3,) m/s^2."""
    finger = section.layout.finger
    q = mean_joint_angles(section.layout, motion.theta)
    directions: Planar = np.exp(1j * q.cumsum(axis=-1))
    p_BP = finger.segment_length / 2 + directions @ section.levers.T
    axes, origin = motion.X_WB[..., ::2], motion.X_WB[..., 3]  # x and z of B, and where it is
    p_WP = as_points(p_BP) @ np.swapaxes(axes, -1, -2) + origin[..., None, :]
    a_WP = (_ACCELERATION @ p_WP.reshape(*p_WP.shape[:-2], -1)).reshape(*p_WP.shape[:-3], -1, 3) / period**2

    to_plane = axes[..., _MIDDLE, :, :]
    moments = np.conj(directions[..., _MIDDLE, :] @ section.moments.T)
    inertia = (moments * as_planar(a_WP @ to_plane)).sum(axis=-1).imag
    weight = (moments.sum(axis=-1) * as_planar(gravity @ to_plane)).imag

    elastic = finger.elastic_torque(_VALUE @ q) @ section.mean
    damping, midway = ((rate @ q) @ section.damping / period for rate in (_RATE, _MIDWAY))
    pressure, change = section.pressure_gain * (motion.pressure @ _VALUE), np.ptp(motion.pressure, axis=-1)
    tolerance = np.abs(midway) + _OF_INERTIA * np.abs(inertia) + _OF_PRESSURE * section.pressure_gain * change
    return ContactResidual(elastic + damping - pressure + inertia - weight, tolerance)
