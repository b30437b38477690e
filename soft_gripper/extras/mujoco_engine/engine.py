"""Runs scenarios in MuJoCo, many at once; our blocks sense, estimate, control and record them.

A run returns the recording of its station, with the same signals as in Drake; derived signals are computed when read.
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
from soft_gripper.extras.mujoco_engine.lockstep import Logs, rows_of, simulate_network
from soft_gripper.extras.mujoco_engine.network import Network
from soft_gripper.extras.mujoco_engine.plants import Exported, Plants, export_to_mujoco
from soft_gripper.extras.mujoco_engine.touching import TouchSensors
from soft_gripper.extras.mujoco_engine.variation import (
    Content,
    Key,
    Variation,
    begin_positions,
    blocks_key,
    plain_objects,
    plant_key,
    station_key,
    variation,
    vary_model,
)
from soft_gripper.scenario.checks import checked_scenario
from soft_gripper.scenario.deformables import is_deformable
from soft_gripper.scenario.schema import Scenario
from soft_gripper.truth.contact import COLUMNS

LONGEST_STEP, SHORTEST_STEP = 0.005, 0.001  # s, of MuJoCo
# Changes by half the step that count as small: shift of tips, m, and fraction of a force.
_SMALL_TIP_SHIFT, _SMALL_FORCE_CHANGE = 5e-5, 5e-3
_SMALL_SLIP = 2e-4  # m, shift of a carried object in the gripper by half the step that counts as small
_POINT_DISTANCE = 0.03  # m, distance from the middle of an object to points that show its rotation
_MIN_FORCE = 0.1  # N, minimum of the force to which changes are relative
_END_SAMPLES = 50  # samples at the end
_LOG_BYTES = 2**28  # bytes, maximum of the logs of runs made together
_MAX_STATIONS = 4  # cached stations
Stations = OrderedDict[Key, Station]
_stations: Stations = OrderedDict()
_plant_sources: Stations = OrderedDict()  # stations whose plants are copied, by the keys of their plants


def run_many(scenarios: Sequence[Scenario], described: bool = True) -> Iterator[Run | Exception]:
    """Runs scenarios in MuJoCo, those of one structure together; yields a run or its error for each.

    `described`: recordings have the attributes that describe their runs.

    Raises:
        InputError: if MuJoCo is not installed, or too old to step many simulations.
    """
    load_mujoco()
    content_of = cache(fingerprint)  # files do not change while this runs
    context_of = cache(Diagram.CreateDefaultContext)
    user_stations: Stations = OrderedDict()
    runs = [_serve(scenario, content_of, context_of, user_stations) for scenario in scenarios]
    groups: dict[Any, list[int]] = {}
    keys: dict[Diagram, Hashable] = {}  # of groups
    outcomes: dict[int, Run | Exception] = {}
    for i, run in enumerate(runs):
        if isinstance(run, ServedRun):
            if (diagram := run.station.diagram) not in keys:
                keys[diagram] = _structure(run.station) if _serves_many(run.station) else diagram
            groups.setdefault(keys[diagram], []).append(i)
        else:
            outcomes[i] = run
    for numbers in groups.values():
        group = [member for member in (runs[i] for i in numbers) if isinstance(member, ServedRun)]
        size = _batch_size(group[0].station)
        for begin in range(0, len(numbers), size):
            batch = slice(begin, begin + size)
            outcomes |= dict(zip(numbers[batch], _run_alike(group[batch], described), strict=True))
    yield from (outcomes[i] for i in range(len(scenarios)))


def suited_step(scenario: Scenario) -> float | None:
    """Longest step, s, that changes a run little when halved; None: the scenario cannot run.

    Raises:
        InputError: as `run_many`.
    """
    load_mujoco()
    served = _serve(scenario, fingerprint, Diagram.CreateDefaultContext, OrderedDict())
    if isinstance(served, Exception):
        return None
    return _choose_step([served], _Models([served]))[0]


def _structure(station: Station) -> Hashable:
    """Key that is equal for stations that can run together."""
    scenario, plant = station.scenario, station.plant
    times = scenario.sensor.period, scenario.duration, plant.time_step(), scenario.engine_step
    joints = [(joint.name(), joint.type_name()) for joint in map(plant.get_joint, plant.GetJointIndices())]
    recorded = scenario.record.patches_every, station.logs.port_numbers
    shapes = [model.file for model in scenario.models], station.parts.scene_graph.model_inspector().num_geometries()
    return structure(station.diagram), repr((times, joints, recorded, shapes, scenario.contact_points, scenario.arm))


class ServedRun(NamedTuple):
    """Station of a run, possibly built for another scenario with the same key."""

    station: Station
    variation: Variation  # of the run's objects, from those in the plant of the station
    plant: Key | None  # of its plant, see `plant_key`
    blocks: Key | None  # of its blocks, see `blocks_key`


def _share_diagrams(served: Sequence[ServedRun]) -> list[Station]:
    """Stations of runs, each with the diagram of the first one with equal blocks."""
    diagrams: dict[Any, Diagram] = {}
    keys = [run.station.diagram if run.blocks is None else run.blocks for run in served]
    return [
        replace(run.station, diagram=diagrams.setdefault(key, run.station.diagram))
        for run, key in zip(served, keys, strict=True)
    ]


def _serve(
    scenario: Scenario, content_of: Content, context_of: Callable[[Diagram], Context], user_stations: Stations
) -> ServedRun | Exception:
    """Station that serves a scenario; `user_stations` have user's blocks, whose code may change later."""
    try:
        scenario = checked_scenario("scenario", scenario)
        _check_supported(scenario)
        key = station_key(scenario, content_of)
        plant = None if scenario.arm is not None else plant_key(scenario, content_of)
        build = partial(_build_station, deepcopy(plain_objects(scenario)), plant)  # the caller may change the scenario
        is_own = has_own_blocks(scenario)
        store = user_stations if is_own else _stations
        station = build() if key is None else get_or_make(store, key, build, _MAX_STATIONS)
        if is_own and not _serves_many(station):
            user_stations.pop(key or (), None)
        differences = variation(scenario, station.scenario)
        if differences.poses:
            _check_begin(station, differences, context_of(station.diagram))
        parts = replace(station.parts, scenario=scenario, masses=differences.masses, frictions=differences.frictions)
        if differences.poses or scenario.task != station.scenario.task:
            _replan(parts, station.diagram, begin_positions(station.plant, differences))
    except InputError as error:
        return error
    return ServedRun(replace(station, parts=parts), differences, plant, blocks_key(scenario, content_of))


