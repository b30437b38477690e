"""Strain sensors along any paths of a finger: where its joints stand -> extension ratios, in space.

A sensor reads over a section how much longer its path is than at rest, by the law of `fingers.paths`. A path straight
along the finger sees both bends and stretch; twist it sees to second order only. One that runs at a slant of 45 degrees
sees twist as it does a bend. To first order, at (x, y) from the neutral axis, with the slope t = dy/ds on a face of
constant x, a section of length l that bends by theta_y and theta_x, twists by phi and stretches by epsilon reads

    (- x theta_y / l + y theta_x / l + x t phi / l + epsilon) / (1 + t^2) .

A slant need not lead across the finger: the sensor may be a band of short strands, side by side along its path, whose
slope is given apart from the path's own.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np

from soft_gripper.arrays import Array
from soft_gripper.errors import InputError
from soft_gripper.files.document import check_config
from soft_gripper.fingers.finger import Finger
from soft_gripper.fingers.paths import Path, PathsOnChain, lengths_and_gradients, lengths_on_segments
from soft_gripper.quantity import quantity
from soft_gripper.sensors.measurement import SpatialSensors

STEEPEST = 1e3  # slope of strands; 1 is 45 degrees
# Places in units of the distances of the outermost sensors from the middle, x and y, and slopes of strands.
_PATH_COORDINATES = {"inner": (1, 0, 0), "outer": (-1, 0, 0), "left": (0, 1, 0), "right": (0, -1, 0)}
_PATH_COORDINATES |= {"outer_left": (-1, 1, 0), "outer_right": (-1, -1, 0)}
_PATH_COORDINATES |= {"rising": (-1, 0, 1), "falling": (-1, 0, -1)}
LAYOUTS = {
    "outer_pair": ("outer_left", "outer_right"),
    "outer_pair_and_diagonals": ("outer_left", "outer_right", "rising", "falling"),
    "four_faces": ("inner", "outer", "left", "right"),
    "four_faces_and_diagonal": ("inner", "outer", "left", "right", "rising"),
}


@dataclass(frozen=True)
class SensorPath(Path):
    """A sensor along a path, or a band of strands side by side along it, at a separate slope.

    Raises:
        InputError: if a field is out of range, or stations do not fit.
    """

    x_slope: float = quantity(0.0, least=-STEEPEST, most=STEEPEST)  # of the strands, dx/ds against the path
    y_slope: float = quantity(0.0, least=-STEEPEST, most=STEEPEST)  # dy/ds against the path; 1 is 45 degrees

    def __post_init__(self) -> None:
        check_config(f"sensor path '{self.name}'", self)


def named_paths(layout: str, finger: Finger) -> tuple[SensorPath, ...]:
    """The paths of one of `LAYOUTS`, as deep beneath all faces as `sensor_spacing` puts the inner and the outer one."""
    x, y = outermost(finger)
    places = {name: _PATH_COORDINATES[name] for name in LAYOUTS[layout]}
    return tuple(SensorPath(name, (i * x,), (j * y,), y_slope=slope) for name, (i, j, slope) in places.items())


def outermost(finger: Finger) -> tuple[float, float]:
    """Distances x and y of sensors beneath the faces from the middle of the section, m."""
    x = finger.sensor_spacing / 2
    depth = float(finger.thinnest.thickness) / 2 - x
    return x, min(float(section.width) for section in finger.cross_sections) / 2 - depth


@dataclass(frozen=True)
class PathSensors(SpatialSensors):
    """Strain sensors in series along any paths, one on each path and section; a value is the strain of a reading.

    Readings run path after path and from the base to the tip. They depend on all deformations of the finger.

    Raises:
        InputError: as MeasurementModel; and if there is no path, a name appears twice, a path leaves the section, or
            runs through no part of a section.
    """

    paths: tuple[SensorPath, ...] = field(default=(), kw_only=True)

    quantity = "strain"
    unit = "1"

    def __post_init__(self) -> None:
        names = self.path_names
        if len(set(names)) < len(names) or not names:
            raise InputError("sensor", "paths", ", ".join(names) or None, "give a path or more, with different names")
        for path in self.paths:
            for name, value, expected in self.finger.path_violations(path):
                raise InputError("sensor", f"paths.{path.name}.{name}", value, expected)
        super().__post_init__()

    @property
    def path_names(self) -> tuple[str, ...]:
        return tuple(path.name for path in self.paths)

    @property
    def axes(self) -> Mapping[str, Sequence[Any]]:
        return {"path": self.path_names, "section": range(self.sections)}

    @cached_property
    def matrix(self) -> Array:
        """Strains along the finger per joint position, at the straight finger."""
        return self.slopes(self.straight) * (1 + self._slant[:, None])

    @cached_property
    def sensitivity(self) -> Array:
        return 1 / (1 + self._slant)[None, :]

    def predict(self, q: Array) -> Array:
        """Strains at joint positions, (..., D) -> (..., R)."""
        return self.ratios(q) - 1

    def slopes(self, q: Array) -> Array:
        return self.linearized(q)[1]

    def linearized(self, q: Array) -> tuple[Array, Array]:
        deformation_angles = q.reshape(*q.shape[:-1], len(self.deformations), self.finger.segments)
        lengths, gradients = lengths_and_gradients(self._chain_paths, self._levers, deformation_angles)
        slopes = (gradients[..., None, :, :] * self._shares).reshape(*q.shape[:-1], self.readings, q.shape[-1])
        return self._ratios(lengths) - 1, slopes

    def inverse(self, measured: Array) -> Array:
        """Strains along the finger, from those of the readings, if nothing twists: (..., 1, R)."""
        strain_square = (1 + measured) ** 2 * (1 + self._slant) - self._slant
        return np.asarray(np.sqrt(np.maximum(strain_square, 0)) - 1)

    def signals(self, q: Array) -> dict[str, Array]:
        """Extension ratios at joint positions, and the readings of the sensors, (..., R) each."""
        ratios = self.ratios(q)
        return {"extension_ratio": ratios, "strain": self.response.reading(ratios)}

    def ratios(self, q: Array) -> Array:
        """Length over rest length of every reading, (..., D) -> (..., R)."""
        N = self.finger.segments
        by_deformation = {name: q[..., i * N : (i + 1) * N] for i, name in enumerate(self.deformations)}
        return self._ratios(lengths_on_segments(self._chain_paths, by_deformation))

    def _ratios(self, lengths: Array) -> Array:
        """Ratios from the lengths on the segments, (..., P, N) m."""
        sums = np.add.reduceat(lengths, self.section_ends[:-1], axis=-1)
        return np.asarray((sums / self._rest_lengths).reshape(*lengths.shape[:-2], self.readings))

    @cached_property
    def _chain_paths(self) -> PathsOnChain:
        chain_paths = self.finger.on_chain(self.paths)
        slopes = np.array([(path.x_slope, path.y_slope) for path in self.paths])[:, :, None]
        x, y = chain_paths.x_slope + slopes[:, 0], chain_paths.y_slope + slopes[:, 1]
        return PathsOnChain(chain_paths.x, chain_paths.y, x, y, chain_paths.covered, chain_paths.segment_length)

    @cached_property
    def _rest_lengths(self) -> Array:
        """Lengths of every path on every section, (P, S) m."""
        lengths = lengths_on_segments(self._chain_paths, {})
        rest_lengths = np.add.reduceat(lengths, self.section_ends[:-1], axis=-1)
        for path, sections in zip(self.paths, rest_lengths, strict=True):
            if not np.all(sections > 0):
                expected = f"runs through no part of section {int(np.argmin(sections))}: let it run farther"
                raise InputError("sensor", f"paths.{path.name}.at", path.at, expected)
        return rest_lengths

    @cached_property
    def _slant(self) -> Array:
        """Square of the slope of every reading against the axis, (R,), a mean over its section."""
        covered_length = np.add.reduceat(self._chain_paths.covered, self.section_ends[:-1], axis=-1)
        return np.asarray((self._rest_lengths / covered_length).ravel() ** 2 - 1)

    @cached_property
    def _shares(self) -> Array:
        """Weights of a segment's length slope in the slope of a reading, (P, S, 1, N) 1/m."""
        is_in_section = self.joint_sections == np.arange(self.sections)[:, None]
        return np.asarray(is_in_section / self._rest_lengths[..., None])[..., None, :]

    @cached_property
    def _levers(self) -> Array:
        return np.stack([self._chain_paths.levers[name] for name in self.deformations], axis=-2)
