"""What differs from episode to episode: drawn, and put into the context of a station that is built once."""

from copy import deepcopy
from dataclasses import dataclass

import numpy as np
from pydrake.math import RigidTransform
from pydrake.systems.framework import Context

from soft_gripper.diagrams.simulation import seed_random_sources
from soft_gripper.learning.object_changes import change_contact, scale_shapes, set_mass
from soft_gripper.learning.schema.config import VariationConfig
from soft_gripper.learning.station.learning_station import LearningStation
from soft_gripper.scenario.scenario import FingerConfig, Scenario

_MOST_SEEDS = 2**31


@dataclass(frozen=True)
class Draw:
    """How an episode differs from its scenario; None: it does not."""

    offset: float = 0.0  # m, along x
    mass: float | None = None  # kg
    friction: float | None = None
    size: float | None = None
    stiffness: float | None = None  # N/m
    sensor_seed: int = 0


def draw(rng: np.random.Generator, config: VariationConfig) -> Draw:
    """Draws for an episode."""
    offset = rng.uniform(-1.0, 1.0) * config.offset
    mass, friction, size = (_within(rng, limits) for limits in (config.mass, config.friction, config.size))
    logarithm = _within(rng, None if config.stiffness is None else [*np.log(config.stiffness)])
    stiffness = None if logarithm is None else float(np.exp(logarithm))
    return Draw(float(offset), mass, friction, size, stiffness, int(rng.integers(_MOST_SEEDS)))


def _within(rng: np.random.Generator, limits: list[float] | None) -> float | None:
    return None if limits is None else float(rng.uniform(limits[0], limits[1]))


def apply_draw(station: LearningStation, context: Context, drawn: Draw) -> None:
    """Puts a draw into a default context of the station's diagram; to be followed by `Simulator.Initialize`."""
    seed_random_sources(station.diagram, context, drawn.sensor_seed)
    if station.object is None:
        return
    plant, body = station.parts.plant, station.object
    scene_graph = station.parts.scene_graph
    in_plant, in_scene = (part.GetMyMutableContextFromRoot(context) for part in (plant, scene_graph))
    X_WO = body.EvalPoseInWorld(in_plant)
    place = X_WO.translation() + np.array([drawn.offset, 0.0, 0.0])
    if drawn.size is not None:
        place[2] += (drawn.size - 1) * station.object_height
        scale_shapes(scene_graph, in_scene, plant, body, drawn.size, station.seen)
    if drawn.friction is not None or drawn.stiffness is not None:
        change_contact(scene_graph, in_scene, plant, body, drawn.friction, drawn.stiffness)
    set_mass(in_plant, body, drawn.mass, drawn.size or 1.0)
    plant.SetFreeBodyPose(in_plant, body, RigidTransform(X_WO.rotation(), place))


def varied_fingers(scenario: Scenario, config: VariationConfig, number: int) -> Scenario:
    """The scenario with gripper `number`, from 0, of those that are built; its estimators know nothing of that."""
    if config.grippers == 1 or config.youngs_modulus == 0.0:
        return scenario
    share = float(np.linspace(-1, 1, config.grippers)[number]) * config.youngs_modulus
    found = deepcopy(scenario)
    (model,) = (model for model in found.models if model.name == config.gripper)
    changed = model.fingers.setdefault("all", FingerConfig())
    changed.youngs_modulus = f"{100 * share:+.9g} %"
    found.believed.youngs_modulus = f"{100 * (1 / (1 + share) - 1):+.9g} %"
    return found
