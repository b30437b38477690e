"""Runs scenarios in MuJoCo, many at once: stepped together; our blocks sense, estimate, control and record them.

A run comes back as the recording of its station, with the same signals; those that follow from others are computed
when they are read, as after a run in Drake.
"""

import math
from collections import OrderedDict
from collections.abc import Callable, Hashable, Iterator, Sequence
from copy import deepcopy
from dataclasses import replace
from functools import cache, partial
from typing import Any, NamedTuple

import numpy as np
from pydrake.multibody.plant import MultibodyPlant
from pydrake.systems.framework import Context, Diagram

from soft_gripper.array_block import ArrayBlock
from soft_gripper.arrays import Array
from soft_gripper.cached import get_or_make
from soft_gripper.diagrams.own_blocks import user_blocks
from soft_gripper.diagrams.recording import make_recording
from soft_gripper.diagrams.scene import check_starts_apart, first_body
from soft_gripper.diagrams.simulation import Run, check_closed, fingerprint, has_own_blocks
from soft_gripper.diagrams.station import make_private_station
from soft_gripper.diagrams.station_parts import Station, StationParts
from soft_gripper.diagrams.task_plan import make_task_machine
from soft_gripper.errors import InputError
from soft_gripper.extras.mujoco_engine.equal_blocks import structure
from soft_gripper.extras.mujoco_engine.library import load_mujoco
from soft_gripper.extras.mujoco_engine.lockstep import Logs, rows_of, simulated
from soft_gripper.extras.mujoco_engine.network import Network
from soft_gripper.extras.mujoco_engine.plants import Exported, Plants, in_mujoco
from soft_gripper.extras.mujoco_engine.touching import TouchSensors
from soft_gripper.extras.mujoco_engine.variation import (
    Content,
    Key,
    Variation,
    begin,
    blocks_key,
    plain_objects,
    plant_key,
    station_key,
    variation,
    varied,
)
from soft_gripper.scenario.checks import checked_scenario
from soft_gripper.scenario.deformables import is_deformable
from soft_gripper.scenario.schema import Scenario
from soft_gripper.truth.contact import COLUMNS

LONGEST_STEP, SHORTEST_STEP = 0.005, 0.001  # s, of MuJoCo
_SMALL_SHIFT, _SMALL_SHARE = 5e-5, 5e-3  # m, and share of a force, that half the step may change
_SMALL_SLIP = 2e-4  # m, by which half the step may move a carried object in the gripper
_REACH = 0.03  # m, from the middle of an object to points that move as it turns
_FORCE = 0.1  # N, of which that share is taken if a force is less
_LAST = 50  # samples at the end
_MEMORY = 2**28  # bytes that the logs of runs that are made together may take
_MOST = 4  # cached stations
Stations = OrderedDict[Key, Station]
_stations: Stations = OrderedDict()
_copied: Stations = OrderedDict()  # by the keys of their plants, which others are copies of


def run_many(scenarios: Sequence[Scenario], described: bool = True) -> Iterator[Run | Exception]:
    """Runs scenarios in MuJoCo, those of one structure together; a run that fails gives its error.

    `described`: recordings have the attributes that describe their runs.

    Raises:
        InputError: if MuJoCo is not installed, or too old to step many simulations.
    """
    load_mujoco()
    content_of = cache(fingerprint)  # files do not change while this runs
    context_of = cache(Diagram.CreateDefaultContext)
    own: Stations = OrderedDict()
    served = [_serve(scenario, content_of, context_of, own) for scenario in scenarios]
    groups: dict[Any, list[int]] = {}
    for i, each in enumerate(served):
        if isinstance(each, Served):
            groups.setdefault(_structure(each.station) if _serves_many(each.station) else i, []).append(i)
    found: dict[int, Run | Exception] = {i: each for i, each in enumerate(served) if isinstance(each, Exception)}
    for numbers in groups.values():
        alike = [each for each in (served[i] for i in numbers) if isinstance(each, Served)]
        size = _at_once(alike[0].station)
        for first in range(0, len(numbers), size):
            part = slice(first, first + size)
            found |= dict(zip(numbers[part], _run_alike(alike[part], described), strict=True))
    yield from (found[i] for i in range(len(scenarios)))


