"""From the sensor readings of a finger to its arcs, one a section, and to the joints of the simulation on them."""

import numpy as np

from soft_gripper.arrays import Array, Planar
from soft_gripper.fingers.finger import Finger
from soft_gripper.sensors.sensor_layout import SensorLayout
from soft_gripper.shape.arcs import Arcs, Bends, bends_from_lengths, join_arcs, points_on_arcs


def arcs_from_readings(layout: SensorLayout, readings: Array) -> Arcs:
    """The arcs of a finger, (..., S), from its sensor readings, (..., paths * S).

    A reading that is NaN or infinite makes its arc NaN, and the place of all that follow.
    """
    return join_arcs(*bends_from_readings(layout, readings))


def bends_from_readings(layout: SensorLayout, readings: Array) -> Bends:
    """What `arcs_from_readings` joins."""
    ratios = layout.response.ratio(np.where(np.isfinite(readings), readings, np.nan))
    lengths = ratios.reshape(*readings.shape[:-1], layout.paths, layout.sections) * layout.rest_lengths
    outer = lengths[..., -1, :]
    if layout.one_sided:
        return bends_from_lengths(layout.rest_lengths, outer, -layout.offsets[0], axis_at=0.0)
    return bends_from_paths(layout.finger, lengths[..., 0, :], outer)


def bends_from_paths(finger: Finger, inner: Array, outer: Array) -> Bends:
    """The arcs of a finger whose two sensor paths are `inner` and `outer` m long, each (..., S)."""
    spacing = finger.sensor_spacing
    return bends_from_lengths(inner, outer, spacing, axis_at=finger.sensor_offsets[0] / spacing)


def joints_on_arcs(layout: SensorLayout, arcs: Arcs) -> Planar:
    """The simulation's joints re-mapped onto the estimated curve, (..., N) m in B."""
    return points_on_arcs(arcs, layout.joint_sections, layout.joint_fractions)
