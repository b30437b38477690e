"""Random variation between episodes, applied to the context of a station that is built once.

A new varied quantity needs a field here, in `VariationConfig`, and in `apply_draw`.
"""

from copy import deepcopy
from dataclasses import dataclass

import numpy as np
from pydrake.geometry import (
    Box,
    Capsule,
    Cylinder,
    Ellipsoid,
    ProximityProperties,
    Role,
    RoleAssign,
    SceneGraph,
    Shape,
    Sphere,
)
from pydrake.math import RigidTransform
from pydrake.multibody.plant import CoulombFriction, MultibodyPlant
from pydrake.multibody.tree import RigidBody, SpatialInertia, UnitInertia
from pydrake.systems.framework import Context

from soft_gripper.diagrams.simulation import seed_random_sources
from soft_gripper.errors import InputError
from soft_gripper.extras.learning.config import VariationConfig
from soft_gripper.extras.learning.station import LearningStation
from soft_gripper.scenario.schema import Scenario


def scaled_shape(shape: Shape, factor: float) -> Shape:
    """Multiplies all lengths of a shape.

    Raises:
        InputError: if it is not a primitive with lengths.
    """
    match shape:
        case Sphere():
            return Sphere(factor * shape.radius())
        case Box():
            return Box(factor * shape.size())
        case Capsule():
            return Capsule(factor * shape.radius(), factor * shape.length())
        case Cylinder():
            return Cylinder(factor * shape.radius(), factor * shape.length())
        case Ellipsoid():
            return Ellipsoid(factor * shape.a(), factor * shape.b(), factor * shape.c())
    expected = "give an object of spheres, boxes, capsules, cylinders or ellipsoids; or omit variation.size"
    raise InputError("variation", "size", type(shape).__name__, expected)


def scale_geometries(
    scene_graph: SceneGraph, context: Context, plant: MultibodyPlant, body: RigidBody, factor: float, is_seen: bool
) -> None:
    """Multiplies all lengths of a body about its frame, and, if `is_seen`, those of its visual geometry.

    `context` is the SceneGraph's.
    """
    inspector, source = scene_graph.model_inspector(), plant.get_source_id()
    frame = plant.GetBodyFrameIdOrThrow(body.index())
    for geometry in inspector.GetGeometries(frame) if is_seen else inspector.GetGeometries(frame, Role.kProximity):
        X_BG = inspector.GetPoseInFrame(geometry)
        X_BScaled = RigidTransform(X_BG.rotation(), factor * X_BG.translation())
        scene_graph.ChangeShape(
            context, source, geometry, scaled_shape(inspector.GetShape(geometry), factor), X_BScaled
        )


def change_contact(
    scene_graph: SceneGraph,
    context: Context,
    plant: MultibodyPlant,
    body: RigidBody,
    friction: float | None,
    stiffness: float | None,
) -> None:
    """Changes the friction of a body and its stiffness at points of contact, N/m; None: unchanged.

    `context` is the SceneGraph's.
    """
    for geometry in plant.GetCollisionGeometriesForBody(body):
        properties = ProximityProperties(scene_graph.model_inspector().GetProximityProperties(geometry))
        if friction is not None:
            properties.UpdateProperty("material", "coulomb_friction", CoulombFriction(friction, friction))
        if stiffness is not None:
            properties.UpdateProperty("material", "point_contact_stiffness", stiffness)
        scene_graph.AssignRole(context, plant.get_source_id(), geometry, properties, RoleAssign.kReplace)


def set_mass(context: Context, body: RigidBody, mass: float | None, size: float) -> None:
    """Changes the mass of a body, kg, and its inertia according to mass and a factor of its lengths.

    `context` is the plant's; None: the mass is unchanged.
    """
    inertia = body.CalcSpatialInertiaInBodyFrame(context)
    unit = inertia.get_unit_inertia()
    unit = UnitInertia(*(size**2 * unit.get_moments()), *(size**2 * unit.get_products()))
    inertia = SpatialInertia(inertia.get_mass() if mass is None else mass, size * inertia.get_com(), unit)
    body.SetSpatialInertiaInBodyFrame(context, inertia)


_SEED_COUNT = 2**31


@dataclass(frozen=True)
class Draw:
    """Random variation of one episode; None: as in the scenario."""

    gripper: int = 0  # number of a built gripper
    offset: float = 0.0  # m, along x
    mass: float | None = None  # kg
    friction: float | None = None
    size: float | None = None
    stiffness: float | None = None  # N/m
    sensor_seed: int = 0


def draw(rng: np.random.Generator, config: VariationConfig) -> Draw:
    """Draws the variation of an episode."""
    gripper, offset = int(rng.integers(config.grippers)), rng.uniform(-1.0, 1.0) * config.offset
    mass, friction, size = (_draw_within(rng, limits) for limits in (config.mass, config.friction, config.size))
    logarithm = _draw_within(rng, None if config.stiffness is None else [*np.log(config.stiffness)])
    stiffness = None if logarithm is None else float(np.exp(logarithm))
    return Draw(gripper, float(offset), mass, friction, size, stiffness, int(rng.integers(_SEED_COUNT)))


def _draw_within(rng: np.random.Generator, limits: list[float] | None) -> float | None:
    return None if limits is None else float(rng.uniform(limits[0], limits[1]))


def apply_draw(station: LearningStation, context: Context, episode_draw: Draw) -> None:
    """Applies a draw to a default context of the station's diagram; call `Simulator.Initialize` afterwards."""
    seed_random_sources(station.diagram, context, episode_draw.sensor_seed)
    if station.object is None:
        return
    plant, body = station.parts.plant, station.object
    scene_graph = station.parts.scene_graph
    plant_context, scene_context = (part.GetMyMutableContextFromRoot(context) for part in (plant, scene_graph))
    X_WO = body.EvalPoseInWorld(plant_context)
    position = X_WO.translation() + np.array([episode_draw.offset, 0.0, 0.0])
    if episode_draw.size is not None:
        position[2] += (episode_draw.size - 1) * station.object_height
        scale_geometries(scene_graph, scene_context, plant, body, episode_draw.size, station.is_seen)
    if episode_draw.friction is not None or episode_draw.stiffness is not None:
        change_contact(scene_graph, scene_context, plant, body, episode_draw.friction, episode_draw.stiffness)
    set_mass(plant_context, body, episode_draw.mass, episode_draw.size or 1.0)
    plant.SetFreeBodyPose(plant_context, body, RigidTransform(X_WO.rotation(), position))


def varied_fingers(scenario: Scenario, config: VariationConfig, number: int) -> Scenario:
    """Scenario with gripper `number`, from 0; its nominal model stays the same."""
    if config.grippers == 1 or config.youngs_modulus == 0.0:
        return scenario
    fraction = float(np.linspace(-1, 1, config.grippers)[number]) * config.youngs_modulus
    varied_scenario = deepcopy(scenario)
    (model,) = (model for model in varied_scenario.models if model.name == config.gripper)
    model.fingers.setdefault("all", {})["youngs_modulus"] = f"{100 * fraction:+.9g} %"
    varied_scenario.nominal.finger["youngs_modulus"] = f"{100 * (1 / (1 + fraction) - 1):+.9g} %"
    return varied_scenario
