"""simulate: a scenario -> a recording of every named signal.

Seeds are set in the context (`seed_random_sources`): a RandomSource made in Python has no fixed seed.

Building a station takes a tenth of a second to a second, and Drake before 1.58 never frees one. A station holds no
state of a run, so `cached_station` returns it again for an equal scenario if none of its input files has changed in
between.
"""

import math
from collections import OrderedDict
from collections.abc import Callable, Iterator, Sequence
from contextlib import nullcontext
from copy import copy, deepcopy
from dataclasses import replace
from hashlib import sha256
from itertools import groupby
from pathlib import Path
from typing import NamedTuple

import numpy as np
from pydrake.common import RandomGenerator
from pydrake.geometry import Meshcat
from pydrake.multibody.plant import MultibodyPlant
from pydrake.systems.analysis import ApplySimulatorConfig, Simulator, SimulatorConfig, SimulatorStatus
from pydrake.systems.framework import Context, Diagram
from pydrake.systems.primitives import RandomSource

from soft_gripper.cached import get_or_make
from soft_gripper.diagrams.own_blocks import check_values, user_block_error, user_blocks
from soft_gripper.diagrams.recording import Recording
from soft_gripper.diagrams.station import make_private_station
from soft_gripper.diagrams.station_parts import Station
from soft_gripper.diagrams.wiring.sensors import RANDOM
from soft_gripper.errors import InputError, SimulationDivergedError
from soft_gripper.files.text import read_bytes
from soft_gripper.model_import.forms.mesh import SUFFIXES as MESH_SUFFIXES
from soft_gripper.model_import.read_model import FORMS
from soft_gripper.models import DIRECTORY
from soft_gripper.progress import progress_of_long_runs
from soft_gripper.registry import is_own, registered
from soft_gripper.scenario.checks import checked_scenario
from soft_gripper.scenario.directives import parts_with_files
from soft_gripper.scenario.drake_values import plain_values
from soft_gripper.scenario.model_files import model_path
from soft_gripper.scenario.schema import DRAKE, Scenario, default_simulator_config

MAX_STATIONS = 4  # cached stations, 8 to 20 MB each
_REFERENCE_MARKS = (
    b"<mesh",
    b"<uri",
    b"<include",
    b"filename",
    b"file:",
)  # in the text of a model that refers to other files
_stations: OrderedDict[tuple[str, ...], Station] = OrderedDict()


def cached_station(scenario: Scenario) -> Station:
    """A private station without a Meshcat; a cached one if the scenario differs only in its seed and its solver.

    Stations with user blocks, which may remember a run, are not cached, nor are those with models of several user
    files, which may have changed.

    Raises:
        InputError: if a part of the scenario cannot be built.
    """
    scenario = checked_scenario("scenario", scenario)
    key = None if has_own_blocks(scenario) else build_key(scenario)
    if key is None:
        return make_private_station(scenario)
    station = get_or_make(
        _stations, key, lambda: make_private_station(deepcopy(scenario)), MAX_STATIONS
    )  # the caller may change the scenario
    return replace(station, parts=replace(station.parts, scenario=scenario))


def has_own_blocks(scenario: Scenario) -> bool:
    """Whether a scenario names user functions that make blocks."""
    return any(map(is_own, (scenario.sensor.type, scenario.estimator.type, *scenario.estimator.alongside)))


def build_key(scenario: Scenario, content_of: Callable[[Path], str | None] | None = None) -> tuple[str, ...] | None:
    """Key of a cached station: its scenario and the contents of its files; None if these cannot be determined.

    `content_of` gives the fingerprint of a file; None: `fingerprint`.
    """
    models = [*scenario.models, *parts_with_files(scenario.directives)]
    files = [*(model.file for model in models), scenario.nominal.file, scenario.nominal.calibration]
    paths = [model_path(file) for file in files if file is not None]
    places = dict.fromkeys(DIRECTORY if path.is_relative_to(DIRECTORY) else path for path in paths)
    contents = list(map(content_of or fingerprint, places))
    if None in contents:
        return None
    unseeded = replace(scenario.sensor, seed=0)
    plain_scenario = replace(scenario, sensor=unseeded, simulator_config=default_simulator_config())
    return repr(plain_values(plain_scenario)), *filter(None, contents)  # YAML takes ten times as long


def fingerprint(path: Path) -> str | None:
    """A fingerprint of a file, or of the shipped models; None if the file is missing or refers to others."""
    if path == DIRECTORY:
        return str([(file.name, file.stat().st_mtime_ns) for file in sorted(DIRECTORY.rglob("*"))])
    if not path.is_file() or path.suffix.lower() == ".gltf":
        return None
    try:
        content = read_bytes(path)
    except InputError:
        return None
    suffix = path.suffix.lower()
    may_refer = any(suffix in form.marks for form in FORMS) or any(mark in content for mark in _REFERENCE_MARKS)
    return None if suffix not in MESH_SUFFIXES and may_refer else sha256(content).hexdigest()