def suited_step(scenario: Scenario) -> float | None:
    """The longest step, s, of which half changes a run of a scenario by little; None: it cannot be run.

    Raises:
        InputError: as `run_many`.
    """
    load_mujoco()
    served = _serve(scenario, fingerprint, Diagram.CreateDefaultContext, OrderedDict())
    if isinstance(served, Exception):
        return None
    return _chosen_step([served], _Models([served]))[0]


def _structure(station: Station) -> Hashable:
    """What stations that run together have in common."""
    scenario, plant = station.scenario, station.plant
    times = scenario.sensor.period, scenario.duration, plant.time_step(), scenario.engine_step
    joints = [(each.name(), each.type_name()) for each in map(plant.get_joint, plant.GetJointIndices())]
    recorded = scenario.record.patches_every, station.logs.port_numbers
    shapes = [model.file for model in scenario.models], station.parts.scene_graph.model_inspector().num_geometries()
    return structure(station.diagram), repr((times, joints, recorded, shapes, scenario.contact_points, scenario.arm))


class Served(NamedTuple):
    """The station of a run, which may have been built for another scenario with the same key."""

    station: Station
    of: Variation  # how the objects of the run differ from those in the plant of the station
    plant: Key | None  # of its plant, see `plant_key`
    blocks: Key | None  # of its blocks, see `blocks_key`


def _wired(served: Sequence[Served]) -> list[Station]:
    """The stations of runs, each with the diagram of the first one that has equal blocks."""
    diagrams: dict[Any, Diagram] = {}
    keys = [each.station.diagram if each.blocks is None else each.blocks for each in served]
    return [
        replace(each.station, diagram=diagrams.setdefault(key, each.station.diagram))
        for each, key in zip(served, keys, strict=True)
    ]


def _serve(
    scenario: Scenario, content_of: Content, context_of: Callable[[Diagram], Context], own: Stations
) -> Served | Exception:
    """The station that serves a scenario; those in `own` have blocks of the user's, whose code may change later."""
    try:
        scenario = checked_scenario("scenario", scenario)
        _check_carried_over(scenario)
        key = station_key(scenario, content_of)
        plant = None if scenario.arm is not None else plant_key(scenario, content_of)
        build = partial(_built, deepcopy(plain_objects(scenario)), plant)  # the caller may change it
        store = own if has_own_blocks(scenario) else _stations
        station = build() if key is None else get_or_make(store, key, build, _MOST)
        if not _serves_many(station):
            own.pop(key or (), None)
        of = variation(scenario, station.scenario)
        if of.poses:
            _check_begin(station, of, context_of(station.diagram))
        parts = replace(station.parts, scenario=scenario, masses=of.masses, frictions=of.frictions)
        if of.poses or scenario.task != station.scenario.task:
            _plan_anew(parts, station.diagram, begin(station.plant, of))
    except InputError as error:
        return error
    return Served(replace(station, parts=parts), of, plant, blocks_key(scenario, content_of))


def _serves_many(station: Station) -> bool:
    """Whether one station may serve several runs: a block of the user's that is not made of steps may remember one."""
    return all(isinstance(block.system, ArrayBlock) for block in user_blocks(station))


def _check_begin(station: Station, of: Variation, context: Context) -> None:
    """Checks that objects begin outside of others, as a station that is built checks for itself."""
    station.plant.SetPositions(station.plant.GetMyMutableContextFromRoot(context), begin(station.plant, of))
    check_starts_apart(station.diagram, station.parts.scene_graph, context)


def _plan_anew(parts: StationParts, diagram: Diagram, positions: Array) -> None:
    """Plans the task of a scenario for its own places, and checks it, as a station that is built does for itself.

    `positions` are those in which a run begins.
    """
    task, arm, period = parts.scenario.task, parts.arm, parts.scenario.sensor.period
    if task is not None and arm is not None:
        parts.task = make_task_machine(task, parts.scenario.models, arm, period)
        parts.check_task(diagram, positions)


def _built(scenario: Scenario, plant: Key | None) -> Station:
    """A station, around a copy of a plant that another one was built for, if there is one."""
    like = None if plant is None else _copied.get(plant)
    station = make_private_station(scenario, composed=False, like=None if like is None else like.parts)
    check_closed(station)
    if plant is not None:
        get_or_make(_copied, plant, lambda: station, _MOST)
    return station


