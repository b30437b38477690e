"""Reads the bodies around the fingers from Drake's plant, so that no file needs a second parser."""

from pathlib import Path
from typing import NamedTuple

import numpy as np
from pydrake.geometry import Box, Cylinder, GeometryId, Mesh, Role, SceneGraphInspector
from pydrake.math import RigidTransform
from pydrake.multibody.plant import CoulombFriction
from pydrake.multibody.tree import RigidBody
from pydrake.systems.framework import DiagramBuilder

from soft_gripper import Scenario
from soft_gripper.arrays import Array
from soft_gripper.diagrams.scene import Scene, add_plant


class Body(NamedTuple):
    """A body of one shape. Its frame lies in its centre of mass if it is free."""

    name: str
    is_free: bool
    X_WB: RigidTransform  # initial pose
    X_BG: RigidTransform  # the shape in the frame of the body
    size: tuple[float, ...]  # m: edges of a box; radius and length of a cylinder along z; none for a mesh
    mesh: Path | None
    mass: float  # kg
    inertia: Array  # (3, 3) kg m^2, about the centre of mass
    friction: float  # Coulomb, of its own surface


def scene_bodies(scenario: Scenario) -> list[Body]:
    """Bodies of all models that are not URDF files: grippers are read from theirs."""
    builder = DiagramBuilder()
    scene = add_plant(builder, scenario)
    diagram = builder.Build()
    plant, context = scene.plant, diagram.CreateDefaultContext()
    plant_context = plant.GetMyContextFromRoot(context)
    models = [model for model in scenario.models if not model.file.endswith(".urdf")]
    bodies = []
    for model in models:
        (index,) = plant.GetBodyIndices(plant.GetModelInstanceByName(model.name))
        body = plant.get_body(index)
        X_WB = plant.EvalBodyPoseInWorld(plant_context, body)
        bodies.append(_body(scene, body, model.name, model.free, X_WB))
    return bodies


def _body(scene: Scene, body: RigidBody, name: str, is_free: bool, X_WB: RigidTransform) -> Body:
    inspector = scene.scene_graph.model_inspector()
    frame = scene.plant.GetBodyFrameIdOrThrow(body.index())
    (shape,) = inspector.GetGeometries(frame, Role.kProximity)
    size, mesh = _shape(inspector, shape)
    inertia = body.default_spatial_inertia()
    rotational_inertia = inertia.CalcRotationalInertia().CopyToFullMatrix3() if is_free else np.zeros((3, 3))
    friction = inspector.GetProximityProperties(shape).GetPropertyOrDefault(
        "material", "coulomb_friction", CoulombFriction(0, 0)
    )
    X_BG = inspector.GetPoseInFrame(shape)
    friction_coefficient = friction.static_friction()
    return Body(name, is_free, X_WB, X_BG, size, mesh, body.default_mass(), rotational_inertia, friction_coefficient)


def _shape(inspector: SceneGraphInspector, geometry: GeometryId) -> tuple[tuple[float, ...], Path | None]:
    shape = inspector.GetShape(geometry)
    if isinstance(shape, Box):
        return tuple(shape.size()), None
    if isinstance(shape, Cylinder):
        return (shape.radius(), shape.length()), None
    if isinstance(shape, Mesh):
        return (), Path(shape.source().path())
    raise TypeError(f"{type(shape).__name__} has no counterpart here")