def seed_random_sources(diagram: Diagram, context: Context, seed: int) -> None:
    """Gives each RandomSource in a diagram a separate stream, derived from one seed, 0 or more.

    The fingers to which they belong take turns by their names, whatever their order in a file.

    A source in Python has no other way to a fixed seed: a default context holds one that differs from instance to
    instance. Call it before `Simulator.Initialize`, in which the draws for a run are made.

    Args:
        diagram: may contain other diagrams.
        context: the context of the diagram, or of one that contains it.
        seed: the seed of the run.
    """
    generator = RandomGenerator(seed)
    for source in sorted(_random_sources(diagram), key=_owner):
        source.SetRandomContext(source.GetMyMutableContextFromRoot(context), generator)


def _owner(source: RandomSource) -> tuple[str, str]:
    """The diagram that holds a source, and the finger of its sensors, if it has one."""
    diagram, _, name = source.GetSystemPathname().rpartition("::")
    return diagram, name.rsplit(".", 2)[0] if name.endswith(RANDOM) else ""


def _random_sources(diagram: Diagram) -> Iterator[RandomSource]:
    for system in diagram.GetSystems():
        if isinstance(system, Diagram):
            yield from _random_sources(system)
        elif isinstance(system, RandomSource):
            yield system


_CHECK_PERIOD = 0.5  # s, between checks of the state of a task
Progress = Callable[[float], None]


def simulate(scenario: Scenario, meshcat: Meshcat | None = None, progress: Progress | None = None) -> Recording:
    """Runs a scenario from beginning to end.

    A scenario that differs from one of the last few only in its seed and its solver reuses the same blocks, see
    `cached_station`. Others are built; with Drake before 1.58, every station built stays in memory for as long as
    the process runs: 8 MB with two fingers. For thousands of different scenarios use `run_sweep`, whose worker
    processes are replaced when they have grown. Signals are computed when they are read, and until all have been, a
    recording keeps the blocks of its station in memory: ``recording.data.load()`` reads all.

    Args:
        scenario: the scenario to run.
        meshcat: shows the run, and records it for `Meshcat.StaticHtml`.
        progress: called with the simulated time, s, after every step of the simulator. None: a run of more than 2 s
            shows a bar on a terminal or in a notebook.

    Raises:
        InputError: if the scenario cannot be built or leaves commands open, or if a user block fails or outputs
            a value that is not finite.
        SimulationDivergedError: if the state is no longer finite.
    """
    station = cached_station(scenario) if meshcat is None else make_private_station(scenario, meshcat)
    with nullcontext(progress) if progress else progress_of_long_runs(scenario.duration) as report:
        return run_station(station, meshcat, report)


class Run(NamedTuple):
    """A run of a scenario that has ended."""

    station: Station
    recording: Recording


def run_many(scenarios: Sequence[Scenario], described: bool = True) -> Iterator[Run | Exception]:
    """Runs scenarios, each in its engine, which may run many at once; a run that failed gives its error.

    `described` as for `run_station`.
    """
    for engine, engine_scenarios in groupby(scenarios, lambda scenario: scenario.engine):
        if engine == DRAKE:
            yield from (_run(scenario, described) for scenario in engine_scenarios)
        else:
            yield from registered("ENGINES")[engine]([*engine_scenarios], described)


def _run(scenario: Scenario, described: bool) -> Run | Exception:
    try:
        station = cached_station(scenario)
        return Run(station, run_station(station, described=described))
    except (InputError, SimulationDivergedError) as error:
        return error


def run_station(
    station: Station, meshcat: Meshcat | None = None, progress: Progress | None = None, *, described: bool = True
) -> Recording:
    """Runs the scenario of a station with a fresh context; see `simulate`.

    In a station from `make_station` every block runs, so that every port can be read: `simulate` is faster. A recording
    that is not kept need not be `described` by its scenario and versions, see `provenance`.
    """
    if station.scenario.engine != DRAKE:
        if meshcat is not None:
            expected = f"is not shown as it runs; choose {DRAKE}, or a video of the recording"
            raise InputError("scenario", "engine", station.scenario.engine, expected)
        (run,) = run_many([station.scenario], described)
        if isinstance(run, Exception):
            raise run
        return run.recording
    return _recording(station, run_to_end(station, meshcat, progress).get_context(), described)


def run_to_end(station: Station, meshcat: Meshcat | None = None, progress: Progress | None = None) -> Simulator:
    """Runs a station as `run_station` does, but returns the simulator, which can go on from there."""
    check_closed(station)
    simulator = make_simulator(station)
    if meshcat is not None:
        from soft_gripper.diagrams.view.meshcat_view import PERIOD

        meshcat.StartRecording(frames_per_second=1 / PERIOD)
    if progress is not None:
        simulator.set_monitor(_monitor(progress))
    for time in _pauses(station.scenario):
        if advance(simulator, station, time):
            break
    simulator.clear_monitor()
    if meshcat is not None:
        meshcat.PublishRecording()
    return simulator


