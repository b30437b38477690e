"""Compares the speed of this checkout with that of another one.

The other one is a folder in which `make .venv/ready` was run. The checkouts take turns, each run in a process of its
own and timed by the checkout's own timed_run.py, or by this one if that reads no signals. For every part of a run the
mean of its two shortest times counts, which excludes as much as possible of the machine's other load. Each scenario has
two rows: with no signal of its recording read, and with all of them, in both checkouts. The start of Python, of
commands and of their refusals is timed likewise, by the computing time of the process.
"""

import argparse
import json
import resource
import subprocess
from collections.abc import Iterator, Mapping
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from studies import ROOT

TIMED_RUN = "studies/speed/timed_run.py"
ROUNDS = 7
SCENARIOS = ("free_bending", "box_grasp", "irregular_grasp", "pick_and_place_box")
COMMAND = "from soft_gripper.commands import main; main({})"
STARTS = {
    "import of simulate": "import soft_gripper; soft_gripper.simulate",
    "list": COMMAND.format(["list"]),
    "a refused value": COMMAND.format(["run", "free_bending", "--set", "pressure.settle=-1"]),
    "run free_bending": COMMAND.format(["run", "free_bending"]),
}
Times = dict[str, list[float]]  # s, by "closed" or "bare", the parts of a run, and "read"
Runs = dict[tuple[str, str], list[list[float]]]  # times by checkout and key of `Times`


def run(options: argparse.Namespace) -> None:
    """Prints two lines per scenario."""
    print("scenario, signals read   faster  blocks  closed / bare, other  closed / bare, here")
    for name in options.scenarios or SCENARIOS:
        runs = run_alternately(options.other, name)
        for signals, numbers in ratios({key: shortest(times) for key, times in runs.items()}):
            cells = zip(numbers, (6, 7, 21, 20), strict=True)
            print(f"{f'{name}, {signals}':<24}", *(f"{number:>{width}.2f}" for number, width in cells), flush=True)
    print("start                    faster  other [s]  here [s]")
    for name, script in STARTS.items():
        other_time, own_time = start_times(options.other, script)
        print(f"{name:<24} {other_time / own_time:>6.2f} {other_time:>10.2f} {own_time:>9.2f}", flush=True)


def start_times(checkout: Path, script: str) -> tuple[float, float]:
    """Median computing time of a script in both checkouts, s."""
    rounds = [[start_time(folder.resolve(), script) for folder in (checkout, ROOT)] for _ in range(ROUNDS)]
    other_time, own_time = np.median(rounds, axis=0)
    return float(other_time), float(own_time)


def start_time(folder: Path, script: str) -> float:
    """Computing time of a process that runs a script in a checkout, s."""
    begin = resource.getrusage(resource.RUSAGE_CHILDREN)
    with TemporaryDirectory() as results:
        command: list[Path | str] = [folder / ".venv/bin/python", "-c", script]
        subprocess.run(command, cwd=results, capture_output=True, check=True)
    end = resource.getrusage(resource.RUSAGE_CHILDREN)
    return end.ru_utime + end.ru_stime - begin.ru_utime - begin.ru_stime


def ratios(times: Mapping[tuple[str, str], float]) -> Iterator[tuple[str, tuple[float, ...]]]:
    """Yields the read signals, and the speed-up of this checkout and its blocks, and closed over bare in both."""
    bare = min((time for (_, timed), time in times.items() if timed == "bare"), default=np.nan)
    for signals in ("none", "all"):
        other_s, own_s = (
            times[checkout, "closed"] + (times[checkout, "read"] if signals == "all" else 0.0)
            for checkout in ("other", "here")
        )
        yield (signals, (other_s / own_s, (own_s - bare) / (other_s - bare), other_s / bare, own_s / bare))


def run_alternately(other: Path, scenario: str) -> Runs:
    """Runs a scenario in both checkouts in turn."""
    runs: Runs = {}
    for _ in range(ROUNDS):
        for checkout, folder in (("other", other), ("here", ROOT)):
            for timed, times in timed_run(folder.resolve(), scenario).items():
                runs.setdefault((checkout, timed), []).append(times)
    return runs


def timed_run(folder: Path, scenario: str) -> Times:
    """Times a run of a scenario in a checkout, and the reading of its signals."""
    for script in filter(Path.is_file, (folder / TIMED_RUN, ROOT / TIMED_RUN)):
        command: list[Path | str] = [folder / ".venv/bin/python", script, scenario]
        times: Times = json.loads(subprocess.run(command, check=True, stdout=subprocess.PIPE, text=True).stdout)
        if "read" in times:
            return times
    raise AssertionError("this timed_run.py reads all signals")


def shortest(runs: list[list[float]]) -> float:
    """Computing time of a run, s, of the shortest times of its parts."""
    return float(np.sort(np.array(runs), axis=0)[:2].mean(axis=0).sum())
