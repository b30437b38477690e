"""Measures the cost of many box grasps in MuJoCo, and the variations that make it slower than Drake.

Sensors are realistic, the estimator is `gaussian`, and pose, mass and friction of the box are random: of boxes that
fingers hold, and of some that they do not. The tables of one process and of two are compared. With `--varied`, the same
sweep is made over friction, over the modulus of the fingers and over a pressure, and a search of designs; only runs
with one finger under one course of pressure share a station. Times are those of whole commands, the start included: of
the first by the clock of an idle machine, of the second CPU time of one process. With `--steps`, boxes
near the limit of friction are compared over the step of MuJoCo.
"""

import argparse
import csv
import subprocess
import sys
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Annotated

import numpy as np
import yaml
from processes import cpu_time_of

from soft_gripper.files.row_table import print_rows
from studies import ROOT

ENGINES = ("mujoco", "drake")
SAMPLES = {  # kg, friction
    "held": ((0.05, 0.15), (0.5, 1.0)),
    "near the limit": ((0.05, 0.3), (0.3, 1.0)),
}
FIXED = {
    "pressure.steps": "{all: [30e3, 60e3, 90e3, 120e3]}",
    "pressure.settle": 0.5,
    "pressure.hold_samples": 50,
    "sensor.errors.preset": "realistic",
    "estimator.type": "gaussian",
}
VARIED = {
    "friction": "models.box.friction=0.5..1.0",
    "Young's modulus": "models.gripper.fingers.all.youngs_modulus=-10..10 %",
    "a pressure": "pressure.steps.all.12=140e3..160e3",  # Pa, the last one
}
STEPS = (0.001, 0.005, 0.01)  # s, of MuJoCo
STUDY = ROOT / "examples/design/bottle.yaml"
SEARCH = {"designs": 12, "test_draws": 4, "unseen": {}}


@dataclass(frozen=True)
class SweepCost:
    """Cost of a sweep."""

    boxes: str
    runs: int
    processes: int
    ms_a_run: Annotated[float, ".0f"]
    seconds: Annotated[float, ".0f"]
    same_table: str


@dataclass(frozen=True)
class StepCost:
    """CPU time of the same runs with a step of MuJoCo, and their differences from the shortest step."""

    step_ms: Annotated[float, ".0f"]
    runs: int
    seconds: Annotated[float, ".1f"]
    same_outcomes: int
    median_force_change_n: Annotated[float, ".4f"]
    largest_force_change_n: Annotated[float, ".3f"]
    median_bend_change_deg: Annotated[float, ".3f"]


@dataclass(frozen=True)
class EngineCost:
    """CPU time of the same runs in both engines, s, and its ratio."""

    varied: str
    runs: int
    mujoco_s: Annotated[float, ".0f"]
    drake_s: Annotated[float, ".0f"]
    mujoco_s_a_run: Annotated[float, ".2f"]
    drake_s_a_run: Annotated[float, ".2f"]
    mujoco_over_drake: Annotated[float, ".2f"]


def run(options: argparse.Namespace) -> None:
    """Prints a table."""
    if options.steps:
        print_rows([*step_costs(options.runs or 60)])
        return
    print_rows([*(engine_costs(options.runs or 40) if options.varied else process_costs(options.runs or 1000))])


def process_costs(runs: int) -> Iterator[SweepCost]:
    """Yields rows of one process and of two."""
    for boxes in SAMPLES:
        with TemporaryDirectory() as folder:
            tables = [Path(folder) / str(jobs) for jobs in (1, 2)]
            times = [clock_time(boxes, runs, jobs, table) for jobs, table in enumerate(tables, start=1)]
            single_table, double_table = ((table / "sweep.csv").read_bytes() for table in tables)
            agreement = "yes" if single_table == double_table else "no"
            for jobs, seconds in enumerate(times, start=1):
                yield SweepCost(boxes, runs, jobs, 1e3 * seconds / runs, seconds, agreement)


