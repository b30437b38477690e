"""Runs every setting of every simulator in every task, alternately, and finds those that match ours."""

from collections.abc import Iterable
from typing import Any, NamedTuple

import numpy as np

from soft_gripper.arrays import Array
from studies.peers.simulators import OURS, find_simulator
from studies.peers.task import PeerTask, PeerTrial, Run, Setting, load_task

MOVING_TIME, SETTLED_TIME = 0.5, 1.0  # s, after every step of pressure and before the next
CREEP_TIME = 2.0  # s, at the end
EQUAL_FACTOR = 1.1  # ratio to our error or creep up to which another counts as equal


class Result(NamedTuple):
    """One setting of a simulator in a task."""

    task: str
    simulator: str
    setting: Setting
    seconds: Array  # (rounds,) of CPU time for a simulated second
    error: float  # m, of the fingertips
    creep: float  # m/s; NaN where nothing is held
    holds: bool  # the run is finite, and the object is still grasped

    @property
    def speed(self) -> float:
        """Times faster than real time, median."""
        return 1 / float(np.median(self.seconds))

    @property
    def quality(self) -> float:
        """Quantity that has to match: the creep of the grasped object, or the error of the tips."""
        return self.error if np.isnan(self.creep) else self.creep

    def matches(self, other: "Result") -> bool:
        """Whether it is as good as another one."""
        return self.holds and self.quality <= EQUAL_FACTOR * other.quality

    def times_behind(self, other: "Result") -> float:
        """Ratio of its time to the other result's; median over the alternating rounds."""
        return float(np.median(self.seconds / other.seconds))


def installed_simulators(names: Iterable[str]) -> list[str]:
    """The installed_simulators simulators; prints which are missing."""
    installed = []
    for name in names:
        try:
            find_simulator(name)
        except ModuleNotFoundError as error:
            print(f"{name} is left out: {error}; pip install -c constraints.txt -e .[peers]")
        else:
            installed.append(name)
    return installed


def compare(name: str, config: dict[str, Any], simulators: Iterable[str], rounds: int) -> list[Result]:
    """Runs a task in all simulators; our default result comes first."""
    runs: list[tuple[str, Setting, Run]] = []
    references: dict[str, PeerTrial] = {}
    for simulator in simulators:
        settings = config["simulators"][simulator].get(name)
        if settings is not None:
            references[simulator] = _make(simulator, name, config, settings["reference"])()
            runs += [(simulator, setting, _make(simulator, name, config, setting)) for setting in settings["settings"]]
    task = load_task(config["tasks"][name])
    rounds_ = [[run() for _, _, run in runs] for _ in range(rounds)]
    costs = np.array([[trial.seconds for trial in turn] for turn in rounds_]).T / task.scenario.duration
    results = []
    for (simulator, setting, _), trial, cost in zip(runs, rounds_[0], costs, strict=True):
        error = tip_error(task, trial, references[simulator])
        results.append(Result(name, simulator, setting, cost, error, creep(task, trial), holds(task, trial)))
    return results


def _make(simulator: str, name: str, config: dict[str, Any], setting: Setting) -> Run:
    return find_simulator(simulator)(load_task(config["tasks"][name]), setting)


def chosen_results(results: list[Result]) -> list[Result]:
    """Our default, then of every simulator the fastest result that matches it, or the best one if none does."""
    own_result = results[0]
    selection = [own_result]
    for simulator in dict.fromkeys(result.simulator for result in results if result.simulator != OURS):
        simulator_results = [result for result in results if result.simulator == simulator]
        matching = [result for result in simulator_results if result.matches(own_result)]
        closest = min(simulator_results, key=lambda result: (not result.holds, result.quality))
        selection.append(max(matching, key=lambda result: result.speed) if matching else closest)
    return selection


def equal_setting(results: list[Result], other: Result) -> Result | None:
    """Our fastest result that matches another simulator's result; None if no setting of ours does."""
    matching = [result for result in results if result.simulator == OURS and result.matches(other)]
    return max(matching, key=lambda result: result.speed, default=None)


def tip_error(task: PeerTask, trial: PeerTrial, reference: PeerTrial) -> float:
    """The larger one of two errors, m: root mean square of the moving and worst mean of the settled tips.

    If something is grasped, only the settled part of the last step counts: where the object comes to
    rest before that differs from run to run.
    """
    step_samples = round(task.scenario.step_duration / task.period)
    difference = (trial.tips - reference.tips).reshape(-1, step_samples, trial.tips.shape[1])
    moving_count, settled_count = (round(seconds / task.period) for seconds in (MOVING_TIME, SETTLED_TIME))
    settled_errors = np.abs(difference[:, -settled_count:].mean(axis=1))
    if task.grasped_body is not None:
        return float(settled_errors[-1].max())
    return float(max(np.sqrt((np.abs(difference[:, :moving_count]) ** 2).mean()), settled_errors.max()))


def creep(task: PeerTask, trial: PeerTrial) -> float:
    """Final speed of the held object, m/s; NaN without an object."""
    if task.grasped_body is None:
        return float("nan")
    samples = round(CREEP_TIME / task.period)
    return float(np.linalg.norm(trial.held[-1] - trial.held[-1 - samples]) / CREEP_TIME)


def holds(task: PeerTask, trial: PeerTrial, reach: float = 0.01) -> bool:
    """Whether the run did not diverge and the object is within `reach` m of its initial position."""
    if not np.isfinite(trial.tips).all() or np.abs(trial.tips).max() > 2 * task.fingers[0].length:
        return False
    if task.grasped_body is None:
        return True
    return bool(np.linalg.norm(trial.held - task.grasped_body.X_WB.translation(), axis=-1).max() < reach)
