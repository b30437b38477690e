"""Runs every setting of every simulator in every task, alternately; and finds those that match ours."""

from collections.abc import Iterable
from typing import Any, NamedTuple

import numpy as np

from soft_gripper.arrays import Array
from studies.peers.measures import creep, holds, tip_error
from studies.peers.simulators import OURS, find_simulator
from studies.peers.task import Run, Setting, Task, Trial, load_task

SLACK = 1.1  # times as large as ours an error, or a creep, may be that counts as equal


class Result(NamedTuple):
    """One setting of a simulator in a task."""

    task: str
    simulator: str
    setting: Setting
    seconds: Array  # (rounds,) of CPU time for a simulated second
    error: float  # m, of the fingertips
    creep: float  # m/s; NaN where nothing is held
    holds: bool

    @property
    def speed(self) -> float:
        """Times faster than real time, median."""
        return 1 / float(np.median(self.seconds))

    @property
    def quality(self) -> float:
        """The quantity that has to match: the creep of the held object, or the error of the tips."""
        return self.error if np.isnan(self.creep) else self.creep

    def matches(self, other: "Result") -> bool:
        """Whether it is as good as another one."""
        return self.holds and self.quality <= SLACK * other.quality

    def times_behind(self, other: "Result") -> float:
        """How many times as long as another one it takes; median over the alternating rounds."""
        return float(np.median(self.seconds / other.seconds))


def installed(names: Iterable[str]) -> list[str]:
    """The installed simulators; prints which are missing."""
    found = []
    for name in names:
        try:
            find_simulator(name)
        except ModuleNotFoundError as error:
            print(f"{name} is left out: {error}; pip install -c constraints.txt -e .[peers]")
        else:
            found.append(name)
    return found


def compare(name: str, config: dict[str, Any], simulators: Iterable[str], rounds: int) -> list[Result]:
    """All results of a task, ours with its default first."""
    runs: list[tuple[str, Setting, Run]] = []
    references: dict[str, Trial] = {}
    for simulator in simulators:
        tried = config["simulators"][simulator].get(name)
        if tried is not None:
            references[simulator] = _make(simulator, name, config, tried["reference"])()
            runs += [(simulator, setting, _make(simulator, name, config, setting)) for setting in tried["settings"]]
    task = load_task(config["tasks"][name])
    turns = [[run() for _, _, run in runs] for _ in range(rounds)]
    seconds = np.array([[trial.seconds for trial in turn] for turn in turns]).T / task.scenario.duration
    return [
        _result(task, name, simulator, setting, trial, references[simulator], cost)
        for (simulator, setting, _), trial, cost in zip(runs, turns[0], seconds, strict=True)
    ]


def _make(simulator: str, name: str, config: dict[str, Any], setting: Setting) -> Run:
    return find_simulator(simulator)(load_task(config["tasks"][name]), setting)


def _result(
    task: Task, name: str, simulator: str, setting: Setting, trial: Trial, reference: Trial, seconds: Array
) -> Result:
    error = tip_error(task, trial, reference)
    return Result(name, simulator, setting, seconds, error, creep(task, trial), holds(task, trial))


def chosen(results: list[Result]) -> list[Result]:
    """Of every simulator the fastest result that matches ours, or the best one if none does; first our default."""
    ours = results[0]
    picked = [ours]
    for simulator in dict.fromkeys(result.simulator for result in results if result.simulator != OURS):
        own = [result for result in results if result.simulator == simulator]
        matching = [result for result in own if result.matches(ours)]
        picked.append(max(matching, key=lambda r: r.speed) if matching else min(own, key=_badness))
    return picked


def ours_as_good(results: list[Result], other: Result) -> Result | None:
    """Our fastest result that matches that of another simulator; None if none of our settings does."""
    matching = [result for result in results if result.simulator == OURS and result.matches(other)]
    return max(matching, key=lambda result: result.speed, default=None)


def _badness(result: Result) -> tuple[bool, float]:
    return not result.holds, result.quality
