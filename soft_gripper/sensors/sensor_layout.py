"""Strain sensors along the sides of a finger: joint angles -> extension ratios -> bends of the sections.

If the n joints of a section bend alike, a path at the offset o from the neutral axis reads of it the extension ratio
L / (2 a), with a half a segment and L the length of the path over one segment (`segment_path_lengths`),

    (L / 2)^2 = a^2 + 2 o^2 - 2 o |a + i o| sin(u + arg(a + i o)) ,   u = theta / (2 n) ,

so that every path gives the bend theta by itself. Where a section of length l is straight, its ratio changes by
- o / l with the bend: readings are weighed by o^2.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from soft_gripper.arrays import Array
from soft_gripper.errors import InputError
from soft_gripper.fingers.kinematics import segment_path_lengths
from soft_gripper.sensors.measurement import MeasurementModel


@dataclass(frozen=True)
class SensorLayout(MeasurementModel):
    """Strain sensors along the sides of a finger, `sections` of them in series on each path.

    Two-sided (the default), both paths are measured, on the inner and on the outer side. One-sided, only the outer
    path is; the neutral axis, which does not stretch, stands for the other. Readings run path after path and from the
    base to the tip; the values that they give are the bends of the sections, rad.
    """

    one_sided: bool = False

    quantity = "strain"
    unit = "1"

    @cached_property
    def paths(self) -> int:
        """Number of measured paths: 2 (inner, outer) or 1 (outer)."""
        return 1 if self.one_sided else 2

    @property
    def path_names(self) -> tuple[str, ...]:
        """Names of the measured paths, in the order of the readings."""
        return path_names(self.one_sided)

    @property
    def axes(self) -> Mapping[str, Sequence[Any]]:
        return {"path": self.path_names, "section": range(self.sections)}

    @cached_property
    def offsets(self) -> Array:
        """Offsets of the measured paths from the neutral axis, m, positive on the inner side, (paths,)."""
        return np.array(self.finger.sensor_offsets[-self.paths :])

    @cached_property
    def matrix(self) -> Array:
        """Sums joint angles over sections."""
        return (self.joint_sections == np.arange(self.sections)[:, None]).astype(float)

    @cached_property
    def sensitivity(self) -> Array:
        return -self.offsets[:, None] / self.rest_lengths

    def predict(self, q: Array) -> Array:
        """Strains at joint angles, (..., D) rad -> (..., R)."""
        return extension_ratios(self, q) - 1

    def inverse(self, measured: Array) -> Array:
        """The bends computed from extension ratios if all joints of a section bend equally, (..., paths, S) rad."""
        lever, scale, first = self._inverse_terms
        sine = (self.finger.segment_length**2 / 4 * (1 - (1 + measured) ** 2) + lever) / scale
        return 2 * self.joints_per_section * (np.arcsin(np.clip(sine, -1, 1)) - first)

    @cached_property
    def _inverse_terms(self) -> tuple[Array, Array, Array]:
        """Terms of the inverse that no reading changes: 2 o^2, 2 o |a + i o| and arg(a + i o), (paths, 1)."""
        half, offset = self.finger.segment_length / 2, self.offsets[:, None]
        offset = np.where(offset == 0, half, offset)  # a path on the neutral axis measures nothing, and has no weight
        return 2 * offset**2, 2 * offset * np.hypot(half, offset), np.arctan2(offset, half)

    def signals(self, q: Array) -> dict[str, Array]:
        """Extension ratios at joint angles, and the strain readings of the sensors, (..., R) each."""
        ratios = extension_ratios(self, q)
        return {"extension_ratio": ratios, "strain": self.response.reading(ratios)}

    def sums(self, q: Array) -> Array:
        """Sums over the joints of each section, (..., N) -> (..., S)."""
        return np.add.reduceat(q, self.section_ends[:-1], axis=-1)

    def shared_equally(self, theta: Array) -> Array:
        """Joint angles that share the bends of the sections equally, (..., S) -> (..., N)."""
        return (theta / self.joints_per_section).take(self.joint_sections, axis=-1)


def measures_strain(layout: MeasurementModel) -> bool:
    """Whether sensors read strain, along the two sides or any paths."""
    return layout.quantity == SensorLayout.quantity


def strain_sensors(layout: MeasurementModel, where: str) -> SensorLayout:
    """Returns sensors that are along the sections; raises an InputError, in the name of `where`, for another kind."""
    if isinstance(layout, SensorLayout):
        return layout
    raise InputError(where, "sensor.type", layout.quantity, "works with strain sensors on the two sides only")


def path_names(one_sided: bool) -> tuple[str, ...]:
    return ("outer",) if one_sided else ("inner", "outer")


def extension_ratios(layout: SensorLayout, q: Array) -> Array:
    """Length over rest length of every section, from joint angles (..., N) rad -> (..., paths * S)."""
    offsets = layout.offsets[:, None]
    lengths = segment_path_lengths(q[..., None, :], layout.finger.segment_length, offsets)
    sums = np.add.reduceat(lengths, layout.section_ends[:-1], axis=-1)
    return (sums / layout.rest_lengths).reshape(*q.shape[:-1], layout.readings)
