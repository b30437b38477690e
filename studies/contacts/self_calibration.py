"""Self-calibration in free motion: one number, the bend over that of the nominal model.

In: free motion and nominal sensors. Out: `Scale`. Another calibration is an entry of CALIBRATIONS.

If nothing is touched, only pressure and weight bend the finger,

    k q = g p + w(q) .

With wrong k or g the nominal finger bends differently from the measured one. Free motion shows the ratio of the two,
but not which of them is wrong, so one has to be trusted. Let c be the number that fits the measured bends best:

    the stiffness is trusted:  k q = c g p + w ,    so every pressure counts c times;
    the chamber is trusted:    k / c  q = g p + w ,  so pressure and weight count c times, and a force 1 / c times.

`estimation.calibration` also finds the second, and fits gains and offsets of the sensors besides; here many
sets of sensors are calibrated at once. Where a single force presses follows from how the bends of the sections compare,
and needs neither; how strong it is, needs the stiffness itself.

Leading axes are free; K samples of free motion, S sections, N joints.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from soft_gripper.arrays import Array
from soft_gripper.fingers.kinematics import as_planar, gravity_torque
from soft_gripper.sensors.sensor_layout import SensorLayout

_STEPS = 4  # of Newton's method; with a linear law the first is exact
_NOISE = 1.0  # of the readings, equal for all; its size does not matter


class FreeMeasurements(NamedTuple):
    """The measurements on a finger without contact."""

    readings: Array  # (..., K, paths * S)
    pressure: Array  # (K) Pa
    gravity: Array  # (3) m/s^2 in B


class Scale(NamedTuple):
    """Factors on pressure, gravity and force, numbers or (...)."""

    pressure: Array | float = 1.0
    gravity: Array | float = 1.0
    force: Array | float = 1.0


UNSCALED = Scale()


def calibrate_gain(nominal: SensorLayout, measurements: FreeMeasurements) -> Scale:
    """Calibrates the pressure gain alone, (...)."""
    drive_torques, weight, theta = _torques(nominal, measurements)
    return Scale(pressure=_ratio(nominal, theta, drive_torques, weight))


def calibrate_stiffness(nominal: SensorLayout, measurements: FreeMeasurements) -> Scale:
    """Calibrates the stiffness alone, (...)."""
    drive_torques, weight, theta = _torques(nominal, measurements)
    ratio = _ratio(nominal, theta, drive_torques + weight, np.zeros_like(weight))
    return Scale(ratio, ratio, 1 / ratio)


CALIBRATIONS: dict[str, Callable[[SensorLayout, FreeMeasurements], Scale]] = {
    "none": lambda nominal, free: UNSCALED,
    "trusting stiffness": calibrate_gain,
    "trusting chamber": calibrate_stiffness,
}


def _torques(nominal: SensorLayout, measurements: FreeMeasurements) -> tuple[Array, Array, Array]:
    """Torques of pressure and of weight, N m, (..., K, N), and the bends of the sections, rad, (..., K, S)."""
    theta = nominal.linear(measurements.readings, _NOISE).values
    weight = gravity_torque(nominal.finger, nominal.shared_equally(theta), as_planar(measurements.gravity[::2])[None])
    return np.broadcast_to(nominal.finger.pressure_torque(measurements.pressure), weight.shape), weight, theta


def _ratio(nominal: SensorLayout, theta: Array, scaled: Array, rest: Array) -> Array:
    """Factor c of the torques  c scaled + rest, (..., K, N) N m, that bend the sections by theta on average, (...)."""
    law, ratio = nominal.finger.joint_law, np.ones(theta.shape[:-2])
    for _ in range(_STEPS):
        q = nominal.finger.angle(ratio[..., None, None] * scaled + rest)
        slope = nominal.sums(scaled / law.slope(q))
        residual = theta - nominal.sums(q)
        ratio = ratio + (slope * residual).sum(axis=(-2, -1)) / (slope**2).sum(axis=(-2, -1))
    return ratio
