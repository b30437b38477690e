"""Fingertips at rest in Drake and, exported, in MuJoCo: the largest difference after each step of pressure; and speed.

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
    """A scenario, and how far apart its tips may be."""

    scenario: str
    overrides: tuple[str, ...]
    bar: float  # m


FREE, GRASP = 0.5e-3, 1.5e-3  # m
CASES = {
    "free bending": Case("free_bending", (), FREE),
    "free bending in space": Case(
        "free_bending",
        (
            "pressure.steps.all=[60e3, 150e3]",
            "gravity=[2.0, 7.0, -6.0]",
            *(f"models.{side}_finger.{IN_SPACE}" for side in ("left", "right")),
        ),
        FREE,
    ),
    "three chambers": Case("three_chambers", (), FREE),
    "box grasp": Case("box_grasp", ("pressure.steps.all=[50e3, 100e3, 150e3]",), GRASP),
    "turned box, in space": Case("turned_box_grasp", ("pressure.steps.all=[50e3, 100e3]",), GRASP),
    "mesh grasp": Case("irregular_grasp", ("pressure.steps.all=[50e3, 100e3, 150e3]",), GRASP),
    "bottle grasp": Case("bottle_grasp", (), GRASP),
}


def run(options: argparse.Namespace) -> int:
    """Prints a table; 1 if a bar is missed."""
    missed = False
    for name, case in CASES.items():
        scenario = load_scenario(case.scenario, [*case.overrides, "record.truth=none"])
        apart = differences(scenario, options.time_step).max(axis=-1)
        missed |= bool(apart.max() > case.bar)
        steps = ", ".join(f"{1e3 * each:.4g}" for each in apart)
        verdict = f"{'MISSES ' if apart.max() > case.bar else ''}bar {1e3 * case.bar:g} mm"
        print(f"{name:<24} {speed(scenario, options.time_step):5.0f}x {steps} mm; {verdict}", flush=True)
    return int(missed)


def differences(scenario: Scenario, time_step: float | None = None) -> Array:
    """Distances of the tips at the end of each step, (steps, F) m; of a task, at its end."""
    with TemporaryDirectory() as folder:
        tips = in_mujoco(scenario, Path(folder), time_step)
    distances: Array = np.linalg.norm(tips - in_drake(scenario), axis=-1)
    return distances


def speed(scenario: Scenario, time_step: float | None = None) -> float:
    """How many times as fast as real time the loader runs in MuJoCo."""
    with TemporaryDirectory() as folder:
        export_mjcf(scenario, Path(folder), time_step)
        start = process_time()
        _, rows = simulate(Path(folder))
    return float(rows[-1, 0] / (process_time() - start))


def ends_of(scenario: Scenario, last: float) -> Array:
    """When each step of pressure ends, s; of a task, its end, which `last` is."""
    return np.array([last]) if scenario.task else (np.arange(scenario.steps) + 1) * scenario.step_duration


def in_drake(scenario: Scenario) -> Array:
    """The tips at the end of each step, (steps, F, 3) m in the world."""
    station = make_private_station(scenario)
    recording = run_station(station)
    times, states = recording["time"].values, recording["plant.state"].values
    plant, context = station.plant, station.plant.CreateDefaultContext()
    found = []
    for row in np.searchsorted(times, ends_of(scenario, times[-1]) - 1e-6):
        plant.SetPositionsAndVelocities(context, states[row])
        found.append([finger.frames[-1].CalcPoseInWorld(context).translation() for finger in station.fingers])
    return np.array(found)


def in_mujoco(scenario: Scenario, folder: Path, time_step: float | None) -> Array:
    """The same, by the loader that is exported, in a process without this package."""
    export_mjcf(scenario, folder, time_step)
    subprocess.run([sys.executable, "-I", folder / LOADER], check=True, cwd=folder, capture_output=True)
    with (folder / "tips.csv").open(newline="") as file:
        fingers = sum(" tip x " in name for name in next(csv.reader(file)))
        rows = np.array(list(csv.reader(file)), dtype=float)
    at_ends = rows[np.searchsorted(rows[:, 0], ends_of(scenario, rows[-1, 0]) - 1e-6)]
    tips: Array = at_ends[:, 1 : 1 + 3 * fingers].reshape(-1, fingers, 3)
    return tips
