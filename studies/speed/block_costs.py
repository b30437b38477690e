"""Measures the cost of the closed diagram, and of its blocks compared with the bare plant.

Speed is simulated time over computing time of whole runs, logging included. "all blocks" is a difference: the time
of a sample in the closed diagram, with its share of the recording, less that of the plant alone, run alternately.
Whole runs have two rows: bars are for recordings without reading, "all read" computes every signal.

The single blocks written in Python are measured with all blocks running and all their ports read, as in
a user's station; in a private run most are removed. A run pauses midway between samples, when
the new sample is taken but nothing is computed from it yet; a block's inputs are evaluated, then its output ports (and
its next sample, if it takes samples), less the time of reading the same ports again.

All times are CPU time of the process, threads included; medians over repeats. Exit code 1: a bar is missed.
"""

import argparse
from collections import defaultdict
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory
from xml.etree import ElementTree

import numpy as np
from pydrake.systems.analysis import ApplySimulatorConfig, Simulator
from pydrake.systems.framework import Context, Diagram, DiagramBuilder, System

from soft_gripper.arrays import Array
from soft_gripper.diagrams.recording import Recording
from soft_gripper.diagrams.scene import add_plant
from soft_gripper.diagrams.simulation import run_station, solver_config
from soft_gripper.diagrams.station import make_private_station, make_station
from soft_gripper.diagrams.station_parts import Station
from soft_gripper.estimators.named_estimators import find_estimator
from soft_gripper.fingers.finger import Finger
from soft_gripper.fingers.urdf import expand_urdf
from soft_gripper.scenario.model_files import model_path
from soft_gripper.scenario.scenario_file import load_scenario
from soft_gripper.scenario.schema import SensorConfig
from soft_gripper.scenario.sensor_presets import sensor_layout
from soft_gripper.sensors.measurement import MeasurementModel
from soft_gripper.sensors.sensor_layout import SensorLayout
from studies.speed.timed_run import bare_diagram, cpu_time, read_all

# Scenario, and the least speed relative to real time.
SPEED_BARS = (
    ("free_bending", 33.0),
    ("box_grasp", 13.0),
    ("irregular_grasp", 6.5),
    ("pick_and_place_box", 2.0),
    ("pick_and_place_irregular", 2.0),
    ("pick_and_place_delicate", 2.0),
)
BLOCKS_SCENARIO = ("free_bending", ["pressure.steps.all=[60.0e3, 150.0e3, -30.0e3, 90.0e3]"])
ESTIMATOR_BARS = {"arcs": 60.0, "spline": 60.0, "gaussian": 60.0, "contact": 500.0, "recursive": 500.0}  # us a sample
# Scenario, ground truth that is recorded, and the most times that it takes as long as the plant with its drive.
CLOSED_RATIO_BARS = (("free_bending", "all", 2.9), ("box_grasp", "all", 1.7), ("box_grasp", "none", 1.4))
# Scenario, its models with fingers, and the most times that fingers which yield in space take as long as planar ones:
# the plant with its drive, and closed.
SPATIAL_BARS = (("free_bending", ("left_finger", "right_finger"), 2.3, 1.7), ("box_grasp", ("gripper",), 2.3, 1.7))
SPATIAL_ESTIMATOR_BAR = 3.0  # times as long as in the plane
IN_SPACE = ("bending", "sideways", "twist")
BLOCKS_BAR = 0.2  # ms a sample at most, all blocks of both fingers together
CREEP_BAR = 1.15  # a grasp whose nominal fingers creep takes at most this many times as long
CREEP = {"share": "0.1 0.1", "time": "0.5 4"}
REPEATS = 5
SAMPLES = 500  # of every block measured by itself, in every repeat


