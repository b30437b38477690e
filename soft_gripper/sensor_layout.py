"""Which sensors a finger carries, and the maths of reading them: joint angles -> readings -> arcs.

Everything here is pure and takes arrays whose leading axes are free, so that a block calls it for one
sample and an evaluation calls it once for a whole recording.
"""

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from soft_gripper.arcs import Arcs, arcs_from_lengths, points_on_arcs
from soft_gripper.arrays import Array, Planar
from soft_gripper.finger import Finger
from soft_gripper.kinematics import segment_path_lengths
from soft_gripper.response_curve import ResponseCurve


@dataclass(frozen=True)
class SensorLayout:
    """Strain sensors along the sides of a finger, `sections` of them one after the other on each path.

    Two-sided (the default), the paths lie half the sensor spacing to either side of the axis. One-sided, the
    inner side does not stretch: the axis itself is that side, and only the outer path, a whole spacing away,
    is measured.

    Raises:
        InputError: if there are fewer than 1 or more sections than segments.
    """

    finger: Finger
    sections: int
    one_sided: bool = False
    response: ResponseCurve = field(default_factory=ResponseCurve)

    def __post_init__(self) -> None:
        self.finger.section_ends(self.sections)

    @property
    def paths(self) -> int:
        """Number of measured paths: 2 (inner, outer) or 1 (outer)."""
        return 1 if self.one_sided else 2

    @property
    def readings(self) -> int:
        """Number of readings, path after path and from the base to the tip."""
        return self.paths * self.sections

    @cached_property
    def offsets(self) -> Array:
        """Offsets of the measured paths from the axis, m, positive on the inner side, (paths,)."""
        spacing = self.finger.sensor_spacing
        return np.array([-spacing] if self.one_sided else [spacing / 2, -spacing / 2])

    @cached_property
    def section_ends(self) -> NDArray[np.int_]:
        return self.finger.section_ends(self.sections)

    @cached_property
    def joints_per_section(self) -> NDArray[np.int_]:
        """Number of joints in every section, (S,)."""
        return np.diff(self.section_ends)

    @cached_property
    def rest_lengths(self) -> Array:
        """Rest length of every section, m, (S,)."""
        return self.joints_per_section * self.finger.segment_length

    @cached_property
    def joint_sections(self) -> NDArray[np.int_]:
        """Section that every joint lies in, (N,)."""
        return np.repeat(np.arange(self.sections), self.joints_per_section)

    @cached_property
    def joint_fractions(self) -> Array:
        """How far along its section every joint lies, 0 to 1, (N,)."""
        begin = self.section_ends[self.joint_sections] * self.finger.segment_length
        return (self.finger.joint_arc_lengths - begin) / self.rest_lengths[self.joint_sections]

    @cached_property
    def torque_interpolation(self) -> Array:
        """Matrix from the mean torques of the sections to the torques at the joints, (N, S).

        The torque is linear between the middles of the sections and beyond the first, and zero at the tip.
        """
        s = self.finger.joint_arc_lengths
        middles = np.add.reduceat(s, self.section_ends[:-1]) / self.joints_per_section
        nodes = np.append(middles, self.finger.length)
        piece = np.clip(np.searchsorted(nodes, s) - 1, 0, self.sections - 1)
        along = (s - nodes[piece]) / (nodes[piece + 1] - nodes[piece])
        joints = np.arange(len(s))
        weights = np.zeros((len(s), len(nodes)))
        weights[joints, piece], weights[joints, piece + 1] = 1 - along, along
        return weights[:, :-1]


def extension_ratios(layout: SensorLayout, q: Array) -> Array:
    """Length over rest length of every section, from joint angles (..., N) rad -> (..., paths * S)."""
    offsets = layout.offsets[:, None]
    lengths = segment_path_lengths(q[..., None, :], layout.finger.segment_length, offsets)
    sections = np.add.reduceat(lengths, layout.section_ends[:-1], axis=-1)
    return (sections / layout.rest_lengths).reshape(*q.shape[:-1], layout.readings)


def arcs_from_readings(layout: SensorLayout, readings: Array) -> Arcs:
    """The arcs of a finger, (..., S), from its sensor readings, (..., paths * S).

    A reading that is NaN or infinite makes its arc NaN, and the place of all that follow.
    """
    ratios = layout.response.ratio(np.where(np.isfinite(readings), readings, np.nan))
    lengths = ratios.reshape(*readings.shape[:-1], layout.paths, layout.sections) * layout.rest_lengths
    outer = lengths[..., -1, :]
    if layout.one_sided:
        return arcs_from_lengths(layout.rest_lengths, outer, layout.finger.sensor_spacing, axis_at=0.0)
    return arcs_from_lengths(lengths[..., 0, :], outer, layout.finger.sensor_spacing)


def joints_on_arcs(layout: SensorLayout, arcs: Arcs) -> Planar:
    """The simulation's joints re-mapped onto the estimated curve, (..., N) m in B."""
    return points_on_arcs(arcs, layout.joint_sections, layout.joint_fractions)
