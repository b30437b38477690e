"""Calibration from free bending: a gain and an offset for every sensor, and how far a finger bends under pressure.

The stiffness of the nominal finger is scaled: the joint angles q of a finger at rest follow from

    k(q) / r = g(p) + w(q) ,

with k the elastic torque of a finger that has crept, g the torque of the pressure, w that of the weight and r the ratio
that is found. A finger that is assumed to creep must rest for longer than its slowest branch. The sensor i reads the
extension ratio 1 + a_i (ratio_i(q) - 1) + b_i. Strain and pressure alone cannot tell larger gains of all sensors from a
finger that bends further (but for its weight, which is too weak to rely on): the mean of the gains a_i is taken to be
1.
"""

from functools import lru_cache
from typing import NamedTuple

import numpy as np
from scipy.optimize import least_squares

from soft_gripper.arrays import Array, Planar
from soft_gripper.fingers.statics import resting_angles, softened
from soft_gripper.sensors.sensor_layout import SensorLayout, extension_ratios

_LIKELY = 1e-3  # extension ratio; residuals far beyond it count linearly, not squared
_RATIOS = (0.2, 5.0)


class FreeBending(NamedTuple):
    """M samples of a finger that bends freely and rests."""

    pressure: Array  # (M) Pa
    gravity: Planar  # (M) in the bending plane, z + i x in B, m/s^2
    ratios: Array  # (M, R) extension ratios that the nominal sensors read


class Calibration(NamedTuple):
    """What was found."""

    bend_ratio: float  # how much further the finger bends under the same pressure than nominal
    gains: Array  # (R)
    offsets: Array  # (R) extension ratio
    residual: float  # root mean square of what is left, extension ratio


def calibrate(layout: SensorLayout, samples: FreeBending) -> Calibration:
    """Fits gains, offsets and the ratio to samples, robustly; `layout` is nominal."""
    readings = layout.readings

    def unpack(x: Array) -> tuple[float, Array, Array]:
        gains = np.append(x[1:readings], readings - x[1:readings].sum())
        return float(x[0]), gains, x[readings:]

    @lru_cache(maxsize=2)  # the slow part; of all numbers in x it depends on the first alone
    def strain(ratio: float) -> Array:
        q = resting_angles(softened(layout.finger, ratio), samples.pressure, samples.gravity)
        return extension_ratios(layout, q) - 1

    def residuals(x: Array) -> Array:
        ratio, gains, offsets = unpack(x)
        return (gains * strain(ratio) + offsets - (samples.ratios - 1)).ravel()

    start = np.concatenate([np.ones(readings), np.zeros(readings)])
    bounds = np.full((2, start.size), [[-np.inf], [np.inf]])
    bounds[:, 0] = _RATIOS
    fit = least_squares(residuals, start, bounds=tuple(bounds), loss="soft_l1", f_scale=_LIKELY)
    return Calibration(*unpack(fit.x), residual=float(np.sqrt(np.mean(residuals(fit.x) ** 2))))