def run(options: argparse.Namespace) -> int:
    """Prints the tables; 1 if a bar is missed."""
    print("Times faster than real time    median    min    max   bar")
    speeds_hold = [_print_speed(name, bar) for name, bar in SPEED_BARS]
    print("\nA sample of both fingers [ms]  median    min    max   bar")
    blocks_hold = _print_blocks(*BLOCKS_SCENARIO)
    print("\nClosed over bare plant          median    min    max   bar")
    closed_hold = [_print_closed_ratio(name, truth, bar) for name, truth, bar in CLOSED_RATIO_BARS]
    print("\nSpatial over planar fingers      median    min    max   bar")
    spatial_hold = [_print_spatial_ratio(*case) for case in SPATIAL_BARS]
    print("\nA sample of one finger [us]    median    min    max   bar")
    estimators_hold = [_print_estimator(name, bar) for name, bar in ESTIMATOR_BARS.items()]
    print("\nTimes as long                  median    min    max   bar")
    creep_holds = _print_creep("box_grasp")
    spatial_estimator_holds = _print_spatial_estimator("gaussian", SPATIAL_ESTIMATOR_BAR)
    return (
        0
        if all(speeds_hold)
        and blocks_hold
        and all(closed_hold)
        and all(spatial_hold)
        and all(estimators_hold)
        and creep_holds
        and spatial_estimator_holds
        else 1
    )


def _print_speed(name: str, bar: float) -> bool:
    station = make_private_station(load_scenario(name))
    speeds = np.array([_speeds(station) for _ in range(REPEATS)]).T
    holds = bool(np.median(speeds[0]) >= bar)
    _print_rows(name, speeds, f"{'at least' if holds else 'MISSES'} {bar:g}")
    return holds


def _speeds(station: Station) -> Array:
    """Simulated over computing time of a whole run, without and with reading all signals, (2,)."""
    recordings: list[Recording] = []
    run = cpu_time(lambda: recordings.append(run_station(station)))
    reading = cpu_time(lambda: read_all(recordings[0]))
    return recordings[0].values("time")[-1] / np.array([run, run + reading])


def _print_blocks(name: str, overrides: list[str]) -> bool:
    station = make_private_station(load_scenario(name, overrides))
    running = make_station(load_scenario(name, overrides))
    plant = _bare_plant(station)
    repeats = [(_run(plant, station), _run(station.diagram, station), measure_blocks(running)) for _ in range(REPEATS)]
    plant_times, loop_times = (np.array(times).T for times in list(zip(*repeats, strict=True))[:2])
    block_times = [repeat[2] for repeat in repeats]
    costs = {name: np.array([cost[name] for cost in block_times]) for name in block_times[0]}
    blocks = loop_times - plant_times
    holds = bool(np.median(blocks[0]) <= BLOCKS_BAR)
    _print_row("bare plant", plant_times[0])
    for name, cost in costs.items():
        _print_row(f"  {name}, read", cost)
    _print_rows("all blocks", blocks, f"{'at most' if holds else 'MISSES'} {BLOCKS_BAR:g}")
    return holds


def _bare_plant(station: Station) -> Diagram:
    """Diagram of the plant alone."""
    builder, scenario = DiagramBuilder(), station.scenario
    add_plant(builder, scenario, visuals=False)
    return builder.Build()


def _print_closed_ratio(name: str, truth: str, bar: float) -> bool:
    """Prints the ratio of the time of the station with all its signals to the time of the plant with its drive."""
    station = make_private_station(load_scenario(name, [f"record.truth={truth}"]))
    plant = bare_diagram(station.scenario)
    ratios = np.array([_run(station.diagram, station) / _run(plant, station) for _ in range(REPEATS)]).T
    holds = bool(np.median(ratios[0]) <= bar)
    _print_rows(f"{name}, truth {truth}", ratios, f"{'at most' if holds else 'MISSES'} {bar:g}")
    return holds


