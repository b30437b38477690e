"""What a scenario must be, field by field, before anything is built from it."""

import math
from collections.abc import Iterable, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
from pydrake.systems.analysis import GetIntegrationSchemes

from soft_gripper.control.pid_controller import PidGains
from soft_gripper.errors import InputError
from soft_gripper.files.document import NAME_RULE, check_document, is_name, not_negative, positive, require
from soft_gripper.scenario.drake_values import without_numpy
from soft_gripper.scenario.scenario import ArmConfig, MeshConfig, PhaseConfig, Scenario, TaskConfig, TrialsConfig
from soft_gripper.scenario.sensor_presets import pressure_errors, strain_errors
from soft_gripper.sensors.response_curve import ResponseCurve

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


MOST_STEPS = 2_000_000  # of the plant: a quarter of an hour with one finger
MOST_SAMPLES = 500_000  # of every signal: gigabytes of logs
MOST_TIME = 86_400.0  # s, of a run that is held back to some part of real time
FINEST = 1e-9  # accuracy: below, error control takes steps without end


def check_cost(where: Path | str, scenario: Scenario) -> None:
    """Estimates the steps, the samples and the time of a run, from its length.

    Raises:
        InputError: if they would be more than anybody waits for; it names the estimate.
    """
    plant, solver = scenario.plant_config, scenario.simulator_config
    discrete = plant.time_step > 0
    field, step = (
        ("plant_config.time_step", plant.time_step)
        if discrete
        else ("simulator_config.max_step_size", solver.max_step_size)
    )
    duration = scenario.duration
    for name, period, most, what in (
        (field, step, MOST_STEPS, "steps"),
        ("sensor.period", scenario.sensor.period, MOST_SAMPLES, "samples"),
    ):
        number = duration / period
        expected = f"{duration:g} s would be {number:.2g} {what}, of at most {most:.0e}: give more, or a shorter run"
        require(number <= most, where, name, period, expected)
    rate = solver.target_realtime_rate
    expected = f"give 0, which is as fast as it can be, or a part of real time that takes {duration:g} s a day at most"
    fine = rate == 0 or (rate > 0 and duration / rate <= MOST_TIME)
    require(fine, where, "simulator_config.target_realtime_rate", rate, expected)
    expected = f"give {FINEST:g} or more"
    require(solver.accuracy >= FINEST, where, "simulator_config.accuracy", solver.accuracy, expected)


_ATMOSPHERE = 101325.0  # Pa; no vacuum is deeper
# Names of blocks and of groups of signals, which neither a model nor a finger has.
_TAKEN = (
    *("plant", "scene_graph", "logs", "task", "grip", "grip_control", "true_contact", "object_width"),
    *("minus_true_width", "object_width_error", "estimate_visualizer", "all"),
)
_CONTACT_MODELS = ("hydroelastic_with_fallback", "hydroelastic", "point")
_APPROXIMATIONS = ("lagged", "similar", "sap", "tamsi")
_EXTERNAL = ("pressure", "opening", "joints", "tool")


def check_scenario(where: Path | str, scenario: Scenario) -> None:
    """Compares the values of a scenario with what they may be; fingers are checked when they are built.

    Raises:
        InputError: for the first value that is out of range.
    """
    _check_models(where, scenario)
    _check_pressure(where, scenario)
    _check_sensor(where, scenario)
    _check_estimator(where, scenario)
    _check_control(where, scenario)
    check_task(where, scenario)
    _check_external(where, scenario)
    _check_solver(where, scenario)
    check_cost(where, scenario)


def plain_scenario(where: Path | str, scenario: Scenario) -> Scenario:
    """A copy of a scenario that was made in Python, with Python's own numbers, of the types that the schema gives.

    Raises:
        InputError: for the first value of another type.
    """
    require(isinstance(scenario, Scenario), where, "scenario", scenario, "give a Scenario, such as load_scenario reads")
    plain: Scenario = without_numpy(scenario)
    check_document(where, plain, Scenario)
    return plain


def check_finger_names(where: Path | str, names: Iterable[str]) -> None:
    """Looks at the names of the fingers, which the model files give.

    Raises:
        InputError: if one is the name of a block.
    """
    for name in names:
        require(name not in _TAKEN, where, "finger.name", name, "is the name of a block")


