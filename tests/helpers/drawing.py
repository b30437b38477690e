"""A stand-in for Meshcat that keeps what it is given."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from pydrake.math import RigidTransform, RotationMatrix

from soft_gripper.arrays import Array


class Drawing:
    """Has the methods of Meshcat that draw; `times` are those given with poses and properties."""

    def __init__(self) -> None:
        self.objects: dict[str, Any] = {}
        self.lines: dict[str, Array] = {}
        self.poses: dict[str, RigidTransform] = {}
        self.properties: dict[tuple[str, str], Any] = {}
        self.times: list[float] = []

    def Delete(self, path: str) -> None:  # noqa: N802
        assert not any(kept.startswith(path) for kept in (*self.objects, *self.lines, *self.poses))

    def SetObject(self, path: str, shape: Any, rgba: Any) -> None:  # noqa: N802
        self.objects[path] = shape

    def SetLine(self, path: str, vertices: Array, width: float, rgba: Any) -> None:  # noqa: N802
        self.lines[path] = vertices

    def SetTransform(self, path: str, pose: RigidTransform, time: float | None = None) -> None:  # noqa: N802
        self.poses[path] = pose
        self.times += [] if time is None else [time]

    def SetProperty(self, path: str, name: str, value: Any, time: float | None = None) -> None:  # noqa: N802
        self.properties[path, name] = value
        self.times += [] if time is None else [time]

    def in_world(self, path: str, points: Sequence[float] | Array) -> Array:
        """Points (3,) or (3, M) of an object in the world, by all that is above the object."""
        moved = np.array(points, dtype=float)
        while path:
            scale = self.properties.get((path, "scale"), [1.0, 1.0, 1.0])
            turn = RotationMatrix.MakeYRotation(self.properties.get((path, "rotation[y]"), 0.0))
            place = RigidTransform(turn, self.properties.get((path, "position"), [0.0, 0.0, 0.0]))
            assert path not in self.poses or place.IsExactlyIdentity(), "Meshcat knows one pose of an object"
            moved = self.poses.get(path, place) @ (np.array(scale) * moved.T).T
            path = path.rpartition("/")[0]
        return moved
