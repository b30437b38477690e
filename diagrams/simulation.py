"""simulate: a scenario -> a recording of every named signal.

Seeds are set in the context (`seed_random_sources`): a RandomSource made in Python has no fixed seed of its own.

To build a station takes a third of a second, and Drake before 1.58 never frees one. A station holds no state of a run,
so `kept_station` returns it again for an equal scenario if nothing that it was built of has changed in between.
"""

import math
from collections import OrderedDict
from collections.abc import Callable, Iterator
from copy import copy, deepcopy
from dataclasses import replace
from hashlib import sha256

import numpy as np
from pydrake.common import RandomGenerator
from pydrake.geometry import Meshcat
from pydrake.multibody.plant import MultibodyPlant
from pydrake.systems.analysis import ApplySimulatorConfig, Simulator, SimulatorConfig
from pydrake.systems.framework import Context, Diagram
from pydrake.systems.primitives import RandomSource

from soft_gripper.diagrams.own_blocks import blamed, check_values, note_missing, own_blocks
from soft_gripper.diagrams.recording import Recording
from soft_gripper.diagrams.station import make_station
from soft_gripper.diagrams.station_parts import Station
from soft_gripper.diagrams.view.meshcat_view import PERIOD
from soft_gripper.errors import InputError, SimulationDivergedError
from soft_gripper.models import DIRECTORY
from soft_gripper.scenario.checks import checked_scenario
from soft_gripper.scenario.mesh_object import MESH_SUFFIXES
from soft_gripper.scenario.model_files import model_path
from soft_gripper.scenario.scenario import Scenario, default_simulator_config
from soft_gripper.scenario.scenario_file import dump_scenario

MOST = 4  # stations that are kept, 8 to 20 MB each
_NAMES_OTHERS = (
    b"<mesh",
    b"<uri",
    b"<include",
    b"filename",
    b"file:",
)  # in the text of a model that consists of several files
_kept: OrderedDict[tuple[str, ...], Station] = OrderedDict()


def kept_station(scenario: Scenario) -> Station:
    """A station without a Meshcat; a kept one if the scenario differs in nothing but its seed and its solver.

    One with blocks of the user's is not kept, since they may remember a run; nor is one whose models consist of several
    files of the user's, any of which may have changed.

    Raises:
        InputError: if a part of the scenario cannot be built.
    """
    scenario = checked_scenario("scenario", scenario)
    key = _built_of(scenario)
    if key is None:
        return make_station(scenario)
    station = _kept.pop(key, None) or make_station(deepcopy(scenario))  # the caller may change the scenario later
    _kept[key] = station
    while len(_kept) > MOST:
        _kept.popitem(last=False)
    return replace(station, parts=replace(station.parts, scenario=scenario))


def _built_of(scenario: Scenario) -> tuple[str, ...] | None:
    """The scenario and the contents of its files; None if these cannot be known."""
    types = (scenario.sensor.type, scenario.estimator.type, *scenario.estimator.alongside)
    named = [*(model.file for model in scenario.models), scenario.nominal.file, scenario.nominal.calibration]
    contents = [_content(file) for file in named if file is not None]
    if any(":" in name for name in types) or None in contents:
        return None
    of_a_run = replace(scenario.sensor, seed=0)
    built = replace(scenario, sensor=of_a_run, simulator_config=default_simulator_config())
    return dump_scenario(built), *filter(None, contents)


def _content(file: str) -> str | None:
    """What stands for the content of a file; None if it is missing, or consists of several."""
    path = model_path(file)
    if path.is_relative_to(DIRECTORY):
        return str([(each.name, each.stat().st_mtime_ns) for each in sorted(DIRECTORY.rglob("*"))])
    if not path.is_file() or path.suffix.lower() == ".gltf":
        return None
    content = path.read_bytes()
    is_mesh = path.suffix.lower() in MESH_SUFFIXES
    return None if not is_mesh and any(mark in content for mark in _NAMES_OTHERS) else sha256(content).hexdigest()


def seed_random_sources(diagram: Diagram, context: Context, seed: int) -> None:
    """Gives every RandomSource in a diagram a stream of its own, that follows from one seed, 0 or more.

    A source in Python has no other way to a fixed seed: a default context holds one that differs from instance to
    instance. Call it before `Simulator.Initialize`, in which the draws for a run are made.

    Args:
        diagram: which may hold diagrams.
        context: of the diagram, or of one that holds it.
        seed: of the run.
    """
    generator = RandomGenerator(seed)
    for source in _random_sources(diagram):
        source.SetRandomContext(source.GetMyMutableContextFromRoot(context), generator)


def _random_sources(diagram: Diagram) -> Iterator[RandomSource]:
    for system in diagram.GetSystems():
        if isinstance(system, Diagram):
            yield from _random_sources(system)
        elif isinstance(system, RandomSource):
            yield system


TASK_PAUSE = 0.5  # s of a task, between looks at whether it is over
Progress = Callable[[float], None]