def _check_models(where: Path | str, scenario: Scenario) -> None:
    gravity = scenario.gravity
    three = len(gravity) == 3 and all(map(math.isfinite, gravity))
    require(three, where, "gravity", gravity, "give three finite numbers, m/s^2")
    require(bool(scenario.models), where, "models", [], "give at least one model")
    names = [model.name for model in scenario.models]
    for i, model in enumerate(scenario.models):
        require(is_name(model.name), where, f"models[{i}].name", model.name, NAME_RULE)
        require(model.name not in _TAKEN, where, f"models[{i}].name", model.name, "is the name of a block")
        translation = model.X_PC.translation
        finite = isinstance(translation, np.ndarray) and len(translation) == 3 and bool(np.isfinite(translation).all())
        require(finite, where, f"models[{i}].X_PC.translation", translation, "give three finite numbers, m")
        require(names.count(model.name) == 1, where, f"models[{i}].name", model.name, "appears more than once")
        require(bool(model.file), where, f"models[{i}].file", model.file, "give a package:// URI or a path")
        apart = not model.free or (model.parent == "world" and model.child is None)
        require(apart, where, f"models[{i}].free", True, "leave parent and child out: it is welded to nothing")
        counted = model.segments is None or model.segments >= 1
        require(counted, where, f"models[{i}].segments", model.segments, "give 1 or more")
        _check_mesh(where, f"models[{i}].mesh", model.mesh)


def _check_mesh(where: Path | str, field: str, mesh: MeshConfig) -> None:
    for name in ("scale", "mass"):
        value = getattr(mesh, name)
        require(positive(value), where, f"{field}.{name}", value, "give a finite number above 0")
    require(not_negative(mesh.friction), where, f"{field}.friction", mesh.friction, "give 0 or more")
    channels = len(mesh.color) == 4 and all(0 <= channel <= 1 for channel in mesh.color)
    require(channels, where, f"{field}.color", mesh.color, "give red, green, blue and opacity, each 0 to 1")


def _check_pressure(where: Path | str, scenario: Scenario) -> None:
    pressure = scenario.pressure
    low, high = pressure.minimum, pressure.maximum
    deepest = f"give a pressure from {-_ATMOSPHERE:.0f} Pa (vacuum) up to the maximum"
    require(-_ATMOSPHERE <= low <= high, where, "pressure.minimum", low, deepest)
    require(math.isfinite(high), where, "pressure.maximum", high, "give a finite pressure in Pa")
    require(not_negative(pressure.settle), where, "pressure.settle", pressure.settle, "give a time in s")
    require(pressure.hold_samples > 0, where, "pressure.hold_samples", pressure.hold_samples, "give 1 or more")
    lag = pressure.time_constant
    require(not_negative(lag), where, "pressure.time_constant", lag, "give a time in s, 0 for no lag")
    require(bool(pressure.steps), where, "pressure.steps", {}, "give steps for 'all' or for a finger")
    for finger, steps in pressure.steps.items():
        require(bool(steps), where, f"pressure.steps.{finger}", steps, "give at least one pressure")
        for i, step in enumerate(steps):
            limits = f"give a pressure within the limits, {low:g} to {high:g} Pa"
            require(low <= step <= high, where, f"pressure.steps.{finger}[{i}]", step, limits)


def _check_control(where: Path | str, scenario: Scenario) -> None:
    control, gains = scenario.control, scenario.control.gains
    points = control.set_points
    require(points is None or bool(points), where, "control.set_points", points, "give openings, or leave it out")
    for i, point in enumerate(points or []):
        require(positive(point), where, f"control.set_points[{i}]", point, "give an opening above 0 m")
        repeated = i > 0 and points is not None and point == points[i - 1]
        require(not repeated, where, f"control.set_points[{i}]", point, "is no step; give another than the one before")
    lasting = positive(control.hold) and control.hold >= scenario.sensor.period
    require(lasting, where, "control.hold", control.hold, "give a time above 0 s, of a sensor period at least")
    _check_gains(where, "control.gains", gains)
    for kind, unit in (("torque", "N m"), ("force", "N")):
        limit, of_limit = getattr(control, f"{kind}_limit"), getattr(control, f"{kind}_gains")
        fine = limit is None or positive(limit)
        require(fine, where, f"control.{kind}_limit", limit, f"give a {kind} above 0, {unit}")
        _check_gains(where, f"control.{kind}_gains", of_limit)
        integrates = limit is None or of_limit.ki > 0
        require(integrates, where, f"control.{kind}_gains.ki", of_limit.ki, "give a gain above 0 to hold the limit")
    both = control.torque_limit is not None and control.force_limit is not None
    require(not both, where, "control.force_limit", control.force_limit, "leave it out beside a torque_limit")


def _check_gains(where: Path | str, field: str, gains: PidGains) -> None:
    for name in ("kp", "ki", "kd", "derivative_filter"):
        value = getattr(gains, name)
        require(not_negative(value), where, f"{field}.{name}", value, "give a finite number, 0 or more")
    require(gains.tracking_time > 0, where, f"{field}.tracking_time", gains.tracking_time, "give a time above 0 s")


