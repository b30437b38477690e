"""CloseUp: a camera that follows the gripper."""

from collections.abc import Iterable
from dataclasses import replace

import numpy as np
from pydrake.math import RigidTransform

from soft_gripper.arrays import Array
from soft_gripper.pictures.camera import Camera, framing_camera
from soft_gripper.pictures.rendering import SceneRenderer

_LEVEL, _ALL = np.array([1.0, 1.0, 0.0]), np.ones(3)


class CloseUp:
    """Sees the gripper of a scene, at all of the given times, s, as large as its picture holds.

    A `level` camera stays at one height, so that the gripper is seen to sink and rise.
    """

    def __init__(self, renderer: SceneRenderer, times: Iterable[float], height: int, width: int, level: bool = False):
        self._scene, self._follows = renderer.scene, _LEVEL if level else _ALL
        corners = [self._scene.gripper_corners(time) - self._shift(time) for time in times]
        self._camera = framing_camera(np.concatenate(corners), height, width, renderer.direction)

    def camera(self, time: float) -> Camera:
        """Where it is at a time, s."""
        X_WC = RigidTransform(self._shift(time)) @ self._camera.X_WC
        return replace(self._camera, X_WC=X_WC)

    def _shift(self, time: float) -> Array:
        return self._follows * self._scene.gripper_position(time)