def simulate(scenario: Scenario, meshcat: Meshcat | None = None, progress: Progress | None = None) -> Recording:
    """Runs a scenario from beginning to end.

    A scenario that equals one of the last few in all but its seed and its solver is run on the same blocks, see
    `kept_station`. Others are built, and with Drake before 1.58 a station that was built stays in memory for as long as
    the process runs: 8 MB with two fingers. For thousands of different scenarios use `run_sweep`, whose processes make
    way for others when they have grown.

    Args:
        scenario: what to run.
        meshcat: shows the run, and records it for `Meshcat.StaticHtml`.
        progress: called with the simulated time, s, after every step, and now and then in a task.

    Raises:
        InputError: if the scenario cannot be built, or leaves commands open, or one of the user's own blocks fails or
            puts out what is no number.
        SimulationDivergedError: if the state leaves the finite numbers.
    """
    station = kept_station(scenario) if meshcat is None else make_station(scenario, meshcat)
    return run_station(station, meshcat, progress)


def run_station(station: Station, meshcat: Meshcat | None = None, progress: Progress | None = None) -> Recording:
    """Runs the scenario of a station with a fresh context; see `simulate`."""
    check_closed(station)
    simulator = make_simulator(station)
    if meshcat is not None:
        meshcat.StartRecording(frames_per_second=1 / PERIOD)
    for time in _pauses(station.scenario):
        advance(simulator, station, time)
        if progress is not None:
            progress(simulator.get_context().get_time())
        if station.task is not None and station.task.is_over(
            station.task.GetMyContextFromRoot(simulator.get_context())
        ):
            break
    if meshcat is not None:
        meshcat.PublishRecording()
    return _recording(station, simulator.get_context())


def _recording(station: Station, context: Context) -> Recording:
    """What was logged, if a user's own blocks have put out numbers."""
    try:
        recording = station.recording(context)
    except (Exception, SystemExit) as failure:  # of functions that are called for all samples at once
        raise blamed(station, context, failure) or failure from failure
    check_values(own_blocks(station), recording)
    note_missing(recording)
    return recording


def check_closed(station: Station) -> None:
    """Raises an InputError if the scenario leaves commands open."""
    if station.parts.inputs:
        expected = f"connect or fix {', '.join(station.parts.inputs)}, and step a Simulator of your own"
        raise InputError("scenario", "external", station.scenario.external, expected)


def make_simulator(station: Station) -> Simulator:
    """A Simulator of a station with the solver and the seed of its scenario; Simulator(diagram) alone has neither."""
    simulator = Simulator(station.diagram)
    ApplySimulatorConfig(solver_config(station.scenario), simulator)
    seed_random_sources(station.diagram, simulator.get_mutable_context(), station.scenario.sensor.seed)
    return simulator


def _pauses(scenario: Scenario) -> Iterator[float]:
    """When a run pauses to report, and to see whether its task is over, s."""
    pause = TASK_PAUSE if scenario.task is not None else scenario.step_duration
    yield from (pause * number for number in range(1, math.ceil(scenario.duration / pause - 1e-9)))
    yield scenario.duration


def solver_config(scenario: Scenario) -> SimulatorConfig:
    """The scenario's simulator config; beside a discrete plant nothing is left for cenic to integrate."""
    config = copy(scenario.simulator_config)
    if scenario.plant_config.time_step > 0:
        config.integration_scheme = "explicit_euler"
        config.use_error_control = False
    return config


def advance(simulator: Simulator, station: Station, time: float) -> None:
    """Advances to a time, s; where it already is, nothing happens.

    Raises:
        InputError: if one of the user's own blocks fails.
        SimulationDivergedError: if the state leaves the finite numbers.
    """
    if time == simulator.get_context().get_time():
        return  # cenic ends the process over a step of no length
    failure: BaseException | None = None
    try:
        simulator.AdvanceTo(time)
    except (Exception, SystemExit) as error:
        failure = error
    context = simulator.get_context()
    plant_context = station.plant.GetMyContextFromRoot(context)
    state = station.plant.GetPositionsAndVelocities(plant_context)
    bad = np.flatnonzero(~np.isfinite(state))
    if failure is None and not len(bad):
        return
    _blame(station, context, failure, has_diverged=len(bad) > 0)
    if failure is not None and not isinstance(failure, RuntimeError):
        raise failure
    if failure is not None and _is_from_python(failure) and not len(bad) and _has_contact(station.plant, plant_context):
        raise failure
    reason = str(failure).strip().splitlines()[0] if failure is not None else ""
    names = station.plant.GetStateNames()
    worst = names[bad[0] if len(bad) else int(np.argmax(np.abs(state)))]
    drake = f" (Drake: {reason})" if reason else ""
    raise SimulationDivergedError(
        f"the simulation diverged before t = {context.get_time():.4g} s in state {worst}; likely cause:"
        f" a time step too long, or a contact or spring too stiff for the solver{drake}"
    ) from failure


def _blame(station: Station, context: Context, failure: BaseException | None, has_diverged: bool) -> None:
    """Raises an InputError if a user's own block has failed, or has led the state out of the finite numbers."""
    if failure is not None and not has_diverged and (error := blamed(station, context, failure)):
        raise error from failure
    blocks = own_blocks(station)
    if not blocks:
        return
    try:
        recording = station.recording(context)
    except (Exception, SystemExit):  # of a function that takes NaN badly
        return
    check_values(blocks, recording)


def _is_from_python(failure: RuntimeError) -> bool:
    """Whether it came through a block written in Python: it is at fault, or asked a plant that has diverged."""
    return failure.__traceback__ is not None and failure.__traceback__.tb_next is not None


def _has_contact(plant: MultibodyPlant, context: Context) -> bool:
    """Whether the plant can say what is touched in its present state."""
    try:
        plant.get_contact_results_output_port().Eval(context)
    except RuntimeError:
        return False
    return True
