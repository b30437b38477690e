"""Random grasps, object classifiers trained on some of them, and tested on the others."""

from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Executor
from copy import deepcopy
from dataclasses import asdict, dataclass, replace
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from pydrake.common.schema import Transform
from pydrake.math import RigidTransform, RotationMatrix

from soft_gripper.arrays import Array
from soft_gripper.diagrams.recording import Recording
from soft_gripper.diagrams.simulation import run_station
from soft_gripper.diagrams.station import make_private_station
from soft_gripper.diagrams.station_parts import Station
from soft_gripper.diagrams.wiring.grip_control import find_gripper
from soft_gripper.errors import InputError
from soft_gripper.extras.grasps.trial import RandomObject
from soft_gripper.extras.recognition.object_classifier import UNKNOWN, ObjectClassifier, train_object_classifier
from soft_gripper.extras.recognition.recognizer import SAMPLES
from soft_gripper.pictures.style import STYLE
from soft_gripper.runs.scores.poses import held_samples
from soft_gripper.runs.scores.readings import ReadAgain, external_torque_again, read_again
from soft_gripper.runs.study import describe, run_study
from soft_gripper.scenario.mesh_object import read_scene
from soft_gripper.scenario.model_files import model_path
from soft_gripper.scenario.scenario_file import load_scenario
from soft_gripper.scenario.schema import ModelConfig, Scenario
from soft_gripper.scenario.sensor_presets import strain_errors
from soft_gripper.sensors.strain_errors import StrainErrors, disturb

SHAPES = {shape: f"package://soft_gripper/objects/{shape}.obj" for shape in ("sphere", "cylinder", "box", "irregular")}
SCALES = {"irregular": 0.7}  # of the meshes whose width differs from that of the others
SECTIONS = (2, 4)
SETS = ("train", "test")
DRAWS = 8  # of the sensors of a grasp, if they have errors
SENSORS = 1  # separates the random numbers of the sensors from those of the object
OFFSET = 3.0  # mm, from the middle between the fingers, along x and along y
YAW = 20.0  # degrees
MASS = (20.0, 60.0)  # g
FRICTION = (0.5, 0.9)
SIZE = 15  # percent of the mesh's size, rounded, so that few scaled meshes fill the cache


@dataclass(frozen=True)
class Probe:
    """Means at the end of every pressure step, for one number of sections and E sets of sensors."""

    angles: Array  # rad, (E, L, F, N)
    torques: Array  # N m, (E, L, F, N)


@dataclass(frozen=True)
class Grasp:
    """A random grasp and its result."""

    set: str  # one of SETS
    number: int
    shape: str
    drawn: RandomObject
    probes: dict[int, Probe]  # by numbers of sections; empty if it failed
    cause: str = ""  # of its failure


def draw(seed: int, set: str, number: int, shape: str) -> RandomObject:
    """The random parameters of a grasp, uniformly distributed and independent of other grasps."""
    rng = np.random.default_rng([seed, SETS.index(set), number, *shape.encode()])
    x, y, yaw = rng.uniform(-1.0, 1.0, 3) * (OFFSET, OFFSET, YAW)
    size = 1 + rng.integers(-SIZE, SIZE, endpoint=True) / 100
    return RandomObject(*map(float, (x, y, yaw, rng.uniform(*MASS), rng.uniform(*FRICTION), size)))


def run_grasp(file: str, seed: int, set: str, number: int, shape: str) -> Grasp:
    """Simulates one grasp.

    Raises:
        InputError: if it cannot be built.
        SimulationDivergedError: if its state is no longer finite.
    """
    drawn = draw(seed, set, number, shape)
    rng = np.random.default_rng([seed, SETS.index(set), number, *shape.encode(), SENSORS])
    station = make_private_station(with_object(load_scenario(file), shape, drawn))
    recording = run_station(station)
    return Grasp(set, number, shape, drawn, {n: probe(station, recording, n, rng) for n in SECTIONS})


def probe(station: Station, recording: Recording, sections: int, rng: np.random.Generator) -> Probe:
    """Estimates at the end of every pressure step with so many sections, from one recording.

    If the scenario's sensors have errors, these are drawn from `rng` for every finger and DRAWS sets of sensors.
    """
    errors = strain_errors(station.scenario.sensor)
    angles: list[Array] = []
    torques: list[Array] = []
    for finger in station.fingers:
        again = read_again(station, recording, finger, sections)
        sets = [again] if errors is None else with_errors(again, errors, rng)
        shapes = [each.shape().q for each in sets]
        loads = [external_torque_again(station, recording, finger, each) for each in sets]
        for found, values in ((angles, shapes), (torques, loads)):
            held = [held_samples(station.scenario, recording, each)[:, -SAMPLES:].mean(axis=1) for each in values]
            found.append(np.array(held))
    return Probe(np.stack(angles, axis=2), np.stack(torques, axis=2))


