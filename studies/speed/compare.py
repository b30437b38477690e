"""Compares the speed of this checkout with that of another one.

The other one is a folder in which `make .venv/ready` was run. The checkouts take turns, each run in a process of its
own and timed by the checkout's own timed_run.py, or by this one if that reads no signals. For every part of a run the
mean of its two shortest times counts, which excludes as much as possible of the machine's other load. Each scenario has
two rows: with no signal of its recording read, and with all of them, in both checkouts.
"""

import argparse
import json
import subprocess
from collections.abc import Iterator, Mapping
from pathlib import Path

import numpy as np

from studies import ROOT

TIMED_RUN = "studies/speed/timed_run.py"
ROUNDS = 7
SCENARIOS = ("free_bending", "box_grasp", "irregular_grasp", "pick_and_place_box")
Times = dict[str, list[float]]  # s, by what is timed: the parts of a run, "closed" or "bare", and "read"
Runs = dict[tuple[str, str], list[list[float]]]  # times by checkout and what is timed


def run(options: argparse.Namespace) -> None:
    """Prints two lines per scenario."""
    print("scenario, signals read   faster  blocks  closed / bare, other  closed / bare, here")
    for name in options.scenarios or SCENARIOS:
        runs = run_in_turns(options.other, name)
        for signals, numbers in ratios({key: shortest(times) for key, times in runs.items()}):
            cells = zip(numbers, (6, 7, 21, 20), strict=True)
            print(f"{f'{name}, {signals}':<24}", *(f"{number:>{width}.2f}" for number, width in cells), flush=True)


def ratios(times: Mapping[tuple[str, str], float]) -> Iterator[tuple[str, tuple[float, ...]]]:
    """Which signals are read, and how many times as fast this checkout is, its blocks, and closed over bare in both."""
    bare = min((time for (_, timed), time in times.items() if timed == "bare"), default=np.nan)
    for signals in ("none", "all"):
        there, here = (
            times[checkout, "closed"] + (times[checkout, "read"] if signals == "all" else 0.0)
            for checkout in ("other", "here")
        )
        yield signals, (there / here, (here - bare) / (there - bare), there / bare, here / bare)


def run_in_turns(other: Path, scenario: str) -> Runs:
    """Runs of a scenario in both checkouts."""
    runs: Runs = {}
    for _ in range(ROUNDS):
        for checkout, folder in (("other", other), ("here", ROOT)):
            for timed, times in timed_run(folder.resolve(), scenario).items():
                runs.setdefault((checkout, timed), []).append(times)
    return runs


def timed_run(folder: Path, scenario: str) -> Times:
    """A run of a scenario in a checkout, with the time of reading its signals."""
    for script in filter(Path.is_file, (folder / TIMED_RUN, ROOT / TIMED_RUN)):
        command: list[Path | str] = [folder / ".venv/bin/python", script, scenario]
        times: Times = json.loads(subprocess.run(command, check=True, stdout=subprocess.PIPE, text=True).stdout)
        if "read" in times:
            return times
    raise AssertionError("this timed_run.py reads all signals")


def shortest(runs: list[list[float]]) -> float:
    """Computing time of a run, s, of the shortest times of its parts."""
    return float(np.sort(np.array(runs), axis=0)[:2].mean(axis=0).sum())
