"""The maths of feeling: pose and pressure of a finger -> external torque at its joints (paper, II.D).

In static balance the torques at a joint cancel: elastic = pressure + gravity + external. Elastic torque
and gravity follow from the estimated pose, pressure torque from the measured pressure; the rest is external,
positive where it would close the finger. This is torque at the joints, not contact force: where and in which
direction the finger is touched stays unknown.

Leading axes are free; S sections, N joints.
"""

import numpy as np

from soft_gripper.arrays import Array, Planar
from soft_gripper.finger import Finger
from soft_gripper.sensor_layout import SensorLayout


def free_bending_angles(finger: Finger, pressure: Array) -> Array:
    """Equation (7): joint angles under pressure (...) Pa alone, rad, (..., N)."""
    return finger.angle(pressure[..., None] * finger.pressure_gain)


def mean_joint_angles(layout: SensorLayout, theta: Array) -> Array:
    """Joint angles, (..., N) rad, if the joints of a section share its bend, (..., S) rad, equally."""
    return (theta / layout.joints_per_section).take(layout.joint_sections, axis=-1)


def gravity_torque(finger: Finger, q: Array, gravity: Planar | complex) -> Array:
    """Torque of the finger's own weight at every joint, N m, (..., N).

    What hangs beyond a joint pulls at it with the moments of the links' directions, which are all that bends.
    `gravity` is the acceleration in the bending plane, z + i x in B, m/s^2.
    """
    directions = np.exp(1j * q.cumsum(axis=-1))
    torque: Array = (np.conj(directions @ finger.mass_moments) * gravity).imag
    return torque


def external_torque(layout: SensorLayout, theta: Array, pressure: Array, gravity: Planar | complex) -> Array:
    """External torque at every joint, N m, (..., N).

    A section of sensors tells the mean torque over its joints and no more. Between the middles of the
    sections, and beyond the first, the torque is taken as linear, as it is between point loads; at the tip
    it is zero.

    Args:
        layout: the sensors.
        theta: estimated bend of the sections, rad, (..., S).
        pressure: in the chamber, Pa, (...).
        gravity: in the bending plane, z + i x in B, m/s^2; 0 leaves the weight in the result.
    """
    finger = layout.finger
    q = mean_joint_angles(layout, theta)
    known = pressure[..., None] * finger.pressure_gain + gravity_torque(finger, q, gravity)
    rest = finger.elastic_torque(q) - known
    mean = np.add.reduceat(rest, layout.section_ends[:-1], axis=-1) / layout.joints_per_section
    return mean @ layout.torque_interpolation.T
