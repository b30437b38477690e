"""What an environment file must be, field by field, before anything is built from it."""

import math
from collections.abc import Iterator
from pathlib import Path

from soft_gripper.files.document import not_negative, positive, require
from soft_gripper.learning.schema.config import EnvironmentConfig, VariationConfig
from soft_gripper.scenario.scenario import FingerChanges, Scenario

_GRIPS = ("pressure", "opening")
_TASKS = ("reach", "grasp", "pick_place")


def check_environment(where: Path, config: EnvironmentConfig, scenario: Scenario) -> None:
    """Compares the values of an environment with what they may be; names of signals are checked when it is built.

    Raises:
        InputError: for the first value that is out of range.
    """
    step = config.time_step
    require(step >= scenario.sensor.period, where, "time_step", step, "give the sensors' period or more, s")
    require(config.duration >= step, where, "duration", config.duration, "give a time_step or more, s")
    given = [name for name in _TASKS if getattr(config, name) is not None]
    require(len(given) == 1, where, "task", given, f"give one of {', '.join(_TASKS)}")
    require(bool(config.observation), where, "observation", [], "give at least one signal")
    for i, observed in enumerate(config.observation):
        require(positive(observed.scale), where, f"observation[{i}].scale", observed.scale, "give a number above 0")
    _check_action(where, config)
    _check_variation(where, config.variation, scenario)
    _check_task(where, config, scenario)


def _check_action(where: Path, config: EnvironmentConfig) -> None:
    action = config.action
    require(action.grip in _GRIPS, where, "action.grip", action.grip, f"known: {', '.join(_GRIPS)}")
    _check_span(where, "action.range", action.range)
    within = action.range[0] <= action.rest <= action.range[1]
    require(within, where, "action.rest", action.rest, "give a value of the range")
    for name, limits in action.joints.items():
        _check_span(where, f"action.joints.{name}", limits)
    require(positive(action.settling), where, "action.settling", action.settling, "give a time above 0 s")


def _check_variation(where: Path, variation: VariationConfig, scenario: Scenario) -> None:
    for name in ("mass", "friction", "size", "stiffness"):
        limits = getattr(variation, name)
        if limits is not None:
            _check_range(where, f"variation.{name}", limits)
            require(limits[0] > 0, where, f"variation.{name}", limits, "give numbers above 0")
    require(not_negative(variation.offset), where, "variation.offset", variation.offset, "give 0 m or more")
    share = variation.youngs_modulus
    require(0 <= share < 1, where, "variation.youngs_modulus", share, "give a share from 0 to below 1")
    require(variation.grippers >= 1, where, "variation.grippers", variation.grippers, "give 1 or more")
    names = [model.name for model in scenario.models]
    known = variation.gripper in names or share == 0
    require(known, where, "variation.gripper", variation.gripper, f"models: {', '.join(names)}")
    is_given = any(changes.youngs_modulus is not None for changes in _finger_changes(variation, scenario))
    alone = share == 0 or variation.grippers == 1 or not is_given
    require(alone, where, "variation.youngs_modulus", share, "give 0, since the scenario gives the fingers another")


def _finger_changes(variation: VariationConfig, scenario: Scenario) -> Iterator[FingerChanges]:
    """What the scenario changes of the fingers that differ, and what is believed of them."""
    yield scenario.believed
    for model in scenario.models:
        if model.name == variation.gripper:
            yield from model.fingers.values()


def _check_task(where: Path, config: EnvironmentConfig, scenario: Scenario) -> None:
    free = [model.name for model in scenario.models if model.free]
    for name in ("grasp", "pick_place"):
        task = getattr(config, name)
        if task is not None:
            require(task.object in free, where, f"{name}.object", task.object, f"free models: {', '.join(free)}")
            require(positive(task.crushing_force), where, f"{name}.crushing_force", task.crushing_force, "give it in N")
    if config.pick_place is not None:
        _check_range(where, "pick_place.goal", config.pick_place.goal)
    if config.reach is not None:
        _check_range(where, "reach.pressure", config.reach.pressure)
        _check_range(where, "reach.period", config.reach.period)
        require(config.reach.period[0] > 0, where, "reach.period", config.reach.period, "give times above 0 s")


def _check_span(where: Path, field: str, limits: list[float]) -> None:
    _check_range(where, field, limits)
    require(limits[0] < limits[1], where, field, limits, "give two different numbers: an action is a share of the span")


def _check_range(where: Path, field: str, limits: list[float]) -> None:
    fine = len(limits) == 2 and all(map(math.isfinite, limits)) and limits[0] <= limits[1]
    require(fine, where, field, limits, "give [least, most]")
