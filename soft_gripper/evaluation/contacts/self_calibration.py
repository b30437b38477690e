"""Self-calibration in free motion: one number, how much more a finger bends than it is believed to.

Where nothing is touched, pressure and weight alone bend the finger,

    k q = g p + w(q) .

With wrong k or g the believed finger bends otherwise than the measured one. Free motion shows the ratio of both and not
which of them is wrong, so something has to be trusted. Let c be the number that meets the measured bends best:

    the stiffness is trusted:  k q = c g p + w ,    so every pressure counts c times;
    the chamber is trusted:    k / c  q = g p + w ,  so pressure and weight count c times, and a force 1 / c times.

The second is what `estimation.calibration` finds too, which fits gains and offsets of the sensors besides; here many
sets of sensors are calibrated at once. Where a single force presses follows from how the bends of the sections compare,
and needs neither; how strong it is, needs the stiffness itself.

Leading axes are free; K samples of free motion, S sections, N joints.
"""

from typing import NamedTuple

import numpy as np

from soft_gripper.arrays import Array, Planar
from soft_gripper.estimators.bends import section_bends
from soft_gripper.fingers.kinematics import gravity_torque
from soft_gripper.sensors.sensor_layout import SensorLayout

_STEPS = 4  # of Newton's method; under a linear law the first is exact
_NOISE = 1.0  # of the readings, all alike, whatever it is


class FreeMotion(NamedTuple):
    """What is measured of a finger that touches nothing."""

    readings: Array  # (..., K, paths * S)
    pressure: Array  # (K) Pa
    gravity: Planar | complex  # m/s^2, in the bending plane, z + i x in B, a number or (K)


class Scale(NamedTuple):
    """By how much more than they are believed to things count, numbers or (...)."""

    pressure: Array | float = 1.0
    gravity: Array | float = 1.0
    force: Array | float = 1.0


def trusting_stiffness(believed: SensorLayout, free: FreeMotion) -> Scale:
    """The calibration of the pressure gain alone, (...)."""
    driven, weight, theta = _known(believed, free)
    return Scale(pressure=_ratio(believed, theta, driven, weight))


def trusting_chamber(believed: SensorLayout, free: FreeMotion) -> Scale:
    """The calibration of the stiffness alone, (...)."""
    driven, weight, theta = _known(believed, free)
    ratio = _ratio(believed, theta, driven + weight, np.zeros_like(weight))
    return Scale(ratio, ratio, 1 / ratio)


def _known(believed: SensorLayout, free: FreeMotion) -> tuple[Array, Array, Array]:
    """Torques of pressure and of weight, N m, (..., K, N), and the bends of the sections, rad, (..., K, S)."""
    theta = section_bends(believed, free.readings, _NOISE).theta
    weight = gravity_torque(believed.finger, believed.shared_equally(theta), np.asarray(free.gravity)[..., None])
    return np.broadcast_to(believed.finger.pressure_torque(free.pressure), weight.shape), weight, theta


def _ratio(believed: SensorLayout, theta: Array, scaled: Array, rest: Array) -> Array:
    """The c with which the torques  c scaled + rest  bend the sections by theta, in the mean over all of them."""
    law, ratio = believed.finger.joint_law, np.ones(theta.shape[:-2])
    for _ in range(_STEPS):
        q = believed.finger.angle(ratio[..., None, None] * scaled + rest)
        slope = believed.sums(scaled / law.slope(q))
        left = theta - believed.sums(q)
        ratio = ratio + (slope * left).sum(axis=(-2, -1)) / (slope**2).sum(axis=(-2, -1))
    return ratio
