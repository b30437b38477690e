"""Which sensors a finger carries, and the maths of reading them: joint angles -> readings.

Everything here is pure and takes arrays whose leading axes are free, so that a block calls it for one
sample and an evaluation calls it once for a whole recording.

Sections hold whole segments, as equal as that allows, so that a joint belongs to one section. The evaluation compares
numbers of sections and therefore requires that they divide the segments. Truth and nominal model each have a layout;
the two are equal unless a scenario has `believed`.
"""

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from soft_gripper.arrays import Array
from soft_gripper.errors import InputError
from soft_gripper.files.document import check_document
from soft_gripper.fingers.finger import Finger
from soft_gripper.fingers.kinematics import segment_path_lengths
from soft_gripper.sensors.response_curve import CalibratedResponse, ResponseCurve


@dataclass(frozen=True)
class SensorLayout:
    """Strain sensors along the sides of a finger, `sections` of them one after the other on each path.

    Two-sided (the default), both paths are measured, on the inner and on the outer side. One-sided, only the outer
    path is; the neutral axis, which does not stretch, stands for the other.

    Sections are as equal as whole segments allow, or end at `borders`, one fewer than there are sections: shares of the
    finger's length, each taken to the nearest end of a segment.

    Raises:
        InputError: if there are fewer than 1 or more sections than segments, the borders do not make so many, or the
            response is calibrated for others.
    """

    finger: Finger
    sections: int
    one_sided: bool = False
    response: ResponseCurve | CalibratedResponse = field(default_factory=ResponseCurve)
    borders: tuple[float, ...] | None = None

    def __post_init__(self) -> None:
        ends = self.section_ends
        if len(ends) != self.sections + 1 or not np.all(np.diff(ends) > 0):
            segments = self.finger.segments
            expected = (
                f"give {self.sections - 1} increasing shares of the length, each at another end of {segments} segments"
            )
            raise InputError("sensor", "borders", self.borders, expected)
        if isinstance(self.response, CalibratedResponse) and len(self.response.gains) != self.readings:
            expected = f"the layout has {self.readings} readings"
            raise InputError("calibration", "gains", list(self.response.gains), expected)

    @property
    def paths(self) -> int:
        """Number of measured paths: 2 (inner, outer) or 1 (outer)."""
        return 1 if self.one_sided else 2

    @property
    def path_names(self) -> tuple[str, ...]:
        """What the measured paths are called, in the order of the readings."""
        return path_names(self.one_sided)

    @property
    def readings(self) -> int:
        """Number of readings, path after path and from the base to the tip."""
        return self.paths * self.sections

    @cached_property
    def offsets(self) -> Array:
        """Offsets of the measured paths from the neutral axis, m, positive on the inner side, (paths,)."""
        return np.array(self.finger.sensor_offsets[-self.paths :])

    @cached_property
    def section_ends(self) -> NDArray[np.int_]:
        """Segments covered up to the end of each section, from 0 to N, (S + 1,)."""
        equal = self.finger.section_ends(self.sections)
        if self.borders is None:
            return equal
        check_document("sensor", self.borders, tuple[float, ...], "borders", strict=True)
        return np.round(np.array([0.0, *self.borders, 1.0]) * self.finger.segments).astype(int)

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

    def sums(self, q: Array) -> Array:
        """Sums over the joints of each section, (..., N) -> (..., S)."""
        sums: Array = np.add.reduceat(q, self.section_ends[:-1], axis=-1)
        return sums

    def shared_equally(self, theta: Array) -> Array:
        """Joint angles that share the bends of the sections equally, (..., S) -> (..., N)."""
        return (theta / self.joints_per_section).take(self.joint_sections, axis=-1)


def path_names(one_sided: bool) -> tuple[str, ...]:
    """What the measured paths are called, in the order of the readings."""
    return ("outer",) if one_sided else ("inner", "outer")


def extension_ratios(layout: SensorLayout, q: Array) -> Array:
    """Length over rest length of every section, from joint angles (..., N) rad -> (..., paths * S)."""
    offsets = layout.offsets[:, None]
    lengths = segment_path_lengths(q[..., None, :], layout.finger.segment_length, offsets)
    return (layout.sums(lengths) / layout.rest_lengths).reshape(*q.shape[:-1], layout.readings)
