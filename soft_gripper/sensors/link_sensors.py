"""Sensors of curvature, such as gratings in a fibre, and of orientation, such as inertial ones, one of them a section.

A sensor of curvature lies on the neutral axis in the middle of a section, and reads how much the finger turns there per
length, in every way in which it turns. One of orientation lies at the end of a section, and reads the rotation vector
from the base: in the plane its angle, in space about x, y and z of B. With the angle theta of the vector r, a turn w
about axes of B changes it by (Barfoot, *State Estimation for Robotics*, 7.1)

    (I - [r] / 2 + (1 / theta^2 - (1 + cos(theta)) / (2 theta sin(theta))) [r]^2) w .

Orientations are told apart up to half a turn.
"""

from collections.abc import Mapping, Sequence
from functools import cached_property
from typing import Any

import numpy as np

from soft_gripper.arrays import Array
from soft_gripper.fingers.finger_parts import SLIDES
from soft_gripper.fingers.spatial_chain import Posture, posture, spatial_chain
from soft_gripper.sensors.measurement import SpatialSensors
from soft_gripper.signals import XYZ

_SERIES_ANGLE = 1e-4  # rad; below it a series stands for the factor of [r]^2


class CurvatureSensors(SpatialSensors):
    """Curvatures and twist in the middles of the sections; readings run by deformation, then from base to tip."""

    quantity, unit = "curvature", "rad/m"

    @property
    def axes(self) -> Mapping[str, Sequence[Any]]:
        sections = {"section": range(self.sections)}
        turns = [name for name in self.deformations if name not in SLIDES]
        return sections if len(turns) == 1 else {"way": turns, **sections}

    @cached_property
    def matrix(self) -> Array:
        middles = (self.section_ends[:-1] + self.section_ends[1:]) // 2
        angle_slopes = np.eye(self.finger.segments)[middles] / self.finger.segment_length
        is_turn = [name not in SLIDES for name in self.deformations]
        return np.kron(np.eye(len(self.deformations))[is_turn], angle_slopes)


class OrientationSensors(SpatialSensors):
    """Orientations of the ends of the sections; readings run from base to tip, in space x, y and z of each."""

    quantity, unit = "orientation", "rad"

    @property
    def axes(self) -> Mapping[str, Sequence[Any]]:
        sections = {"section": range(self.sections)}
        return sections if len(self.deformations) == 1 else {**sections, "xyz": XYZ}

    @cached_property
    def matrix(self) -> Array:
        return self.slopes(self.straight)

    def predict(self, q: Array) -> Array:
        """Rotation vectors of the ends of the sections, (..., D) -> (..., R) rad."""
        vectors = self._vectors(posture(self._chain, q[..., self._position_indices]))
        return vectors[..., 1] if len(self.deformations) == 1 else vectors.reshape(*q.shape[:-1], -1)

    def slopes(self, q: Array) -> Array:
        bent = posture(self._chain, q[..., self._position_indices])
        r = self._vectors(bent)[..., None, :]  # (..., S, 1, 3)
        turns = self._chain.segments < self.section_ends[1:, None]  # joints before the end of each section, (S, J)
        axes = np.where(turns[..., None], bent.screws[..., None, :, :3], 0.0)
        theta = np.linalg.norm(r, axis=-1, keepdims=True)
        clipped = np.maximum(theta, _SERIES_ANGLE)
        factor = 1 / clipped**2 - (1 + np.cos(clipped)) / (2 * clipped * np.sin(clipped))
        factor = np.where(theta < _SERIES_ANGLE, 1 / 12, factor)
        axis_slopes = axes - np.cross(r, axes) / 2 + factor * np.cross(r, np.cross(r, axes))  # (..., S, J, 3)
        ordered_slopes = axis_slopes[..., np.argsort(self._position_indices), :]
        if len(self.deformations) == 1:
            return np.asarray(ordered_slopes[..., 1])
        return np.asarray(np.swapaxes(ordered_slopes, -1, -2).reshape(*q.shape[:-1], -1, q.shape[-1]))

    def _vectors(self, bent: Posture) -> Array:
        from scipy.spatial.transform import Rotation

        R = bent.rotations[..., self._chain.link_frames(self.section_ends[1:]), :, :]
        return np.asarray(Rotation.from_matrix(R.reshape(-1, 3, 3)).as_rotvec().reshape(R.shape[:-1]))

    @cached_property
    def _chain(self) -> Any:
        return spatial_chain(self.finger)

    @cached_property
    def _position_indices(self) -> Any:
        return self._chain.position_indices(self.deformations)
