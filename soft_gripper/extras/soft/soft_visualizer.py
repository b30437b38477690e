"""Soft objects in Meshcat, and in its recording."""

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np
from pydrake.common.eigen_geometry import Quaternion
from pydrake.geometry import GeometryId, Meshcat, Rgba, Role, SceneGraph
from pydrake.math import RigidTransform
from pydrake.multibody.plant import MultibodyPlant
from pydrake.systems.framework import Context, EventStatus, LeafSystem

from soft_gripper.arrays import Array
from soft_gripper.extras.soft.soft_object import SoftBody, fitted_pose
from soft_gripper.extras.soft.tetrahedra import Tetrahedra

SOFT = "/drake/soft"
MIN_CHANGE = 1e-4  # m, of a vertex relative to the body, for which its shape is drawn anew
_DEFAULT_COLOR = Rgba(0.6, 0.6, 0.6)


class DrawnBody(NamedTuple):
    """A soft object to draw."""

    name: str
    rest: Tetrahedra
    color: Rgba


def drawn_bodies(plant: MultibodyPlant, scene_graph: SceneGraph, soft: Mapping[str, SoftBody]) -> list[DrawnBody]:
    """Soft objects to draw; hides them from Drake's visualizer, which records no shapes and, before 1.58, draws one."""
    bodies = [DrawnBody(name, body.rest, _color(scene_graph, body.geometry)) for name, body in soft.items()]
    for body in soft.values():
        scene_graph.RemoveRole(plant.get_source_id(), body.geometry, Role.kIllustration)
    return bodies


def _color(scene_graph: SceneGraph, geometry: GeometryId) -> Rgba:
    properties = scene_graph.model_inspector().GetIllustrationProperties(geometry)
    if properties is None or not properties.HasProperty("phong", "diffuse"):
        return _DEFAULT_COLOR
    return Rgba(*properties.GetProperty("phong", "diffuse").rgba)  # a copy, which outlives the role


class SoftVisualizer(LeafSystem):
    """Draws soft objects.

    ::

        {object}.vertices (V x 3) m in the world --> SoftVisualizer ~~~> Meshcat

    Meshcat has no shapes that change. A shape is drawn in the frame of the object, which moves; a new one, when the
    object has been deformed by 0.1 mm. In a recording all shapes are kept, and each is visible in its time.
    """

    def __init__(self, meshcat: Meshcat, bodies: Sequence[DrawnBody], period: float):
        super().__init__()
        self._meshcat = meshcat
        self._bodies = tuple(bodies)
        self._shapes: dict[str, list[Array]] = {}  # drawn so far, in the frames of the objects
        for body in self._bodies:
            self.DeclareVectorInputPort(f"{body.name}.vertices", body.rest.vertices.size)
        self.DeclareInitializationPublishEvent(self._begin)
        self.DeclarePeriodicPublishEvent(period, 0.0, self._publish)
        self.DeclareForcedPublishEvent(self._publish)

    def _begin(self, context: Context) -> EventStatus:
        self._meshcat.Delete(SOFT)
        self._shapes = {body.name: [] for body in self._bodies}
        return EventStatus.Succeeded()

    def _publish(self, context: Context) -> EventStatus:
        for body in self._bodies:
            vertices = self.GetInputPort(f"{body.name}.vertices").Eval(context).reshape(-1, 3)
            pose = fitted_pose(body.rest, vertices)
            X_WO = RigidTransform(Quaternion(pose[:4] / np.linalg.norm(pose[:4])), pose[4:])
            self._meshcat.SetTransform(f"{SOFT}/{body.name}", X_WO, context.get_time())
            self._draw(body, (X_WO.inverse() @ vertices.T).T, context.get_time())
        return EventStatus.Succeeded()

    def _draw(self, body: DrawnBody, shape: Array, time: float) -> None:
        shapes = self._shapes[body.name]
        if shapes and np.abs(shape - shapes[-1]).max() < MIN_CHANGE:
            return
        if self._is_recording():
            if shapes:
                self._meshcat.SetProperty(f"{SOFT}/{body.name}/{len(shapes) - 1}", "visible", False, time)
            shapes.append(shape)
        else:
            shapes[:] = [shape]
        path = f"{SOFT}/{body.name}/{len(shapes) - 1}"
        faces = body.rest.boundary.T
        self._meshcat.SetTriangleMesh(path, shape.T, faces, body.color)
        self._meshcat.SetProperty(path, "visible", time == 0, 0.0)
        self._meshcat.SetProperty(path, "visible", True, time)

    def _is_recording(self) -> bool:
        try:
            self._meshcat.get_mutable_recording()
        except RuntimeError:
            return False
        return True
