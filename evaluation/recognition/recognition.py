"""Random grasps, shape models trained with some of them, and tried on the others."""

from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Executor, Future
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from soft_gripper.arrays import Array
from soft_gripper.diagrams.schema.scenario_file import load_scenario
from soft_gripper.diagrams.station import make_station
from soft_gripper.diagrams.wiring.grip_control import find_gripper
from soft_gripper.errors import InputError, WorkerDiedError
from soft_gripper.estimation.shape_model import ShapeModel
from soft_gripper.estimation.shape_training import train_shape_model
from soft_gripper.evaluation.executor.executor import Call, make_calls
from soft_gripper.evaluation.recognition.grasp import SECTIONS, SETS, SHAPES, Grasp, draw, run_grasp, with_object
from soft_gripper.evaluation.trials.variation import RandomObject


@dataclass(frozen=True)
class GraspNumber:
    """Which grasp a row belongs to."""

    set: str
    grasp: int
    shape: str


@dataclass(frozen=True)
class GraspRow(RandomObject, GraspNumber):
    """A grasp: what was drawn for it, and the shape recognized with two and with four sections."""

    recognized_2: str
    recognized_4: str
    cause: str  # of a failure; empty: none


def grasp_row(grasp: Grasp, models: Mapping[int, ShapeModel]) -> GraspRow:
    """The row of a grasp; the models by their numbers of sections."""
    two, four = (recognized(models[sections], grasp) for sections in SECTIONS)
    drawn = asdict(grasp.drawn)
    return GraspRow(
        grasp.set, grasp.number, grasp.shape, **drawn, recognized_2=two, recognized_4=four, cause=grasp.cause
    )


def check_scenario_for_recognition(file: str) -> None:
    """Looks at a scenario before any work is done.

    Raises:
        InputError: if it cannot be built, its object not be exchanged, or its estimates not be made again.
    """
    scenario = load_scenario(file)
    for part, known in (("sensor", "strain"), ("estimator", "arcs")):
        value = getattr(scenario, part).type
        if value != known:
            raise InputError(file, f"{part}.type", value, f"give {known}: readings are made for other sections too")
    if scenario.sensor.pressure_errors is not None:
        raise InputError(file, "sensor.pressure_errors", "given", "leave them out: errors are given to strain alone")
    if scenario.sensor.errors is not None and scenario.sensor.errors.dead:
        raise InputError(file, "sensor.errors.dead", "given", "leave it out: readings are made for other sections too")
    steps = scenario.pressure.steps
    if list(steps) != ["all"] or len(set(steps["all"])) < len(steps["all"]) or min(steps["all"]) <= 0:
        raise InputError(file, "pressure.steps", steps, "give steps for all, each at another pressure above 0 Pa")
    try:
        station = make_station(with_object(scenario, next(iter(SHAPES)), draw(0, SETS[0], 0, next(iter(SHAPES)))))
        find_gripper(station.fingers, "recognition")
    except InputError as error:
        raise error.inside(file) from error.__cause__


def run_grasps(
    file: str, numbers: Mapping[str, int], seed: int, executor: Executor, report: Callable[[Grasp], Any]
) -> list[Grasp]:
    """Runs random grasps of every shape; the same seed leads to the same ones.

    Args:
        file: name or path of a scenario.
        numbers: how many of every shape, by SETS.
        executor: runs the simulations.
        report: called with every grasp that has ended.
    """
    calls = [(file, seed, set, i, shape) for set in SETS for i in range(numbers[set]) for shape in SHAPES]
    grasps: dict[Call, Grasp] = {}

    def ended(call: Call, future: Future[Grasp]) -> None:
        error = future.exception()
        if error is not None and not isinstance(error, WorkerDiedError):
            raise error
        _, _, set, number, shape = call
        lost = Grasp(set, number, shape, draw(seed, set, number, shape), {}, "its process died")
        grasps[call] = lost if error else future.result()
        report(grasps[call])

    make_calls(executor, run_grasp, calls, ended)
    return [grasps[call] for call in calls]


def train(file: str, grasps: Sequence[Grasp], sections: int) -> ShapeModel:
    """The model that the training grasps lead to with so many sections; raises as `train_shape_model`."""
    known = [grasp for grasp in grasps if grasp.set == SETS[0] and grasp.probes]
    labels = [grasp.shape for grasp in known]
    if len(set(labels)) < len(SHAPES):
        causes = {grasp.cause for grasp in grasps if grasp.cause}
        raise InputError(file, "grasps", sorted(causes), "no grasp of some shape could be simulated")
    pressures = load_scenario(file).pressure.steps["all"]
    return train_shape_model(labels, *_stacked(known, sections), pressures, sections)


def recognized(model: ShapeModel, grasp: Grasp) -> str:
    """The likeliest shape; empty if the grasp failed."""
    if not grasp.probes:
        return ""
    probe = grasp.probes[model.sections]
    return model.shapes[int(np.argmax(model.probabilities(probe.angles, probe.torques)))]


def confusion(rows: Sequence[GraspRow], sections: int) -> Array:
    """How many test grasps of each of SHAPES (rows) were recognized as each (columns)."""
    pairs = [(row.shape, getattr(row, f"recognized_{sections}")) for row in rows if row.set == SETS[1]]
    return np.array([[pairs.count((held, found)) for found in SHAPES] for held in SHAPES])


def _stacked(grasps: Sequence[Grasp], sections: int) -> tuple[Array, Array]:
    """Angles and torques of grasps, (M, L, F, N) each."""
    probes = [grasp.probes[sections] for grasp in grasps]
    return np.array([probe.angles for probe in probes]), np.array([probe.torques for probe in probes])