def with_errors(again: ReadAgain, errors: StrainErrors, rng: np.random.Generator) -> list[ReadAgain]:
    """A finger read again by DRAWS sets of sensors.

    The first sample of a recording occurs twice, as do its readings.
    """
    response = again.layout.response
    ratios = np.repeat(response.ratio(again.readings[1:])[:, None], DRAWS, axis=1)
    readings = response.reading(disturb(errors, ratios, again.period, rng))
    return [replace(again, readings=np.concatenate([each[:1], each])) for each in np.moveaxis(readings, 1, 0)]


def with_object(scenario: Scenario, shape: str, drawn: RandomObject) -> Scenario:
    """The scenario with another object, in the place of its own and at the same height.

    Raises:
        InputError: unless exactly one model is free.
    """
    return with_mesh(scenario, SHAPES[shape], SCALES.get(shape, 1.0), drawn)


def with_mesh(scenario: Scenario, file: str, scale: float, drawn: RandomObject) -> Scenario:
    """The scenario with the mesh of a file as its object; raises as `with_object`."""
    found = deepcopy(scenario)
    model = free_model(found)
    X_WO = model.X_PC.GetDeterministicValue()
    height = X_WO.translation()[2] + model.mesh.scale * lowest(model.file, X_WO.rotation())
    turn = RotationMatrix.MakeZRotation(np.radians(drawn.yaw_deg))
    x, y, _ = X_WO.translation() + 1e-3 * np.array([drawn.x_mm, drawn.y_mm, 0.0])
    model.file, model.mesh.scale = file, drawn.size * scale
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
        InputError: if it is not a mesh file.
    """
    vertices = read_scene(model_path(file)).convex_hull.vertices
    return float(np.min(vertices @ rotation.matrix()[2]))


@dataclass(frozen=True)
class GraspNumber:
    """Which grasp a row belongs to."""

    set: str
    grasp: int
    shape: str


@dataclass(frozen=True)
class GraspRow(RandomObject, GraspNumber):
    """A grasp: its random parameters, and what each set of sensors recognizes with two and with four sections."""

    recognized_2: str  # one of SHAPES or UNKNOWN for each set, separated by spaces
    recognized_4: str
    cause: str  # of a failure; empty: none


def grasp_row(grasp: Grasp, models: Mapping[int, ObjectClassifier]) -> GraspRow:
    """The row of a grasp; the models by their numbers of sections."""
    two, four = (recognized(models[sections], grasp) for sections in SECTIONS)
    drawn = asdict(grasp.drawn)
    return GraspRow(
        grasp.set, grasp.number, grasp.shape, **drawn, recognized_2=two, recognized_4=four, cause=grasp.cause
    )


def check_scenario_for_recognition(file: str) -> None:
    """Checks a scenario before any work is done.

    Raises:
        InputError: if it cannot be built, its object cannot be replaced, or its estimates cannot be repeated.
    """
    scenario = load_scenario(file)
    for part, known in (("sensor", "strain"), ("estimator", "arcs")):
        value = getattr(scenario, part).type
        if value != known:
            raise InputError(
                file, f"{part}.type", value, f"give {known}: readings are also computed for other sections"
            )
    if scenario.sensor.pressure_errors is not None:
        raise InputError(file, "sensor.pressure_errors", "given", "omit them: errors are applied to strain only")
    if scenario.sensor.errors is not None and scenario.sensor.errors.dead:
        raise InputError(file, "sensor.errors.dead", "given", "omit it: readings are also computed for other sections")
    if scenario.pressure.hold_samples < SAMPLES:
        value, expected = scenario.pressure.hold_samples, f"give {SAMPLES} or more, whose mean is recognized"
        raise InputError(file, "pressure.hold_samples", value, expected)
    steps = scenario.pressure.steps
    if list(steps) != ["all"] or len(set(steps["all"])) < len(steps["all"]) or min(steps["all"]) <= 0:
        raise InputError(file, "pressure.steps", steps, "give steps for all, each at another pressure above 0 Pa")
    try:
        station = make_private_station(
            with_object(scenario, next(iter(SHAPES)), draw(0, SETS[0], 0, next(iter(SHAPES))))
        )
        find_gripper(station.fingers, "recognition")
    except InputError as error:
        raise error.inside(file) from error.__cause__


def run_grasps(
    file: str, numbers: Mapping[str, int], seed: int, executor: Executor, report: Callable[[], Any]
) -> list[Grasp]:
    """Runs random grasps of every shape; the same seed leads to the same ones.

    Args:
        file: name or path of a scenario.
        numbers: how many of every shape, for each of SETS.
        executor: runs the simulations.
        report: called after every grasp.
    """
    keys = [(set, i, shape) for set in SETS for i in range(numbers[set]) for shape in SHAPES]
    grasps: dict[tuple[str, int, str], Grasp] = {}

    def failed(key: tuple[str, int, str], error: BaseException) -> Grasp:
        return Grasp(*key, draw(seed, *key), {}, describe(error))

    jobs = {key: (file, seed, *key) for key in keys}
    run_study(executor, run_grasp, jobs, grasps.__setitem__, failed, ended=lambda key: report())
    return [grasps[key] for key in keys]


def train(file: str, grasps: Sequence[Grasp], sections: int) -> ObjectClassifier:
    """The model trained on the training grasps with so many sections; raises as `train_object_classifier`."""
    known = [grasp for grasp in grasps if grasp.set == SETS[0] and grasp.probes]
    if len({grasp.shape for grasp in known}) < len(SHAPES):
        causes = {grasp.cause for grasp in grasps if grasp.cause}
        raise InputError(file, "grasps", sorted(causes), "no grasp of some shape could be simulated")
    return _trained(file, known, sections)


def _trained(file: str, grasps: Sequence[Grasp], sections: int) -> ObjectClassifier:
    angles, torques = _stacked(grasps, sections)
    sets = len(angles) // len(grasps)
    labels = [grasp.shape for grasp in grasps for _ in range(sets)]
    numbers = [number for number in range(len(grasps)) for _ in range(sets)]
    pressures = load_scenario(file).pressure.steps["all"]
    return train_object_classifier(labels, angles, torques, pressures, sections, numbers)


def left_out(file: str, grasps: Sequence[Grasp], sections: int) -> dict[str, float]:
    """For each of SHAPES, how often its test grasps are unknown to a model trained without it, %."""
    known = [grasp for grasp in grasps if grasp.set == SETS[0] and grasp.probes]
    found = {}
    for shape in SHAPES:
        model = _trained(file, [grasp for grasp in known if grasp.shape != shape], sections)
        tested = [recognized(model, grasp).split() for grasp in grasps if (grasp.set, grasp.shape) == (SETS[1], shape)]
        answers = [answer for each in tested for answer in each]
        found[shape] = 100 * answers.count(UNKNOWN) / max(len(answers), 1)
    return found


def recognized(model: ObjectClassifier, grasp: Grasp) -> str:
    """The likeliest answer for each set of sensors, separated by spaces; empty if the grasp failed."""
    if not grasp.probes:
        return ""
    probe = grasp.probes[model.sections]
    return " ".join(model.answers[i] for i in model.probabilities(probe.angles, probe.torques).argmax(axis=-1))


def confusion(rows: Sequence[GraspRow], sections: int) -> Array:
    """How many test grasps of each of SHAPES (rows) were recognized as each, and as unknown (columns).

    Each set of sensors counts as its share of a grasp.
    """
    answers = [*SHAPES, UNKNOWN]
    counts = np.zeros((len(SHAPES), len(answers)))
    for row in rows:
        found = getattr(row, f"recognized_{sections}").split()
        for answer in found if row.set == SETS[1] else ():
            counts[list(SHAPES).index(row.shape), answers.index(answer)] += 1 / len(found)
    return counts


def _stacked(grasps: Sequence[Grasp], sections: int) -> tuple[Array, Array]:
    """Angles and torques of grasps, set after set of each, (M E, L, F, N) each."""
    probes = [grasp.probes[sections] for grasp in grasps]
    return np.concatenate([probe.angles for probe in probes]), np.concatenate([probe.torques for probe in probes])


DARK = 0.55  # share of a shape's grasps, above which its number is white


def confusion_figure(shapes: Sequence[str], matrices: Mapping[int, Array], number: int) -> Figure:
    """A confusion matrix (C, C + 1) of counts for each number of sections, of `number` grasps of each shape."""
    with mpl.rc_context({**STYLE, "axes.grid": False}):
        figure = Figure(figsize=(4.4 * len(matrices), 3.9), layout="constrained")
        panels = figure.subplots(1, len(matrices), squeeze=False)[0]
        for axes, (sections, matrix) in zip(panels, matrices.items(), strict=True):
            _draw(axes, shapes, matrix, number)
            right = np.trace(matrix) / (number * len(shapes))
            axes.set_title(f"{sections} sections: {100 * right:.1f} % right")
        panels[0].set_ylabel("held")
    return figure


def _draw(axes: Axes, shapes: Sequence[str], matrix: Array, number: int) -> None:
    shares = matrix / number
    axes.imshow(shares, cmap="Blues", vmin=0, vmax=1)
    for (row, column), count in np.ndenumerate(matrix):
        color = "white" if shares[row, column] > DARK else "0.2" if count else "0.7"
        axes.text(column, row, f"{round(count, 1):g}", ha="center", va="center", color=color, fontsize=12)
    answers = [*shapes, UNKNOWN]
    axes.set_xticks(range(len(answers)), answers)
    axes.set_yticks(range(len(shapes)), shapes)
    axes.set_xticks(np.arange(0.5, len(answers) - 1), minor=True)
    axes.set_yticks(np.arange(0.5, len(shapes) - 1), minor=True)
    axes.grid(which="minor", color="white", lw=2, alpha=1)
    axes.tick_params(which="both", length=0)
    axes.spines[:].set_visible(False)
    axes.set_xlabel("recognized")
