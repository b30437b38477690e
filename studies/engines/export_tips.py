"""Compares fingertips at rest in Drake and, exported, in MuJoCo: differences after each pressure step, and speed.

Speed is simulated time over CPU time. Needs MuJoCo: pip install soft-gripper[mujoco]. Exit code 1: a bar is missed.
"""

import argparse
import csv
import subprocess
import sys
from pathlib import Path
from tempfile import TemporaryDirectory
from time import process_time
from typing import NamedTuple

import numpy as np

from soft_gripper.arrays import Array
from soft_gripper.diagrams.simulation import run_station
from soft_gripper.diagrams.station import make_private_station
from soft_gripper.extras.export.folder import LOADER, export_mjcf
from soft_gripper.extras.export.run_mjcf import simulate
from soft_gripper.scenario.scenario_file import load_scenario
from soft_gripper.scenario.schema import Scenario

IN_SPACE = "fingers.all.yields=bending sideways twist"


class Case(NamedTuple):
    """A scenario and its largest allowed distance of the tips."""

    scenario: str
    overrides: tuple[str, ...]
    bar: float  # m


FREE_BAR, GRASP_BAR = 0.5e-3, 1.5e-3  # m
CASES = {
    "free bending": Case("free_bending", (), FREE_BAR),
    "free bending in space": Case(
        "free_bending",
        (
            "pressure.steps.all=[60e3, 150e3]",
            "gravity=[2.0, 7.0, -6.0]",
            *(f"models.{side}_finger.{IN_SPACE}" for side in ("left", "right")),
        ),
        FREE_BAR,
    ),
    "three chambers": Case("three_chambers", (), FREE_BAR),
    "box grasp": Case("box_grasp", ("pressure.steps.all=[50e3, 100e3, 150e3]",), GRASP_BAR),
    "turned box, in space": Case("turned_box_grasp", ("pressure.steps.all=[50e3, 100e3]",), GRASP_BAR),
    "mesh grasp": Case("irregular_grasp", ("pressure.steps.all=[50e3, 100e3, 150e3]",), GRASP_BAR),
    "bottle grasp": Case("bottle_grasp", (), GRASP_BAR),
}


def run(options: argparse.Namespace) -> int:
    """Prints a table; 1 if a bar is missed."""
    misses_bar = False
    for name, case in CASES.items():
        scenario = load_scenario(case.scenario, [*case.overrides, "record.truth=none"])
        distances = differences(scenario, options.time_step).max(axis=-1)
        misses_bar |= bool(distances.max() > case.bar)
        steps = ", ".join(f"{1e3 * distance:.4g}" for distance in distances)
        verdict = f"{'MISSES ' if distances.max() > case.bar else ''}bar {1e3 * case.bar:g} mm"
        print(f"{name:<24} {speed(scenario, options.time_step):5.0f}x {steps} mm; {verdict}", flush=True)
    return int(misses_bar)


def differences(scenario: Scenario, time_step: float | None = None) -> Array:
    """Distances of the tips at the end of each step, (steps, F) m; of a task, at its end."""
    with TemporaryDirectory() as folder:
        tips = mujoco_tips(scenario, Path(folder), time_step)
    return np.linalg.norm(tips - drake_tips(scenario), axis=-1)


def speed(scenario: Scenario, time_step: float | None = None) -> float:
    """Simulated over CPU time of the loader in MuJoCo."""
    with TemporaryDirectory() as folder:
        export_mjcf(scenario, Path(folder), time_step)
        start = process_time()
        _, rows = simulate(Path(folder))
    return float(rows[-1, 0] / (process_time() - start))


def step_ends(scenario: Scenario, last: float) -> Array:
    """Ends of the pressure steps, s; of a task, its end, `last`."""
    return np.array([last]) if scenario.task else (np.arange(scenario.steps) + 1) * scenario.step_duration


def drake_tips(scenario: Scenario) -> Array:
    """Tips at the end of each step in Drake, (steps, F, 3) m in the world."""
    station = make_private_station(scenario)
    recording = run_station(station)
    times, states = recording["time"].values, recording["plant.state"].values
    plant, context = station.plant, station.plant.CreateDefaultContext()
    tip_positions = []
    for row in np.searchsorted(times, step_ends(scenario, times[-1]) - 1e-6):
        plant.SetPositionsAndVelocities(context, states[row])
        tip_positions.append([finger.frames[-1].CalcPoseInWorld(context).translation() for finger in station.fingers])
    return np.array(tip_positions)


def mujoco_tips(scenario: Scenario, folder: Path, time_step: float | None) -> Array:
    """Tips at the end of each step, (steps, F, 3) m, by the exported loader, in a process without this package."""
    export_mjcf(scenario, folder, time_step)
    subprocess.run([sys.executable, "-I", folder / LOADER], check=True, cwd=folder, capture_output=True)
    with (folder / "tips.csv").open(newline="") as file:
        fingers = sum(" tip x " in name for name in next(csv.reader(file)))
        rows = np.array(list(csv.reader(file)), dtype=float)
    end_rows = rows[np.searchsorted(rows[:, 0], step_ends(scenario, rows[-1, 0]) - 1e-6)]
    return end_rows[:, 1 : 1 + 3 * fingers].reshape(-1, fingers, 3)
