"""Rules across the parts of a scenario; what a field may hold is declared beside it in `schema.py`."""

import math
from collections.abc import Callable, Collection, Iterable, Iterator
from pathlib import Path
from typing import Any

from soft_gripper.errors import InputError
from soft_gripper.files.document import check_config, require
from soft_gripper.quantity import Violation
from soft_gripper.scenario.drake_values import plain_values, to_plain_numbers
from soft_gripper.scenario.schema import Scenario
from soft_gripper.scenario.sensor_presets import sensor_faults, strain_errors
from soft_gripper.sensors.response_curve import ResponseCurve

MOST_STEPS = 2_000_000  # of the plant: a quarter of an hour with one finger
MOST_SAMPLES = 500_000  # of every signal: gigabytes of logs
MOST_MODELS = 500  # which take a quarter of an hour to be read; the time of a step grows with them even faster
MOST_TIME = 86_400.0  # s, of a run that is slowed to a fraction of real time

# Names of blocks and of groups of signals, which no model or finger may have.
_RESERVED_NAMES = (
    *("plant", "scene_graph", "logs", "task", "grip", "grip_control", "true_contact", "object_width"),
    *("minus_true_width", "object_width_error", "estimate_visualizer", "all"),
)
_CHECKED_ATTRIBUTE = "_checked"  # attribute of a scenario: its values when it was checked


def checked_scenario(where: Path | str, scenario: Scenario) -> Scenario:
    """A valid copy of a scenario with Python's own numbers; one that was loaded and not changed is not checked again.

    Raises:
        InputError: for the first value that has another type, is out of range, or contradicts another one.
    """
    require(isinstance(scenario, Scenario), where, "scenario", scenario, "must be a Scenario, as load_scenario reads")
    plain_scenario: Scenario = to_plain_numbers(scenario)
    values = plain_values(plain_scenario)
    if getattr(scenario, _CHECKED_ATTRIBUTE, None) != values:
        check_config(where, plain_scenario)
        check_scenario(where, plain_scenario)
    setattr(plain_scenario, _CHECKED_ATTRIBUTE, values)
    return plain_scenario


def check_scenario(where: Path | str, scenario: Scenario) -> None:
    """Raises an InputError for the first broken rule across the parts of a scenario, each valid by itself."""
    for rules in (_models, _sensors, _arm_and_task, _external, _run):
        for field, value, expected in rules(scenario):
            raise InputError(where, field, value, expected)
    setattr(scenario, _CHECKED_ATTRIBUTE, plain_values(scenario))


def check_finger_names(where: Path | str, names: Iterable[str]) -> None:
    """Raises an InputError if one of the fingers' names, which the model files give, is that of a block."""
    for name in names:
        require(name not in _RESERVED_NAMES, where, "finger.name", name, "is the name of a block")


def _models(scenario: Scenario) -> Iterator[Violation]:
    names = [model.name for model in scenario.models]
    if len(names) > MOST_MODELS:
        yield "models", len(names), f"give at most {MOST_MODELS} models: those beyond would take hours to be read"
    for i, name in enumerate(names):
        if name in _RESERVED_NAMES:
            yield f"models[{i}].name", name, "is the name of a block"
        if names.count(name) > 1:
            yield f"models[{i}].name", name, "appears more than once"

    hold, period = scenario.control.hold, scenario.sensor.period
    if hold < period:
        yield "control.hold", hold, f"must be at least sensor.period, {period:g} s"


def _sensors(scenario: Scenario) -> Iterator[Violation]:
    responses = {"sensor": scenario.sensor.response, "nominal": scenario.nominal.response}
    for part, response in responses.items():
        if response is not None:
            yield from _building_violations(part, ResponseCurve, response)
    yield from _building_violations("sensor", sensor_faults, scenario.sensor)
    yield from _building_violations("sensor.errors", strain_errors, scenario.sensor)


def _building_violations(part: str, make: Callable[[Any], object], part_config: object) -> Iterator[Violation]:
    """Violations that prevent a part from being built."""
    try:
        make(part_config)
    except InputError as error:
        yield f"{part}.{error.field}", error.value, error.expected