def _check_sensor(where: Path | str, scenario: Scenario) -> None:
    sensor = scenario.sensor
    require(sensor.sections >= 1, where, "sensor.sections", sensor.sections, "give 1 or more")
    require(positive(sensor.period), where, "sensor.period", sensor.period, "give a time above 0 s")
    for field, response in (("sensor", sensor.response), ("believed", scenario.believed.response)):
        try:
            if response is not None:
                ResponseCurve(tuple(map(tuple, response)))
        except InputError as error:
            raise InputError(where, f"{field}.response", response, error.expected) from None
    require(sensor.seed >= 0, where, "sensor.seed", sensor.seed, "give 0 or more")
    for errors in (strain_errors, pressure_errors):
        try:
            errors(sensor)
        except InputError as error:
            raise InputError(where, f"{error.where}.{error.field}", error.value, error.expected) from None


def _check_estimator(where: Path | str, scenario: Scenario) -> None:
    estimator = scenario.estimator
    threshold = estimator.contact_threshold
    expected = "give a torque above 0, N m"
    require(threshold is None or positive(threshold), where, "estimator.contact_threshold", threshold, expected)
    both = threshold is not None and not estimator.compensate_gravity
    expected = "leave it true: a finger whose weight is left in the torque always seems to touch something"
    require(not both, where, "estimator.compensate_gravity", False, expected)
    for i, kind in enumerate(estimator.beside):
        once = kind != estimator.type and estimator.beside.count(kind) == 1
        require(once, where, f"estimator.beside[{i}]", kind, "is an estimator of this scenario already")
    try:
        if estimator.uncertainty is not None:
            replace(estimator.uncertainty)
    except InputError as error:
        raise InputError(where, f"estimator.uncertainty.{error.field}", error.value, error.expected) from None


def _check_external(where: Path | str, scenario: Scenario) -> None:
    external = scenario.external
    for i, name in enumerate(external):
        require(name in _EXTERNAL, where, f"external[{i}]", name, f"known: {', '.join(_EXTERNAL)}")
        require(external.count(name) == 1, where, f"external[{i}]", name, "appears more than once")
    grips = scenario.task is not None and scenario.task.grips
    closed = "the phases of the task" if grips else "control.set_points" if scenario.control.set_points else None
    _exclude(where, external, ("pressure", "opening"), closed)
    _exclude(where, external, ("joints", "tool"), "the task" if scenario.task is not None else None)
    moved = [name for name in external if name in ("joints", "tool")]
    require(scenario.arm is not None or not moved, where, "external", external, f"there is no arm for {moved}")


def _exclude(where: Path | str, external: Sequence[str], names: Sequence[str], other: str | None) -> None:
    """Of some commands one may come from outside, if nothing else gives it."""
    found = [name for name in external if name in names]
    require(len(found) < 2, where, "external", list(external), f"give {' or '.join(names)}: one commands the other")
    fits = other is None or not found
    require(fits, where, "external", list(external), f"leave out {found}: {other} would command the same")


def _check_solver(where: Path | str, scenario: Scenario) -> None:
    plant, solver = scenario.plant_config, scenario.simulator_config
    step = plant.time_step
    require(not_negative(step), where, "plant_config.time_step", step, "give a time in s, 0 for continuous")
    for name, known_values in (
        ("contact_model", _CONTACT_MODELS),
        ("discrete_contact_approximation", _APPROXIMATIONS),
        ("contact_surface_representation", ("polygon", "triangle")),
    ):
        value = getattr(plant, name)
        require(value in known_values, where, f"plant_config.{name}", value, f"known: {', '.join(known_values)}")
    for name in ("penetration_allowance", "stiction_tolerance"):
        value = getattr(plant, name)
        require(positive(value), where, f"plant_config.{name}", value, "give a finite number above 0")
    start = solver.start_time
    require(start == 0, where, "simulator_config.start_time", start, "runs begin at 0")
    every = getattr(solver, "publish_every_time_step", False)
    require(not every, where, "simulator_config.publish_every_time_step", every, "logs keep the sensors' period")
    schemes = GetIntegrationSchemes()
    known = solver.integration_scheme in schemes
    expected = f"known: {', '.join(schemes)}"
    require(known, where, "simulator_config.integration_scheme", solver.integration_scheme, expected)
    for name in ("max_step_size", "accuracy"):
        value = getattr(solver, name)
        require(positive(value), where, f"simulator_config.{name}", value, "give a finite number above 0")