def _serves_many(station: Station) -> bool:
    """Whether one station may serve several runs: a user's block that is not made of steps may keep state."""
    return all(isinstance(block.system, ArrayBlock) for block in user_blocks(station))


def _check_begin(station: Station, variation: Variation, context: Context) -> None:
    """Checks that objects begin outside of others, as building a station does."""
    plant = station.plant
    plant.SetPositions(plant.GetMyMutableContextFromRoot(context), begin_positions(plant, variation))
    check_starts_apart(station.diagram, station.parts.scene_graph, context)


def _replan(parts: StationParts, diagram: Diagram, positions: Array) -> None:
    """Plans the task for the scenario's own poses, and checks it, as building a station does.

    `positions` are those at the beginning of a run.
    """
    task, arm, period = parts.scenario.task, parts.arm, parts.scenario.sensor.period
    if task is not None and arm is not None:
        parts.task = make_task_machine(task, parts.scenario.models, arm, period)
        parts.check_task(diagram, positions)


def _build_station(scenario: Scenario, plant: Key | None) -> Station:
    """Builds a station, if possible around a copy of another station's equal plant."""
    source = None if plant is None else _plant_sources.get(plant)
    station = make_private_station(scenario, composed=False, like=None if source is None else source.parts)
    check_closed(station)
    if plant is not None:
        get_or_make(_plant_sources, plant, lambda: station, _MAX_STATIONS)
    return station


def _check_supported(scenario: Scenario) -> None:
    """Raises an InputError if a scenario needs features that engine mujoco lacks."""
    if scenario.plant_config.time_step == 0:
        raise InputError("scenario", "plant_config.time_step", 0.0, "give one above 0: engine mujoco takes steps")
    for i, model in enumerate(scenario.models):
        if model.self_contact:
            expected = "omit it: in engine mujoco the links of a finger do not touch each other"
            raise InputError("scenario", f"models[{i}].self_contact", True, expected)
        if is_deformable(model.mesh):
            raise InputError("scenario", f"models[{i}].file", model.file, "is soft; engine mujoco has rigid objects")


def _batch_size(station: Station) -> int:
    """Number of runs made together, by the memory for their logs."""
    samples = station.scenario.duration / station.scenario.sensor.period
    width = sum(station.logs.get_input_port(i).size() for i in range(station.logs.num_input_ports()))
    return max(1, int(_LOG_BYTES / (8 * width * samples)))