def _check_carried_over(scenario: Scenario) -> None:
    """Raises an InputError for what MuJoCo cannot simulate as Drake does."""
    if scenario.plant_config.time_step == 0:
        raise InputError("scenario", "plant_config.time_step", 0.0, "give one above 0: engine mujoco takes steps")
    for i, model in enumerate(scenario.models):
        if model.self_contact:
            expected = "leave it out: in engine mujoco the links of a finger do not touch each other"
            raise InputError("scenario", f"models[{i}].self_contact", True, expected)
        if is_deformable(model.mesh):
            raise InputError("scenario", f"models[{i}].file", model.file, "is soft; engine mujoco has rigid objects")


def _at_once(station: Station) -> int:
    """How many runs are made together: as many as memory holds the logs of."""
    samples = station.scenario.duration / station.scenario.sensor.period
    width = sum(station.logs.get_input_port(i).size() for i in range(station.logs.num_input_ports()))
    return max(1, int(_MEMORY / (8 * width * samples)))


def _run_alike(served: Sequence[Served], described: bool) -> Iterator[Run | Exception]:
    """Runs stations of one structure together, with the step that suits some of them."""
    stations, models = [each.station for each in served], _Models(served)
    try:
        step, words = _step_of(served, models)
        network = Network(_wired(served), models.plants(served, [step]), stations[0].logs)
        logs, lengths, failed = simulated(stations[0], network)
    except InputError as failure:  # of a user's block, in any of the runs
        if len(served) == 1:
            yield failure
        half = len(served) // 2
        for part in (served[:half], served[half:]) if half else ():
            yield from _run_alike(part, described)
        return
    times = np.arange(logs.samples) * stations[0].scenario.sensor.period
    for i, station in enumerate(stations):
        if i in failed:
            yield failed[i]
            continue
        computed = station.logs.make_samples(times[: lengths[i]], logs.of(i, lengths[i]))
        about = station.parts.about | {"engine_step": words} if described else {}
        yield Run(station, make_recording(station.logs.labels, computed, about))