def _arm_and_task(scenario: Scenario) -> Iterator[Violation]:
    arm, task = scenario.arm, scenario.task
    names = [model.name for model in scenario.models]
    if arm is not None and arm.model not in names:
        yield "arm.model", arm.model, f"must be one of the models: {', '.join(names)}"
    if task is None:
        return
    if arm is None:
        yield "arm", None, "a task moves an arm: give arm: { model, home }"
    if task.time_limit <= scenario.sensor.period:
        yield "task.time_limit", task.time_limit, f"must be above sensor.period, {scenario.sensor.period:g} s"
    free_names = [model.name for model in scenario.models if model.free]
    is_handled = task.object or any(phase.holds or phase.to in ("object", "goal") for phase in task.phases)
    if is_handled and task.object not in free_names:
        yield "task.object", task.object, f"must be one of the free models: {', '.join(free_names) or 'there is none'}"
    if not task.grips:
        return
    control, threshold = scenario.control, task.grip_threshold
    if control.set_points is not None:
        yield "control.set_points", control.set_points, "leave them out: the phases give openings"
    if control.gains.ki == 0:
        yield "control.gains.ki", control.gains.ki, "must be above 0 for a grip; `soft-gripper tune` finds gains"
    if control.torque_limit is not None and control.torque_limit <= threshold:
        expected = f"must be above task.grip_threshold, {threshold:g} N m: nothing else would count as a grip"
        yield "control.torque_limit", control.torque_limit, expected


def _external(scenario: Scenario) -> Iterator[Violation]:
    external, task = scenario.external, scenario.task
    for i, name in enumerate(external):
        if external.count(name) > 1:
            yield f"external[{i}]", name, "appears more than once"
    grips = task is not None and task.grips
    closing = "the phases of the task" if grips else "control.set_points" if scenario.control.set_points else None
    yield from _exclusion_violations(external, ("pressure", "opening"), closing)
    yield from _exclusion_violations(external, ("joints", "tool"), "the task" if task is not None else None)
    moved_kinds = [name for name in external if name in ("joints", "tool")]
    if moved_kinds and scenario.arm is None:
        yield "external", external, f"there is no arm for {moved_kinds}"


def _exclusion_violations(external: Collection[str], names: Collection[str], rival: str | None) -> Iterator[Violation]:
    """Violations unless at most one of some commands comes from outside, and none if `rival` gives it."""
    given_names = [name for name in external if name in names]
    if len(given_names) > 1:
        yield "external", external, f"give {' or '.join(names)}: one commands the other"
    if given_names and rival is not None:
        yield "external", external, f"leave out {given_names}: {rival} would command the same"


def _run(scenario: Scenario) -> Iterator[Violation]:
    """Rules of the solver, and estimates of the steps, the samples and the time of a run, from its length."""
    plant, solver, duration = scenario.plant_config, scenario.simulator_config, scenario.duration
    if solver.start_time != 0:
        yield "simulator_config.start_time", solver.start_time, "must be 0, at which runs begin"
    if getattr(solver, "publish_every_time_step", False):
        yield "simulator_config.publish_every_time_step", True, "must be false: logs keep the sensors' period"
    step = ("plant_config.time_step", plant.time_step)
    if plant.time_step == 0:
        step = ("simulator_config.max_step_size", solver.max_step_size)
    samples = ("sensor.period", scenario.sensor.period)
    for (field, period), limit, quantity in ((step, MOST_STEPS, "steps"), (samples, MOST_SAMPLES, "samples")):
        if (number := duration / period) > limit:
            cost = f"{duration:g} s would be {number:.2g} {quantity}, of at most {limit:.0e}"
            yield field, period, f"{cost}: give more, or a shorter run"
    rate = solver.target_realtime_rate
    slowest = duration / MOST_TIME
    if 0 < rate < slowest or not math.isfinite(rate):
        expected = f"must be 0, which is as fast as possible, or at least {slowest:.2g}: {duration:g} s would take days"
        yield "simulator_config.target_realtime_rate", rate, expected