def _run_alike(served: Sequence[ServedRun], described: bool) -> Iterator[Run | Exception]:
    """Runs stations of one structure together, with a step chosen for three of them."""
    stations, models = [run.station for run in served], _Models(served)
    try:
        step, words = _step_of(served, models)
        network = Network(_share_diagrams(served), models.plants(served, [step]), stations[0].logs)
        logs, lengths, failed = simulate_network(stations[0], network)
    except InputError as failure:  # of a user's block, in any run
        if len(served) == 1:
            yield failure
        half_count = len(served) // 2
        for half_runs in (served[:half_count], served[half_count:]) if half_count else ():
            yield from _run_alike(half_runs, described)
        return
    times = np.arange(logs.samples) * stations[0].scenario.sensor.period
    for i, station in enumerate(stations):
        if i in failed:
            yield failed[i]
            continue
        samples = station.logs.make_samples(times[: lengths[i]], logs.samples_of(i, lengths[i]))
        attributes = station.parts.attributes | {"engine_step": words} if described else {}
        yield Run(station, make_recording(station.logs.labels, samples, attributes))


def _step_of(served: Sequence[ServedRun], models: "_Models") -> tuple[float, str]:
    """Step of runs of one structure, s, and a text that says how it was chosen."""
    station = served[0].station
    if station.scenario.engine_step is not None:
        step = dividing_step(station.plant.time_step(), station.scenario.engine_step)
        return step, f"{1e3 * step:g} ms"
    run_indices = sorted({0, len(served) // 2, len(served) - 1})
    step, change = _choose_step([served[i] for i in run_indices], models)
    return step, f"{1e3 * step:g} ms; {change.words}"


def dividing_step(plant_step: float, longest: float) -> float:
    """Longest step, s, that divides the step of Drake's plant and is at most `longest`."""
    return plant_step / max(1, math.ceil(plant_step / longest - 1e-9))


class Change(NamedTuple):
    """Change of the end of a run by half the step."""

    tip: float  # m, the largest of all fingers, in the median run
    force: float  # fraction of the contact force of a finger
    slip: float  # m, of the object of a task in the gripper

    @property
    def is_small(self) -> bool:
        """Whether the step is short enough."""
        return self.tip <= _SMALL_TIP_SHIFT and self.force <= _SMALL_FORCE_CHANGE and self.slip <= _SMALL_SLIP

    @property
    def words(self) -> str:
        """Text that describes the change to users."""
        shifts = f"{1e3 * self.tip:.3f} mm, a carried object by {1e3 * self.slip:.3f} mm"
        return f"half of it moves tips by {shifts}, and changes forces by {self.force:.2%}"


def _choose_step(served: Sequence[ServedRun], models: "_Models") -> tuple[float, Change]:
    """Longest step, s, that changes the ends of some runs little when halved, and that change; nothing is logged."""
    step = dividing_step(served[0].station.plant.time_step(), LONGEST_STEP)
    ends_by_step: list[list[_End]] = []  # of all runs with each step
    while True:
        steps = [step, step / 2][len(ends_by_step) :]
        stations = [run.station for run in served] * len(steps)
        network = Network(_share_diagrams(served) * len(steps), models.plants(served, steps))
        logs, lengths, _ = simulate_network(stations[0], network)
        ends = [_end(station, logs, i, lengths[i]) for i, station in enumerate(stations)]
        ends_by_step += [ends[begin : begin + len(served)] for begin in range(0, len(ends), len(served))]
        change = _change(*ends_by_step)
        if change.is_small or step / 2 < SHORTEST_STEP:
            return step, change
        step, ends_by_step = step / 2, ends_by_step[1:]


def _change(ends: "Sequence[_End]", with_half: "Sequence[_End]") -> Change:
    """Median change by half the step, over some runs."""
    changes = []
    for whole_step_end, half_step_end in zip(ends, with_half, strict=True):
        largest_forces = np.maximum(whole_step_end.forces, half_step_end.forces)
        force_change = np.abs(whole_step_end.forces - half_step_end.forces) / np.maximum(largest_forces, _MIN_FORCE)
        tip_shifts = np.linalg.norm(whole_step_end.tips - half_step_end.tips, axis=-1)
        slip = np.linalg.norm(whole_step_end.object - half_step_end.object, axis=-1)
        changes.append((float(tip_shifts.max()), float(force_change.max()), float(slip.max())))
    return Change(*np.median(changes, axis=0).tolist())


class _End(NamedTuple):
    """End of a run of F fingers."""

    tips: Array  # (F, 3) m in their bases
    forces: Array  # (F,) N, of all contacts together, in the last samples; 0 if contact is not recorded
    object: Array  # (P, 3) m, points of the task's object in the gripper when it is last held; 0 if it never is


def _end(station: Station, logs: Logs, environment: int, samples: int) -> _End:
    """End of a run, or of a task's first phase that holds an object: there the fingers are at rest."""
    if station.task is not None:
        holding_phases = [phase_index for phase_index, phase in enumerate(station.task.phases) if phase.holds]
        holding_samples = np.flatnonzero(np.isin(logs.phases[:samples, environment], holding_phases[:1]))
        samples = int(holding_samples[-1]) + 1 if len(holding_samples) else samples
    plant, last_samples = station.plant, slice(max(0, samples - _END_SAMPLES), samples)
    context = plant.CreateDefaultContext()
    plant.SetPositionsAndVelocities(context, logs.states[samples - 1, environment])
    tips = [finger.frames[-1].CalcPose(context, finger.base.body_frame()).translation() for finger in station.fingers]
    tables = [rows_of(*patches, environment) for patches in logs.patches[last_samples]]
    forces = _net_forces(tables, len(station.fingers))
    return _End(np.array(tips).reshape(-1, 3), forces, _carried_points(station, logs, environment))


def _net_forces(tables: Sequence[Array], fingers: int) -> Array:
    """Net contact force of each finger, (F,) N, the mean over tables of contacts.

    Friction at opposing points is indeterminate: it grows as the step falls, and cancels in the sum.
    """
    rows = np.concatenate([np.empty((0, COLUMNS)), *(table for table in tables if table.shape[1])])
    finger, forces = rows[:, 0].astype(int), rows[:, 3:4] * rows[:, 10:13]
    net = [np.bincount(finger, component, fingers) for component in forces.T]
    return np.asarray(np.linalg.norm(net, axis=0) / max(1, len(tables)))


def _carried_points(station: Station, logs: Logs, environment: int) -> Array:
    """Points of the object of a task when it is last held, see `_End`."""
    points = np.concatenate([np.zeros((3, 1)), _POINT_DISTANCE * np.eye(3)], axis=1)
    task = station.scenario.task
    phases = () if station.task is None else station.task.phases
    holding_phases = [phase_index for phase_index, phase in enumerate(phases) if phase.holds]
    holding_samples = np.flatnonzero(np.isin(logs.phases[:, environment], holding_phases))
    if task is None or task.object is None or not len(holding_samples):
        return np.zeros_like(points.T)
    plant = station.plant
    context = plant.CreateDefaultContext()
    plant.SetPositionsAndVelocities(context, logs.states[holding_samples[-1], environment])
    X_BO = first_body(plant, task.object).body_frame().CalcPose(context, station.fingers[0].base.body_frame())
    return np.asarray((X_BO @ points).T)


class _Models:
    """Models of runs in MuJoCo; some share a plant of Drake and differ from it."""

    def __init__(self, served: Sequence[ServedRun]):
        """`served` has all runs."""
        self._listed = {model.name for run in served for model in run.station.scenario.models if model.free}
        self._exported: dict[tuple[Key | MultibodyPlant, float], Exported] = {}

    def plants(self, served: Sequence[ServedRun], steps: Sequence[float]) -> Plants:
        """Makes plants of some runs, for one step of MuJoCo, s, after the other."""
        steps_of_runs = [(run, step) for step in steps for run in served]
        exported = [self._export(run, step) for run, step in steps_of_runs]
        models = [
            vary_model(
                export.model, export.pairs, run.station.plant, run.variation, run.station.scenario.contact_points
            )
            for (run, _), export in zip(steps_of_runs, exported, strict=True)
        ]
        begins = np.array([begin_positions(run.station.plant, run.variation) for run, _ in steps_of_runs])
        is_one = all(run is exported[0] for run in exported)
        sensors = [run.touching for run in exported if isinstance(run.touching, TouchSensors)]
        return Plants(served[0].station, sensors[0].with_environments(sensors), models, begins, is_one_file=is_one)

    def _export(self, served: ServedRun, step: float) -> Exported:
        key = served.plant or served.station.plant, step
        if key not in self._exported:
            self._exported[key] = export_to_mujoco(served.station, step, self._listed)
        return self._exported[key]