def _print_spatial_ratio(name: str, models: tuple[str, ...], *bars: float) -> bool:
    """Prints the ratio of the time of fingers that also yield sideways and in twist to the time of planar ones."""
    steps = ["pressure.steps.all=[60.0e3, 120.0e3]"]
    yields = [f"models.{model}.fingers.all.yields=bending sideways twist" for model in models]
    stations = [make_private_station(load_scenario(name, [*steps, *changes])) for changes in ([], yields)]
    runs = [(diagram, station) for station in stations for diagram in (bare_diagram(station.scenario), station.diagram)]
    times = np.array([[_run(*run) for run in runs] for _ in range(REPEATS)]).reshape(REPEATS, 2, 2, 2)
    plant, loop = np.moveaxis(times[:, 1] / times[:, 0], 0, -1)  # (bare or closed, nothing or all read, repeats)
    holds = np.median([plant[0], loop[0]], axis=1) <= bars
    for kind, ratios, bar, holds_bar in zip(("bare plant", "closed"), (plant[:1], loop), bars, holds, strict=True):
        _print_rows(f"{name}, {kind}", ratios, f"{'at most' if holds_bar else 'MISSES'} {bar:g}")
    return bool(holds.all())


def _print_estimator(name: str, bar: float) -> bool:
    """Prints the time of an estimator block alone, two sensors per side, on a finger that is pressed at its side."""
    repeats = np.array([_estimate_time(name, SensorLayout(_finger(), 2)) for _ in range(REPEATS)])
    holds = bool(np.median(repeats) <= bar)
    _print_row(name, repeats, f"{'at most' if holds else 'MISSES'} {bar:g}")
    return holds


def _print_spatial_estimator(name: str, bar: float) -> bool:
    """Prints the ratio of the times of a spatial and a planar finger's estimator, two sections each."""
    spatial = SensorConfig(sections=2, layout="four_faces_and_diagonal")
    planar = SensorLayout(_finger(), 2)
    space = sensor_layout(replace(_finger(), yields=IN_SPACE), spatial)
    ratios = np.array([_estimate_time(name, space) / _estimate_time(name, planar) for _ in range(REPEATS)])
    holds = bool(np.median(ratios) <= bar)
    _print_row(f"{name}, in space", ratios, f"{'at most' if holds else 'MISSES'} {bar:g}")
    return holds


def _finger() -> Finger:
    (finger,) = expand_urdf(model_path("package://soft_gripper/grippers/finger.urdf")).fingers
    return finger


def _estimate_time(name: str, layout: MeasurementModel) -> float:
    """Time of an estimator block alone, us, on a finger that is pressed at its side."""
    finger, q, seconds = layout.finger, layout.straight.copy(), 0.0
    q[: finger.segments] = 0.08 * np.linspace(0.3, 1.2, finger.segments)
    block = find_estimator(name)(layout, np.array([0.0, 0.0, -9.81]), 0.01)
    context = block.CreateDefaultContext()
    inputs = {"driving_torque": finger.pressure_torque(6e4), "X_WB": np.eye(3, 4).ravel()}
    for sample in range(SAMPLES):
        for port, value in {**inputs, layout.quantity: layout.read(q * (1 + 1e-4 * sample))}.items():
            block.GetInputPort(port).FixValue(context, value)
        seconds += cpu_time(lambda: block.GetOutputPort("estimated_joint_angles").Eval(context))
    return 1e6 * seconds / SAMPLES


def _print_creep(name: str) -> bool:
    """Prints the time of a grasp with creep in the nominal model over that without; the first model's fingers creep."""
    tree = ElementTree.parse(model_path(load_scenario(name).models[0].file))
    for finger in tree.iter("finger"):
        ElementTree.SubElement(finger, "creep", CREEP)
    with TemporaryDirectory() as folder:
        file = Path(folder) / "creeping.urdf"
        tree.write(file)
        overrides = [f"models.0.file={file}", "pressure.steps.all=[60.0e3, 120.0e3]"]
        nominals = (f"nominal.creep={nominal}" for nominal in ("false", "true"))
        stations = [make_private_station(load_scenario(name, [*overrides, nominal])) for nominal in nominals]
    plain, creeping = np.array([[_speeds(station) for station in stations] for _ in range(REPEATS)]).T.swapaxes(0, 1)
    holds = bool(np.median(plain[0] / creeping[0]) <= CREEP_BAR)
    _print_rows(f"{name}, fingers that creep", plain / creeping, f"{'at most' if holds else 'MISSES'} {CREEP_BAR:g}")
    return holds


