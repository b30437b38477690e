"""What the arm and the task of a scenario must be, before anything is built from them."""

import math
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from soft_gripper.diagrams.schema.ranges import not_negative, positive, require
from soft_gripper.diagrams.schema.scenario import ArmConfig, PhaseConfig, Scenario, TaskConfig, TrialsConfig
from soft_gripper.names import NAME_RULE, is_name

_GOALS = (None, "object", "goal", "home")
_ENDS = ("opened", "grasped", "released")


def check_task(where: Path | str, scenario: Scenario) -> None:
    """Compares the values of the arm and of the task with what they may be.

    Raises:
        InputError: for the first value that is wrong.
    """
    if scenario.arm is not None:
        _check_arm(where, scenario.arm, [model.name for model in scenario.models])
    task = scenario.task
    if task is None:
        return
    require(scenario.arm is not None, where, "arm", None, "a task moves an arm: give arm: { model, home }")
    require(bool(task.phases), where, "task.phases", [], "give at least one phase")
    for name in ("grip_threshold", "quiet_band", "timeout", "time_limit"):
        value = getattr(task, name)
        require(positive(value), where, f"task.{name}", value, "give a finite number above 0")
    lasting = task.time_limit > scenario.sensor.period
    require(lasting, where, "task.time_limit", task.time_limit, "give more than a sensor period, s")
    force = task.force_limit
    require(force is None or positive(force), where, "task.force_limit", force, "give a force above 0, N, or null")
    free = [model.name for model in scenario.models if model.free]
    handled = task.object or any(phase.holds or phase.to in ("object", "goal") for phase in task.phases)
    known = not handled or task.object in free
    require(
        known, where, "task.object", task.object, f"give one of the free models: {', '.join(free) or 'there is none'}"
    )
    for name in ("X_OG", "X_WGoal"):
        matrix = getattr(task, name).GetDeterministicValue().GetAsMatrix34()
        require(bool(np.isfinite(matrix).all()), where, f"task.{name}", getattr(task, name), "give finite numbers")
    for name, unit in (("x", "m"), ("y", "m"), ("yaw", "rad")):
        value = getattr(task.pose_error, name)
        require(math.isfinite(value), where, f"task.pose_error.{name}", value, f"give a finite number, {unit}")
    _check_trials(where, task.trials)
    for i, phase in enumerate(task.phases):
        _check_phase(where, f"task.phases[{i}]", phase)
    _check_grip(where, scenario, task)


def _check_trials(where: Path | str, trials: TrialsConfig) -> None:
    """What random trials may vary."""
    for name in ("offset", "yaw", "offset_error", "yaw_error"):
        value = getattr(trials, name)
        require(not_negative(value), where, f"task.trials.{name}", value, "give a finite number, 0 or more")
    require(0 <= trials.size < 1, where, "task.trials.size", trials.size, "give 0 up to, not including, 1")
    for name, least in (("mass", 1e-9), ("friction", 0.0)):
        span = getattr(trials, name)
        fine = len(span) == 2 and least <= span[0] <= span[1] < math.inf
        require(fine, where, f"task.trials.{name}", span, "give the least and the greatest value")


def _check_grip(where: Path | str, scenario: Scenario, task: TaskConfig) -> None:
    """What a task must say if it commands the gripper, or waits for it."""
    for i, phase in enumerate(task.phases):
        asks = "until" if phase.until is not None else "holds" if phase.holds else None
        fits, value = asks is None or task.grips, phase.until or phase.holds
        require(fits, where, f"task.phases[{i}].{asks}", value, "the gripper is not commanded: no phase has an opening")
    if not task.grips:
        return
    first = task.phases[0].opening
    require(first is not None, where, "task.phases[0].opening", first, "give the opening that the task begins with, m")
    set_points = scenario.control.set_points
    require(set_points is None, where, "control.set_points", set_points, "leave them out: the phases give openings")
    gain = scenario.control.gains.ki
    require(gain > 0, where, "control.gains.ki", gain, "give gains to the grip; `soft-gripper tune` finds them")
    limit = scenario.control.torque_limit
    counts = limit is None or limit > task.grip_threshold
    expected = f"give more than task.grip_threshold, {task.grip_threshold:g} N m: nothing else would count as a grip"
    require(counts, where, "control.torque_limit", limit, expected)


def _check_arm(where: Path | str, arm: ArmConfig, names: Sequence[str]) -> None:
    require(arm.model in names, where, "arm.model", arm.model, f"give one of the models: {', '.join(names)}")
    require(all(map(math.isfinite, arm.home)), where, "arm.home", arm.home, "give finite numbers, rad or m")
    for name in ("frequency", "damping_ratio", "acceleration"):
        value = getattr(arm, name)
        require(positive(value), where, f"arm.{name}", value, "give a finite number above 0")


def _check_phase(where: Path | str, field: str, phase: PhaseConfig) -> None:
    require(is_name(phase.name), where, f"{field}.name", phase.name, NAME_RULE)
    require(phase.to in _GOALS, where, f"{field}.to", phase.to, 'give "object", "goal" or "home", or leave it out')
    ended = phase.until is None or phase.until in _ENDS
    require(ended, where, f"{field}.until", phase.until, f"give one of {', '.join(_ENDS)}, or leave it out")
    both = phase.to is not None and phase.posture is not None
    require(not both, where, f"{field}.posture", phase.posture, f"leave it out beside to: {phase.to}")
    finite = phase.posture is None or all(map(math.isfinite, phase.posture))
    require(finite, where, f"{field}.posture", phase.posture, "give finite numbers, one a joint of the arm")
    require(math.isfinite(phase.height), where, f"{field}.height", phase.height, "give a height in m")
    require(0 < phase.speed <= 1, where, f"{field}.speed", phase.speed, "give a part of the arm's limits, above 0 to 1")
    require(not_negative(phase.rest), where, f"{field}.rest", phase.rest, "give a finite number, 0 or more")
    opening = phase.opening
    require(opening is None or positive(opening), where, f"{field}.opening", opening, "give an opening above 0 m")