def _step_of(served: Sequence[Served], models: "_Models") -> tuple[float, str]:
    """The step of runs of one structure, and how it was chosen."""
    station = served[0].station
    if station.scenario.engine_step is not None:
        step = dividing_step(station.plant.time_step(), station.scenario.engine_step)
        return step, f"{1e3 * step:g} ms"
    three = sorted({0, len(served) // 2, len(served) - 1})
    step, change = _chosen_step([served[i] for i in three], models)
    return step, f"{1e3 * step:g} ms; {change.words}"


def dividing_step(plant_step: float, longest: float) -> float:
    """The longest step up to one that divides the step of Drake's plant."""
    return plant_step / max(1, math.ceil(plant_step / longest - 1e-9))


class Change(NamedTuple):
    """The change of the end of a run by half the step."""

    tip: float  # m, the largest of all fingers, in the median run
    force: float  # share of the contact force of a finger
    slip: float  # m, of the object of a task in the gripper

    @property
    def is_small(self) -> bool:
        """Whether the step is short enough."""
        return self.tip <= _SMALL_SHIFT and self.force <= _SMALL_SHARE and self.slip <= _SMALL_SLIP

    @property
    def words(self) -> str:
        """For users."""
        tips, slip = (
            f"half of it moves tips by {1e3 * self.tip:.3f} mm",
            f"a carried object by {1e3 * self.slip:.3f} mm",
        )
        return f"{tips}, {slip}, and changes forces by {self.force:.2%}"


def _chosen_step(served: Sequence[Served], models: "_Models") -> tuple[float, Change]:
    """The longest step of which half changes where some runs end by little, and by how much; the runs log nothing."""
    step = dividing_step(served[0].station.plant.time_step(), LONGEST_STEP)
    known: list[list[_End]] = []  # of all runs with each step
    while True:
        steps = [step, step / 2][len(known) :]
        stations = [each.station for each in served] * len(steps)
        network = Network(_wired(served) * len(steps), models.plants(served, steps))
        logs, lengths, _ = simulated(stations[0], network)
        ends = [_end(station, logs, i, lengths[i]) for i, station in enumerate(stations)]
        known += [ends[first : first + len(served)] for first in range(0, len(ends), len(served))]
        change = _change(*known)
        if change.is_small or step / 2 < SHORTEST_STEP:
            return step, change
        step, known = step / 2, known[1:]


def _change(ends: "Sequence[_End]", with_half: "Sequence[_End]") -> Change:
    """The change by half the step, in the median of some runs."""
    found = []
    for one, other in zip(ends, with_half, strict=True):
        largest = np.maximum(one.forces, other.forces)
        share = np.abs(one.forces - other.forces) / np.maximum(largest, _FORCE)
        shift = np.linalg.norm(one.tips - other.tips, axis=-1)
        slip = np.linalg.norm(one.object - other.object, axis=-1)
        found.append((float(shift.max()), float(share.max()), float(slip.max())))
    return Change(*np.median(found, axis=0).tolist())


class _End(NamedTuple):
    """Where a run of F fingers ends."""

    tips: Array  # (F, 3) m in their bases
    forces: Array  # (F,) N, of all contacts together, in the last samples; 0 if contact is not recorded
    object: Array  # (P, 3) m, points of the object of a task in the gripper where it is last held; 0 if it never is


def _end(station: Station, logs: Logs, environment: int, samples: int) -> _End:
    """Where a run ends, or of a task where the first phase ends that holds an object: there the fingers are at rest."""
    if station.task is not None:
        holding = [number for number, phase in enumerate(station.task.phases) if phase.holds]
        held = np.flatnonzero(np.isin(logs.phases[:samples, environment], holding[:1]))
        samples = int(held[-1]) + 1 if len(held) else samples
    plant, last = station.plant, slice(max(0, samples - _LAST), samples)
    context = plant.CreateDefaultContext()
    plant.SetPositionsAndVelocities(context, logs.states[samples - 1, environment])
    tips = [finger.frames[-1].CalcPose(context, finger.base.body_frame()).translation() for finger in station.fingers]
    tables = [rows_of(*each, environment) for each in logs.patches[last]]
    forces = _net_forces(tables, len(station.fingers))
    return _End(np.array(tips).reshape(-1, 3), forces, _carried(station, logs, environment))


def _net_forces(tables: Sequence[Array], fingers: int) -> Array:
    """Forces of all contacts of each finger together, (F,) N, in the mean over tables of contacts.

    Friction of points that oppose each other is not determined: it grows as the step falls.
    """
    rows = np.concatenate([np.empty((0, COLUMNS)), *(table for table in tables if table.shape[1])])
    finger, forces = rows[:, 0].astype(int), rows[:, 3:4] * rows[:, 10:13]
    net = [np.bincount(finger, along, fingers) for along in forces.T]
    return np.asarray(np.linalg.norm(net, axis=0) / max(1, len(tables)))


def _carried(station: Station, logs: Logs, environment: int) -> Array:
    """Points of the object of a task where it is last held, see `_End`."""
    points, task = np.concatenate([np.zeros((3, 1)), _REACH * np.eye(3)], axis=1), station.scenario.task
    phases = () if station.task is None else station.task.phases
    holding = [number for number, phase in enumerate(phases) if phase.holds]
    held = np.flatnonzero(np.isin(logs.phases[:, environment], holding))
    if task is None or task.object is None or not len(held):
        return np.zeros_like(points.T)
    plant = station.plant
    context = plant.CreateDefaultContext()
    plant.SetPositionsAndVelocities(context, logs.states[held[-1], environment])
    X_BO = first_body(plant, task.object).body_frame().CalcPose(context, station.fingers[0].base.body_frame())
    return np.asarray((X_BO @ points).T)


class _Models:
    """The models of runs in MuJoCo, some of which share a plant of Drake and differ from it."""

    def __init__(self, served: Sequence[Served]):
        """`served` are all runs."""
        self._listed = {model.name for each in served for model in each.station.scenario.models if model.free}
        self._exported: dict[tuple[Key | MultibodyPlant, float], Exported] = {}

    def plants(self, served: Sequence[Served], steps: Sequence[float]) -> Plants:
        """The plants of some runs with one step of MuJoCo after the other, s."""
        runs = [(each, step) for step in steps for each in served]
        exported = [self._of(each, step) for each, step in runs]
        models = [
            varied(found.model, found.file, each.station.plant, each.of, each.station.scenario.contact_points)
            for (each, _), found in zip(runs, exported, strict=True)
        ]
        begins = np.array([begin(each.station.plant, each.of) for each, _ in runs])
        is_one = all(each is exported[0] for each in exported)
        sensors = [each.touching for each in exported if isinstance(each.touching, TouchSensors)]
        return Plants(served[0].station, sensors[0].beside(sensors), models, begins, of_one_file=is_one)

    def _of(self, served: Served, step: float) -> Exported:
        key = served.plant or served.station.plant, step
        if key not in self._exported:
            self._exported[key] = in_mujoco(served.station, step, self._listed)
        return self._exported[key]
