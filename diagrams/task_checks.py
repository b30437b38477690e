"""What the arm and the task of a scenario must be, before anything is built from them."""

import math
from pathlib import Path

import numpy as np

from soft_gripper.diagrams.ranges import not_negative, positive, require
from soft_gripper.diagrams.scenario import PhaseConfig, Scenario

_GOALS = ("", "object", "goal", "home")
_ENDS = ("", "grasped", "released")


def check_task(where: Path | str, scenario: Scenario) -> None:
    """Holds the values of the arm and of the task against what they may be.

    Raises:
        InputError: for the first value that is wrong.
    """
    _check_arm(where, scenario)
    task = scenario.task
    if not task.phases:
        return
    require(bool(scenario.arm.model), where, "arm.model", "", "a task needs an arm; name it among the models")
    set_points = scenario.control.set_points
    require(not set_points, where, "control.set_points", set_points, "leave them out: the phases of the task give them")
    for name in ("grip_threshold", "timeout", "time_limit"):
        value = getattr(task, name)
        require(positive(value), where, f"task.{name}", value, "give a finite number above 0")
    lasting = task.time_limit > scenario.sensor.period
    require(lasting, where, "task.time_limit", task.time_limit, "give more than a sensor period, s")
    require(not_negative(task.force_limit), where, "task.force_limit", task.force_limit, "give 0 or more, N")
    gain = scenario.control.gains.ki
    require(gain > 0, where, "control.gains.ki", gain, "give gains to the grip; `soft-gripper tune` finds them")
    limit = scenario.control.torque_limit
    felt = f"give 0, or more than task.grip_threshold, {task.grip_threshold:g} N m: nothing else would count as a grip"
    require(limit == 0 or limit > task.grip_threshold, where, "control.torque_limit", limit, felt)
    free = [model.name for model in scenario.models if model.free]
    handled = task.object or any(phase.holds or phase.to in ("object", "goal") for phase in task.phases)
    known = not handled or task.object in free
    require(
        known, where, "task.object", task.object, f"give one of the free models: {', '.join(free) or 'there is none'}"
    )
    for name in ("X_OG", "X_WGoal"):
        matrix = getattr(task, name).GetDeterministicValue().GetAsMatrix34()
        require(bool(np.isfinite(matrix).all()), where, f"task.{name}", getattr(task, name), "give finite numbers")
    require(task.phases[0].distance > 0, where, "task.phases[0].distance", task.phases[0].distance, _BEGIN)
    for i, phase in enumerate(task.phases):
        _check_phase(where, f"task.phases[{i}]", phase)


_BEGIN = "give the distance between the fingertips that the task begins with, m"


def _check_arm(where: Path | str, scenario: Scenario) -> None:
    arm = scenario.arm
    names = [model.name for model in scenario.models]
    known = f"give one of the models: {', '.join(names)}"
    require(not arm.model or arm.model in names, where, "arm.model", arm.model, known)
    require(bool(arm.model) or not arm.home, where, "arm.model", "", "name the arm that begins in arm.home")
    require(all(map(math.isfinite, arm.home)), where, "arm.home", arm.home, "give finite numbers, rad or m")
    for name in ("frequency", "damping_ratio", "acceleration"):
        value = getattr(arm, name)
        require(positive(value), where, f"arm.{name}", value, "give a finite number above 0")


def _check_phase(where: Path | str, field: str, phase: PhaseConfig) -> None:
    require(bool(phase.name), where, f"{field}.name", phase.name, "give every phase a name")
    require(phase.to in _GOALS, where, f"{field}.to", phase.to, 'give "object", "goal" or "home", or leave it out')
    require(phase.until in _ENDS, where, f"{field}.until", phase.until, 'give "grasped" or "released", or leave it out')
    both = bool(phase.to and phase.posture)
    require(not both, where, f"{field}.posture", phase.posture, f"leave it out beside to: {phase.to}")
    finite = all(map(math.isfinite, phase.posture))
    require(finite, where, f"{field}.posture", phase.posture, "give finite numbers, one a joint of the arm")
    require(math.isfinite(phase.height), where, f"{field}.height", phase.height, "give a height in m")
    require(0 < phase.speed <= 1, where, f"{field}.speed", phase.speed, "give a part of the arm's limits, above 0 to 1")
    for name in ("distance", "rest"):
        value = getattr(phase, name)
        require(not_negative(value), where, f"{field}.{name}", value, "give a finite number, 0 or more")