def step_costs(runs: int) -> Iterator[StepCost]:
    """Yields a row for each step, of boxes near the limit."""
    first: list[dict[str, str]] = []
    for step in STEPS:
        with TemporaryDirectory() as folder:
            command = grasps("near the limit", runs, 1, Path(folder), f"--set=engine_step={step}")
            seconds = cpu_time_of(command)
            with (Path(folder) / "sweep.csv").open(newline="", encoding="utf-8") as table:
                rows = [*csv.DictReader(table)]
        first = first or rows
        force_changes, bend_changes = (
            [abs(float(row[name]) - float(of_first[name])) for row, of_first in zip(rows, first, strict=True)]
            for name in ("normal_force_n", "largest_bend_deg")
        )
        same_outcomes = sum(row["grasp"] == of_first["grasp"] for row, of_first in zip(rows, first, strict=True))
        force_change, bend_change = (float(np.median(changes)) for changes in (force_changes, bend_changes))
        yield StepCost(1e3 * step, runs, seconds, same_outcomes, force_change, max(force_changes), bend_change)


def clock_time(boxes: str, runs: int, jobs: int, out: Path) -> float:
    """Time of a sweep, s."""
    begin = time.perf_counter()
    subprocess.run(grasps(boxes, runs, jobs, out), check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    return time.perf_counter() - begin


def grasps(boxes: str, runs: int, jobs: int, out: Path, *more: str) -> list[str]:
    """Command of a sweep of boxes."""
    masses, frictions = SAMPLES[boxes]
    ranges = {"mass": masses, "friction": frictions, "X_PC.translation.0": (-0.004, 0.004)}
    axes = [f"models.box.{key}={low}..{high}" for key, (low, high) in ranges.items()]
    fixed_options = [f"--set={key}={value}" for key, value in FIXED.items()]
    return sweep("mujoco", axes, runs, jobs, out, "--seed", "7", *fixed_options, *more)


def engine_costs(runs: int) -> Iterator[EngineCost]:
    """Yields a row for each variation."""
    for name, axis in VARIED.items():
        with TemporaryDirectory() as folder:
            commands = [sweep(engine, [axis], runs, 1, Path(folder) / engine) for engine in ENGINES]
            yield engine_cost(name, runs, [*map(cpu_time_of, commands)])
    with TemporaryDirectory() as folder:
        study = Path(folder) / "study.yaml"
        study.write_text(yaml.safe_dump({**yaml.safe_load(STUDY.read_text(encoding="utf-8")), **SEARCH}))
        times = [cpu_time_of(search(engine, study)) for engine in ENGINES]
        with (study.parent / "drake" / "runs.csv").open(newline="", encoding="utf-8") as table:
            run_count = len([*csv.DictReader(table)])
    yield engine_cost("designs", run_count, times)


def engine_cost(varied: str, runs: int, times: Sequence[float]) -> EngineCost:
    """Row of runs with their CPU times in MuJoCo and in Drake, s."""
    mujoco, drake = times
    return EngineCost(varied, runs, mujoco, drake, mujoco / runs, drake / runs, mujoco / drake)


def sweep(engine: str, axes: Sequence[str], runs: int, jobs: int, out: Path, *more: str) -> list[str]:
    """Command of a sweep of box grasps."""
    options = [f"--vary={axis}" for axis in axes]
    return soft_gripper(
        *("sweep", "box_grasp", "--engine", engine, "--sample", runs, *options, *more), "--jobs", jobs, "--out", out
    )


def search(engine: str, study: Path) -> list[str]:
    """Command of a search of designs."""
    return soft_gripper("design", study, "--engine", engine, "--jobs", 1, "--out", study.parent / engine)


def soft_gripper(*words: object) -> list[str]:
    """A command of this environment."""
    return [str(Path(sys.executable).with_name("soft-gripper")), *map(str, words)]
