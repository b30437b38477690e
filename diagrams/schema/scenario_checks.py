"""What a scenario must be, field by field, before anything is built from it."""

import math
from collections.abc import Iterable, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
from pydrake.systems.analysis import GetIntegrationSchemes

from soft_gripper.control.pid_controller import PidGains
from soft_gripper.diagrams.schema.cost_check import check_cost
from soft_gripper.diagrams.schema.document_check import check_document
from soft_gripper.diagrams.schema.drake_values import without_numpy
from soft_gripper.diagrams.schema.ranges import not_negative, positive, require
from soft_gripper.diagrams.schema.scenario import MeshConfig, Scenario
from soft_gripper.diagrams.schema.sensor_presets import pressure_errors, strain_errors
from soft_gripper.diagrams.schema.task_checks import check_task
from soft_gripper.errors import InputError
from soft_gripper.names import NAME_RULE, is_name
from soft_gripper.sensors.response_curve import ResponseCurve

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
