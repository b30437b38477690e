"""Measures the cost of many runs: runs per second against processes, overhead of a run, and memory over RUNS.

Prints a table, and draws docs/many_runs.png and .svg. Runs are of free bending for 0.3 s, in sweeps whose station is
used again (another seed of the sensors), or built anew for each (another modulus of the fingers).
"""

import argparse
import os
import time
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure
from processes import family

from soft_gripper import load_scenario, run_station
from soft_gripper.diagrams.station import make_private_station
from soft_gripper.extras.sweeps import Range, Values, open_executor, run_sweep, sweep_points
from soft_gripper.pictures.style import STYLE, estimator_style, save_figure
from studies import ROOT

FIGURE = ROOT / "docs" / "many_runs"
FIXED = {
    "pressure.steps.all": [0, 60e3],
    "pressure.settle": 0.1,
    "pressure.hold_samples": 5,
    "sensor.errors.preset": "realistic",
}
RUNS, TIMED_RUNS, ROUNDS = 1000, 100, 3
KINDS = ("station used again", "station built anew")


@dataclass(frozen=True)
class Swept:
    """Duration of a sweep, s, and memory of its main process and its largest worker at the end of each run, MB."""

    seconds: float
    resident: np.ndarray  # (runs, 2)


def run(options: argparse.Namespace) -> None:
    """Prints the table and draws the figure."""
    jobs = list(range(1, (os.cpu_count() or 1) + 1))
    single_times, times = time_alternately(jobs)
    rates = {kind: [1 / times[kind, n] for n in jobs] for kind in KINDS}
    long = {kind: sweep(kind, RUNS, jobs[-1]) for kind in KINDS}
    print(
        "| | "
        + " | ".join(f"runs/s, {n} processes" for n in jobs)
        + " | beyond the simulation [ms] | memory, run 50 and last [MB] |"
    )
    print("|---|" + "---:|" * (len(jobs) + 2))
    for kind in KINDS:
        cells = [f"{rate:.1f}" for rate in rates[kind]]
        overhead, memory = 1e3 * (times[kind, 1] - single_times), long[kind].resident[:, 1]
        print(f"| {kind} | {' | '.join(cells)} | {overhead:.0f} | {memory[50]:.0f}, {memory[-1]:.0f} |")
    draw(jobs, rates, long)


def time_alternately(jobs: list[int]) -> tuple[float, dict[tuple[str, int], float]]:
    """Time of a run in an existing station, and of a run of a sweep by its kind and its processes, s.

    The shortest of the rounds counts, since other load and a slower clock only add to it.
    """
    station = make_private_station(load_scenario("free_bending", [f"{key}={value}" for key, value in FIXED.items()]))
    single_times: list[float] = []
    times: dict[tuple[str, int], list[float]] = {(kind, n): [] for kind in KINDS for n in jobs}
    for _ in range(ROUNDS):
        begin = time.perf_counter()
        for _ in range(TIMED_RUNS):
            run_station(station)
        single_times.append((time.perf_counter() - begin) / TIMED_RUNS)
        for (kind, n), kind_times in times.items():
            kind_times.append(sweep(kind, TIMED_RUNS, n).seconds / TIMED_RUNS)
    return min(single_times), {key: min(kind_times) for key, kind_times in times.items()}


def sweep(kind: str, runs: int, jobs: int) -> Swept:
    """Makes a number of runs by a number of processes, after the first two of each, which import everything."""
    is_reused = kind == KINDS[0]
    axis = (
        Values("sensor.seed", tuple(range(runs)))
        if is_reused
        else Range("models.0.fingers.all.youngs_modulus", 2e5, 3e5)
    )
    points = sweep_points([axis]) if is_reused else sweep_points([axis], "latin", runs)
    resident = []
    with TemporaryDirectory() as folder, open_executor(jobs) as executor:
        run_sweep("free_bending", points[: 2 * jobs], Path(folder) / "first", executor, fixed=FIXED)
        begin = time.perf_counter()

        def report(_: bool) -> None:
            main_process, *workers = sorted(family(os.getpid()), key=lambda process: process.pid != os.getpid())
            resident.append([main_process.resident(), max(worker.resident() for worker in workers)])

        run_sweep("free_bending", points, Path(folder) / "all", executor, fixed=FIXED, report=report)
        return Swept(time.perf_counter() - begin, np.array(resident))


def draw(jobs: list[int], rates: dict[str, list[float]], long: dict[str, Swept]) -> None:
    """Draws runs per second, and memory."""
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(8, 2.8), layout="constrained")
        rate_axes, memory_axes = figure.subplots(1, 2)
        for place, kind in enumerate(KINDS):
            style = estimator_style(place + 1, kind)
            rate_axes.plot(jobs, rates[kind], **style)
            main_memory, worker_memory = long[kind].resident.T
            memory_axes.plot(worker_memory, color=style["color"])
            memory_axes.plot(main_memory, color=style["color"], ls=":")
        rate_axes.set(xlabel="processes", ylabel="runs a second", xticks=jobs)
        rate_axes.set_ylim(bottom=0)
        rate_axes.legend(frameon=False)
        memory_axes.set(xlabel="runs", ylabel="memory [MB], largest worker;\ndotted: what began it")
        memory_axes.set_ylim(0, 1.1 * max(sweep_result.resident.max() for sweep_result in long.values()))
        save_figure(figure, FIGURE)
