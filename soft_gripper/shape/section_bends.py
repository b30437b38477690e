"""From the readings of a finger to the bend of its sections, with what is missing left out.

A path at offset o from the neutral axis, which keeps its length l, reads the extension ratio  1 - o theta / l  of a
section that bends by theta. Readings of equal noise make of it the weighted mean

    theta = - l sum o (ratio - 1) / sum o^2 ,    variance = noise^2 l^2 / sum o^2 ,

over the paths of the section that read anything. A chain of N segments is a polygon, of which this holds to a
thousandth; one step of Newton's method, with joints that share the bend equally, takes the rest away.

Leading axes are free; S sections.
"""

from typing import NamedTuple

import numpy as np

from soft_gripper.arrays import Array
from soft_gripper.fingers.kinematics import segment_path_lengths
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
    levers = read * layout.offsets[:, None] / layout.rest_lengths
    information = (levers**2).sum(axis=-2)
    weights = -levers / np.where(information == 0, 1.0, information)[..., None, :]
    strain = np.where(read, ratios, 1.0) - 1
    theta = (weights * strain).sum(axis=-2)
    theta = theta + (weights * (strain - _strain_of_equal_joints(layout, theta))).sum(axis=-2)
    variance = noise**2 / np.maximum(information, noise**2 / UNKNOWN)
    return SectionBends(theta, variance)


def _strain_of_equal_joints(layout: SensorLayout, theta: Array) -> Array:
    """Strain of every path, (..., paths, S), if all joints of a section are bent alike."""
    segment = layout.finger.segment_length
    angle = (theta / layout.joints_per_section)[..., None, :]
    strain: Array = segment_path_lengths(angle, segment, layout.offsets[:, None]) / segment - 1
    return strain
