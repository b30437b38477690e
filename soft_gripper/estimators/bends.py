"""From the readings of a finger to the bend of its sections, with what is missing left out.

If the n joints of a section bend alike, a path at the offset o from the neutral axis reads of it the extension ratio
L / (2 a), with a half a segment and L the length of the path over one segment (`segment_path_lengths`),

    (L / 2)^2 = a^2 + 2 o^2 - 2 o |a + i o| sin(u + arg(a + i o)) ,   u = theta / (2 n) ,

so that every path gives the bend theta by itself. Where a section of length l is straight, its ratio changes by
- o / l with the bend. Readings of equal noise are therefore weighted as

    theta = sum o^2 theta_path / sum o^2 ,   variance = noise^2 l^2 / sum o^2 ,

over the paths of the section that read anything.

Leading axes are free; S sections.
"""

from typing import NamedTuple

import numpy as np

from soft_gripper.arrays import Array
from soft_gripper.sensors.sensor_layout import SensorLayout

UNKNOWN = 1e6  # rad^2, variance of a bend of which nothing is read


class SectionBends(NamedTuple):
    """What readings say of the sections, each (..., S)."""

    theta: Array  # rad
    variance: Array  # rad^2

    def uncertain_by(self, share: float) -> "SectionBends":
        """The same with a further error of every bend, whose standard deviation is a share of it."""
        return SectionBends(self.theta, self.variance + (share * self.theta) ** 2)


def section_bends(layout: SensorLayout, readings: Array, noise: float) -> SectionBends:
    """The bend of every section from readings (..., paths * S).

    `noise` is the standard deviation of the extension ratios. Where no path of a section gives a finite reading, its
    bend is 0 with the variance UNKNOWN.
    """
    ratios = layout.response.ratio(readings).reshape(*readings.shape[:-1], layout.paths, layout.sections)
    read = np.isfinite(ratios)
    weights = read * (layout.offsets[:, None] / layout.rest_lengths) ** 2
    information = weights.sum(axis=-2)
    bends = _bends_of_paths(layout, np.where(read, ratios, 1.0))
    theta = (weights * bends).sum(axis=-2) / np.where(information == 0, 1.0, information)
    return SectionBends(theta, noise**2 / np.maximum(information, noise**2 / UNKNOWN))


def _bends_of_paths(layout: SensorLayout, ratios: Array) -> Array:
    """The bends, (..., paths, S), that extension ratios say of their sections if all joints of one bend alike."""
    half, offset = layout.finger.segment_length / 2, layout.offsets[:, None]
    offset = np.where(offset == 0, half, offset)  # a path on the neutral axis reads nothing, and has no weight
    sine = (half**2 * (1 - ratios**2) + 2 * offset**2) / (2 * offset * np.hypot(half, offset))
    bends: Array = 2 * layout.joints_per_section * (np.arcsin(np.clip(sine, -1, 1)) - np.arctan2(offset, half))
    return bends
