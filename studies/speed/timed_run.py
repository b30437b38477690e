"""CPU times of a run and of reading its signals, printed as JSON: `python timed_run.py SCENARIO`; see compare.py."""

import os

os.environ["OMP_NUM_THREADS"] = os.environ["OPENBLAS_NUM_THREADS"] = "1"

import json
import sys
from collections.abc import Callable
from time import process_time

import numpy as np
from pydrake.systems.analysis import ApplySimulatorConfig, Simulator
from pydrake.systems.framework import Diagram, DiagramBuilder

from soft_gripper.diagrams.recording import Recording
from soft_gripper.diagrams.scene import add_plant
from soft_gripper.diagrams.simulation import make_simulator, solver_config
from soft_gripper.diagrams.station import make_private_station
from soft_gripper.diagrams.wiring.drive import add_pressure_drive, add_steps
from soft_gripper.scenario.scenario_file import load_scenario
from soft_gripper.scenario.schema import Scenario

PART = 0.25  # s
TASK_TIME = 8.0  # s; every task of the scenarios handles its object until then


def main(name: str) -> None:
    """Times the closed diagram and every signal of its recording; without a task, the bare plant with its drive too."""
    scenario = load_scenario(name)
    station = make_private_station(scenario)
    simulator = make_simulator(station)
    recordings: list[Recording] = []

    def record() -> None:
        recordings.append(station.recording(simulator.get_context()))

    times = {"closed": part_times(simulator, scenario, record)}
    first_recording, full_recording = recordings
    read_all(first_recording)  # a single sample: imports what the reading of all takes
    times["read"] = [cpu_time(lambda: read_all(full_recording))]
    if scenario.task is None:
        plant_simulator = Simulator(bare_diagram(scenario))
        ApplySimulatorConfig(solver_config(scenario), plant_simulator)
        times["bare"] = part_times(plant_simulator, scenario, lambda: None)
    print(json.dumps(times))


def bare_diagram(scenario: Scenario) -> Diagram:
    """Diagram of the plant and its drive."""
    builder = DiagramBuilder()
    scene = add_plant(builder, scenario, visuals=False)
    drive = add_pressure_drive(builder, scene.fingers, scenario.pressure)
    add_steps(builder, "pressure", scenario.pressure.steps, scenario.step_duration, drive.pressure_commands)
    return builder.Build()


def part_times(simulator: Simulator, scenario: Scenario, finish: Callable[[], object]) -> list[float]:
    """CPU time of every part of a run, and finally of its completion, s; without the imports for that."""
    simulator.Initialize()
    finish()
    end = TASK_TIME if scenario.task is not None else scenario.duration
    actions = [*(lambda time=time: simulator.AdvanceTo(time) for time in np.arange(PART, end + 1e-9, PART)), finish]
    return [cpu_time(action) for action in actions]


def read_all(recording: Recording) -> None:
    """Computes every signal of a recording."""
    recording.data.load()


def cpu_time(action: Callable[[], object]) -> float:
    """CPU time that an action takes, s."""
    start = process_time()
    action()
    return process_time() - start


if __name__ == "__main__":
    main(sys.argv[1])
