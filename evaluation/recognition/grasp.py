"""One grasp of a random object: what is drawn for it, its simulation, and what is estimated of it."""

from copy import deepcopy
from dataclasses import dataclass, replace

import numpy as np
from pydrake.common.schema import Transform
from pydrake.math import RigidTransform, RotationMatrix

from soft_gripper.arrays import Array
from soft_gripper.diagrams.loading.mesh_cache import read_scene
from soft_gripper.diagrams.loading.model_files import model_path
from soft_gripper.diagrams.recording.recording import Recording
from soft_gripper.diagrams.schema.scenario import ModelConfig, Scenario
from soft_gripper.diagrams.schema.scenario_file import load_scenario
from soft_gripper.diagrams.schema.sensor_presets import strain_errors
from soft_gripper.diagrams.simulation import run_station
from soft_gripper.diagrams.station import make_station
from soft_gripper.diagrams.station_parts import Station
from soft_gripper.errors import InputError, SimulationDivergedError
from soft_gripper.evaluation.paper.held_steps import held_samples
from soft_gripper.evaluation.paper.readings_again import ReadAgain, external_torque_again, read_again
from soft_gripper.evaluation.trials.variation import RandomObject
from soft_gripper.sensors.strain_errors import StrainErrors, disturb

SHAPES = {shape: f"package://soft_gripper/objects/{shape}.obj" for shape in ("sphere", "cylinder", "box", "irregular")}
SCALES = {"irregular": 0.7}  # of the meshes that are not about as wide as the others
SECTIONS = (2, 4)
SETS = ("train", "test")
SENSORS = 1  # tells the random numbers of the sensors from those of the object
OFFSET = 3.0  # mm, from the middle between the fingers, along x and along y
YAW = 20.0  # degrees
MASS = (20.0, 60.0)  # g
FRICTION = (0.5, 0.9)
SIZE = 15  # percent of the mesh's, in whole ones, so that few scaled meshes fill the cache


@dataclass(frozen=True)
class Probe:
    """What is estimated at the end of every step of pressure, for one number of sections."""

    angles: Array  # rad, (L, F, N)
    torques: Array  # N m, (L, F, N)


@dataclass(frozen=True)
class Grasp:
    """A random grasp and what came of it."""

    set: str  # one of SETS
    number: int
    shape: str
    drawn: RandomObject
    probes: dict[int, Probe]  # by numbers of sections; empty if it failed
    cause: str = ""  # of its failure


def draw(seed: int, set: str, number: int, shape: str) -> RandomObject:
    """What is random about a grasp, whatever others there are; every part of it evenly distributed."""
    rng = np.random.default_rng([seed, SETS.index(set), number, *shape.encode()])
    x, y, yaw = rng.uniform(-1.0, 1.0, 3) * (OFFSET, OFFSET, YAW)
    size = 1 + rng.integers(-SIZE, SIZE, endpoint=True) / 100
    return RandomObject(*map(float, (x, y, yaw, rng.uniform(*MASS), rng.uniform(*FRICTION), size)))


def run_grasp(file: str, seed: int, set: str, number: int, shape: str) -> Grasp:
    """Simulates one grasp. One that cannot be simulated has a cause and no probes."""
    drawn = draw(seed, set, number, shape)
    rng = np.random.default_rng([seed, SETS.index(set), number, *shape.encode(), SENSORS])
    try:
        station = make_station(with_object(load_scenario(file), shape, drawn))
        recording = run_station(station)
    except (InputError, SimulationDivergedError) as error:
        return Grasp(set, number, shape, drawn, {}, " ".join(str(error).split()))
    return Grasp(set, number, shape, drawn, {n: probe(station, recording, n, rng) for n in SECTIONS})


def probe(station: Station, recording: Recording, sections: int, rng: np.random.Generator) -> Probe:
    """What is estimated at the end of every step with so many sections, from one recording.

    Sensors have the errors of the scenario, drawn from `rng` for every finger.
    """
    errors = strain_errors(station.scenario.sensor)
    angles, torques = [], []
    for finger in station.fingers:
        again = read_again(station, recording, finger, sections)
        again = again if errors is None else with_errors(again, errors, rng)
        q = again.shape().q
        torque = external_torque_again(station, recording, finger, again)
        angles.append(held_samples(station.scenario, recording, q)[:, -1])
        torques.append(held_samples(station.scenario, recording, torque)[:, -1])
    return Probe(np.stack(angles, axis=1), np.stack(torques, axis=1))


def with_errors(again: ReadAgain, errors: StrainErrors, rng: np.random.Generator) -> ReadAgain:
    """The same finger read by sensors with errors. A recording has its first sample twice, and so have the readings."""
    response = again.layout.response
    disturbed = disturb(errors, response.ratio(again.readings[1:]), again.period, rng)
    readings = response.reading(disturbed)
    return replace(again, readings=np.concatenate([readings[:1], readings]))


def with_object(scenario: Scenario, shape: str, drawn: RandomObject) -> Scenario:
    """The scenario with another object, that stands where and as high as its own.

    Raises:
        InputError: unless one model, and no more, is free.
    """
    found = deepcopy(scenario)
    model = free_model(found)
    X_WO = model.X_PC.GetDeterministicValue()
    height = X_WO.translation()[2] + model.mesh.scale * lowest(model.file, X_WO.rotation())
    turn = RotationMatrix.MakeZRotation(np.radians(drawn.yaw_deg))
    x, y, _ = X_WO.translation() + 1e-3 * np.array([drawn.x_mm, drawn.y_mm, 0.0])
    model.file, model.mesh.scale = SHAPES[shape], drawn.size * SCALES.get(shape, 1.0)
    model.mesh.mass, model.mesh.friction = 1e-3 * drawn.mass_g, drawn.friction
    model.X_PC = Transform(RigidTransform(turn, [x, y, height - model.mesh.scale * lowest(model.file, turn)]))
    return found


def free_model(scenario: Scenario) -> ModelConfig:
    """The object that is grasped; raises as `with_object`."""
    free = [model for model in scenario.models if model.free]
    if len(free) != 1:
        raise InputError("recognition", "models", [model.name for model in free], "give one free model, the object")
    return free[0]


def lowest(file: str, rotation: RotationMatrix) -> float:
    """Height of the lowest point of a mesh file, turned, over its frame, in its unit.

    Raises:
        InputError: if it is no mesh file.
    """
    vertices = read_scene(model_path(file)).convex_hull.vertices
    return float(np.min(vertices @ rotation.matrix()[2]))