def _monitor(progress: Progress) -> Callable[[Context], None]:
    def report(context: Context) -> None:
        progress(context.get_time())  # the result of which is no status

    return report


def _recording(station: Station, context: Context, described: bool) -> Recording:
    """The recording of a run, after checking that the outputs of user blocks are finite."""
    blocks = user_blocks(station)
    try:
        recording = station.recording(context, described)
        if blocks:
            recording.data.load()  # so that a failure is blamed on its block
    except (Exception, SystemExit) as failure:  # raised by functions that are called for all samples at once
        raise user_block_error(station, context, failure) or failure from failure
    check_values(blocks, recording)
    return recording


def check_closed(station: Station) -> None:
    """Raises an InputError if the scenario leaves commands open."""
    if station.parts.inputs:
        expected = f"connect or fix {', '.join(station.parts.inputs)}, and step your own Simulator"
        raise InputError("scenario", "external", station.scenario.external, expected)


def make_simulator(station: Station) -> Simulator:
    """A Simulator of a station with the solver and the seed of its scenario; Simulator(diagram) has neither.

    Raises:
        InputError: if the scenario is to be simulated by another engine.
    """
    if station.scenario.engine != DRAKE:
        raise InputError("scenario", "engine", station.scenario.engine, f"this steps a simulator: choose {DRAKE}")
    simulator = Simulator(station.diagram)
    ApplySimulatorConfig(solver_config(station.scenario), simulator)
    seed_random_sources(station.diagram, simulator.get_mutable_context(), station.scenario.sensor.seed)
    return simulator


def _pauses(scenario: Scenario) -> Iterator[float]:
    """Times at which a run pauses to check its state, s."""
    pause = _CHECK_PERIOD if scenario.task is not None else scenario.step_duration
    yield from (pause * number for number in range(1, math.ceil(scenario.duration / pause - 1e-9)))
    yield scenario.duration


def solver_config(scenario: Scenario) -> SimulatorConfig:
    """The scenario's simulator config; with a discrete plant, nothing is left for cenic to integrate."""
    config = copy(scenario.simulator_config)
    if scenario.plant_config.time_step > 0:
        config.integration_scheme = "explicit_euler"
        config.use_error_control = False
    return config


def advance(simulator: Simulator, station: Station, time: float) -> bool:
    """Advances to a time, s; does nothing if the simulator is already there. Returns whether a task has ended the run.

    Raises:
        InputError: if a user block fails.
        SimulationDivergedError: if the state is no longer finite.
    """
    if time == simulator.get_context().get_time():
        return False  # cenic aborts the process on a step of zero length
    failure: BaseException | None = None
    is_over = False
    try:
        is_over = simulator.AdvanceTo(time).reason() == SimulatorStatus.ReturnReason.kReachedTerminationCondition
    except (Exception, SystemExit) as error:
        failure = error
    context = simulator.get_context()
    plant_context = station.plant.GetMyContextFromRoot(context)
    state = station.plant.GetPositionsAndVelocities(plant_context)
    bad = np.flatnonzero(~np.isfinite(state))
    if failure is None and not len(bad):
        for deformable in station.parts.deformables.values():
            deformable.check(plant_context)
        return is_over
    _blame(station, context, failure, has_diverged=len(bad) > 0)
    if failure is not None and not isinstance(failure, RuntimeError):
        raise failure
    traceback = failure.__traceback__ if failure is not None else None
    # It passed through a Python block, which is at fault or has evaluated a diverged plant.
    is_from_python = traceback is not None and traceback.tb_next is not None
    if failure is not None and is_from_python and not len(bad) and _has_contact(station.plant, plant_context):
        raise failure
    reason = str(failure).strip().splitlines()[0] if failure is not None else ""
    names = station.plant.GetStateNames()
    worst_state = names[bad[0] if len(bad) else int(np.argmax(np.abs(state)))]
    drake = f" (Drake: {reason})" if reason else ""
    raise SimulationDivergedError(
        f"the simulation diverged before t = {context.get_time():.4g} s in state {worst_state}; likely cause:"
        f" a time step too long, or a contact or spring too stiff for the solver{drake}"
    ) from failure


def _blame(station: Station, context: Context, failure: BaseException | None, has_diverged: bool) -> None:
    """Raises an InputError if a user block has failed, or has made the state non-finite."""
    if failure is not None and not has_diverged and (error := user_block_error(station, context, failure)):
        raise error from failure
    blocks = user_blocks(station)
    if not blocks:
        return
    try:
        recording = station.recording(context)
        recording.data.load()
    except (Exception, SystemExit):  # raised by a function that cannot handle NaN
        return
    check_values(blocks, recording)


def _has_contact(plant: MultibodyPlant, context: Context) -> bool:
    """Whether the plant can compute contacts in its current state."""
    try:
        plant.get_contact_results_output_port().Eval(context)
    except RuntimeError:
        return False
    return True