def _run(diagram: Diagram, station: Station) -> Array:
    """CPU time of a sample in a run of the station's scenario, with its share of the recording, (2,) ms.

    The first is without reading signals, the second with reading all of them; the plant alone has none.
    """
    simulator, scenario = start(diagram, station), station.scenario
    run, reading = cpu_time(lambda: simulator.AdvanceTo(scenario.duration)), 0.0
    if diagram is station.diagram:
        recordings: list[Recording] = []
        run += cpu_time(lambda: recordings.append(station.recording(simulator.get_context())))
        reading = cpu_time(lambda: read_all(recordings[0]))
    return 1e3 * np.array([run, run + reading]) * scenario.sensor.period / scenario.duration


def start(diagram: Diagram, station: Station) -> Simulator:
    """Starts a simulator of a diagram with the solver of the station."""
    simulator = Simulator(diagram)
    ApplySimulatorConfig(solver_config(station.scenario), simulator)
    simulator.Initialize()
    return simulator


def measure_blocks(station: Station) -> dict[str, float]:
    """CPU time of a sample by class of the Python blocks, all fingers together, and of the logs, ms."""
    simulator = start(station.diagram, station)
    root = simulator.get_context()
    blocks = list(_python_blocks(station.diagram))
    logs = station.logs.GetMyContextFromRoot(root)
    seconds: dict[str, float] = defaultdict(float)
    for sample in range(SAMPLES):
        simulator.AdvanceTo((sample + 0.5) * station.scenario.sensor.period)
        for block in blocks:
            seconds[type(block).__name__] += _sample_time(block, block.GetMyContextFromRoot(root))
        seconds["SignalLogs"] += cpu_time(lambda: station.logs.ForcedPublish(logs))
    return {name: 1e3 * total / SAMPLES for name, total in seconds.items()}


def _python_blocks(diagram: Diagram) -> Iterator[System]:
    """Yields all blocks of this project, in the order of data flow."""
    for system in diagram.GetSystems():
        if isinstance(system, Diagram):
            yield from _python_blocks(system)
        elif type(system).__module__.startswith("soft_gripper"):
            yield system


def _sample_time(block: System, context: Context) -> float:
    """CPU time of one sample of a block, s."""
    outputs = [block.get_output_port(i) for i in range(block.num_output_ports())]
    for i in range(block.num_input_ports()):
        block.get_input_port(i).Eval(context)
    seconds = 0.0
    if block.GetUniquePeriodicDiscreteUpdateAttribute() is not None:  # not all that have discrete states take samples
        seconds += cpu_time(lambda: block.EvalUniquePeriodicDiscreteUpdate(context))
    first_time, second_time = (cpu_time(lambda: [port.Eval(context) for port in outputs]) for _ in range(2))
    return seconds + first_time - second_time


def _print_rows(name: str, values: Array, bar: str) -> None:
    """Prints a row without reading, which has a bar, and one with all signals read."""
    for label, row, judged in zip((name, "  all read"), values, (bar, ""), strict=False):
        _print_row(label, row, judged)


def _print_row(name: str, values: Array, bar: str = "") -> None:
    middle, low, high = np.median(values), values.min(), values.max()
    digits = 1 if middle >= 1 else 3
    print(f"{name:<28} {middle:>8.{digits}f} {low:>6.{digits}f} {high:>6.{digits}f}   {bar}")
