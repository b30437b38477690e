"""What a scenario must be, field by field, before anything is built from it."""

import difflib
import math
from pathlib import Path
from typing import Any, get_args, get_origin, get_type_hints

import numpy as np
from pydrake.common.schema import Transform
from pydrake.systems.analysis import GetIntegrationSchemes

from soft_gripper.diagrams.ranges import not_negative, positive, require
from soft_gripper.diagrams.scenario import MeshConfig, Scenario
from soft_gripper.diagrams.task_checks import check_task
from soft_gripper.errors import InputError
from soft_gripper.pid_controller import PidGains
from soft_gripper.response_curve import ResponseCurve

_ATMOSPHERE = 101325.0  # Pa; no vacuum is deeper
# Names of blocks and of groups of signals.
_TAKEN = (
    *("plant", "scene_graph", "logs", "task", "grip", "grip_control", "true_contact", "object_width"),
    *("minus_true_width", "object_width_error", "estimate_visualizer"),
)
_CONTACT_MODELS = ("hydroelastic_with_fallback", "hydroelastic", "point")
_APPROXIMATIONS = ("lagged", "similar", "sap", "tamsi")
_PRIMITIVES = {float: "a number", int: "a whole number", bool: "true or false", str: "text"}


def check_document(where: Path, value: Any, schema: Any, field: str = "") -> None:
    """Holds the plain data of a YAML file against a schema of dataclasses and Drake's configs.

    Raises:
        InputError: for an unknown key, with the nearest known one, or a value of the wrong type.
    """
    if schema in _PRIMITIVES:
        if not _converts(value, schema):
            raise InputError(where, field, value, f"give {_PRIMITIVES[schema]}")
    elif get_origin(schema) is list:
        if not isinstance(value, list):
            raise InputError(where, field, value, "give a list")
        for i, item in enumerate(value):
            check_document(where, item, get_args(schema)[0], f"{field}[{i}]")
    elif get_origin(schema) is dict:
        for key, item in _mapping(where, value, field).items():
            check_document(where, item, get_args(schema)[1], f"{field}.{key}")
    elif fields := _fields(schema):
        for key, item in _mapping(where, value, field).items():
            name = f"{field}.{key}" if field else str(key)
            if key not in fields:
                near = difflib.get_close_matches(str(key), fields, n=1)
                hint = f"did you mean '{near[0]}'?" if near else f"known: {', '.join(fields)}"
                raise InputError(where, name, item, f"no such key; {hint}")
            check_document(where, item, fields[key], name)
        if schema is Transform:
            _check_transform(where, value, field)


def _check_transform(where: Path, value: dict[str, Any], field: str) -> None:
    translation = value.get("translation", [0, 0, 0])
    require(_three_numbers(translation), where, f"{field}.translation", translation, "give three numbers, m")
    rotation = value.get("rotation", {})
    angles = rotation.get("deg", [0, 0, 0]) if isinstance(rotation, dict) else None
    finite = isinstance(angles, list) and _three_numbers(angles) and all(math.isfinite(float(a)) for a in angles)
    require(finite, where, f"{field}.rotation", rotation, "write !Rpy { deg: [roll, pitch, yaw] }")


def _three_numbers(value: Any) -> bool:
    return isinstance(value, list) and len(value) == 3 and all(_converts(number, float) for number in value)


def _mapping(where: Path, value: Any, field: str) -> dict[str, Any]:
    if not isinstance(value, dict):
        raise InputError(where, field, value, "give a mapping of keys to values")
    return value


def _fields(schema: Any) -> dict[str, Any]:
    if hasattr(schema, "__dataclass_fields__"):
        return get_type_hints(schema)
    return {field.name: field.type for field in getattr(schema, "__fields__", ())}


def _converts(value: Any, schema: type) -> bool:
    if isinstance(value, bool):
        return schema is bool
    if schema in (float, int):
        try:
            return schema(value) == float(value) or math.isnan(float(value))
        except (TypeError, ValueError, OverflowError):
            return False
    return isinstance(value, schema)


def check_scenario(where: Path | str, scenario: Scenario) -> None:
    """Holds the values of a scenario against what they may be; fingers are checked when they are built.

    Raises:
        InputError: for the first value that is out of range.
    """
    _check_models(where, scenario)
    _check_pressure(where, scenario)
    _check_sensor(where, scenario)
    _check_control(where, scenario)
    check_task(where, scenario)
    _check_solver(where, scenario)


def _check_models(where: Path | str, scenario: Scenario) -> None:
    gravity = scenario.gravity
    three = len(gravity) == 3 and all(map(math.isfinite, gravity))
    require(three, where, "gravity", gravity, "give three finite numbers, m/s^2")
    require(bool(scenario.models), where, "models", [], "give at least one model")
    names = [model.name for model in scenario.models]
    for i, model in enumerate(scenario.models):
        require(bool(model.name), where, f"models[{i}].name", model.name, "give every model a name")
        require(model.name not in _TAKEN, where, f"models[{i}].name", model.name, "is the name of a block")
        translation = model.X_PC.translation
        finite = isinstance(translation, np.ndarray) and len(translation) == 3 and bool(np.isfinite(translation).all())
        require(finite, where, f"models[{i}].X_PC.translation", translation, "give three finite numbers, m")
        require(names.count(model.name) == 1, where, f"models[{i}].name", model.name, "stands more than once")
        require(bool(model.file), where, f"models[{i}].file", model.file, "give a package:// URI or a path")
        apart = not model.free or (model.parent == "world" and not model.child)
        require(apart, where, f"models[{i}].free", True, "leave parent and child out: it is welded to nothing")
        require(model.segments >= 0, where, f"models[{i}].segments", model.segments, "give 1 or more, or 0")
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
    for i, point in enumerate(control.set_points):
        require(positive(point), where, f"control.set_points[{i}]", point, "give a distance above 0 m")
        repeated = i > 0 and point == control.set_points[i - 1]
        require(not repeated, where, f"control.set_points[{i}]", point, "is no step; give another than the one before")
    lasting = positive(control.hold) and control.hold >= scenario.sensor.period
    require(lasting, where, "control.hold", control.hold, "give a time above 0 s, of a sensor period at least")
    require(not_negative(control.torque_limit), where, "control.torque_limit", control.torque_limit, "give 0 or more")
    _check_gains(where, "control.gains", gains)
    _check_gains(where, "control.torque_gains", control.torque_gains)
    integrates = control.torque_limit == 0 or control.torque_gains.ki > 0
    require(
        integrates, where, "control.torque_gains.ki", control.torque_gains.ki, "give a gain above 0 to hold the limit"
    )


def _check_gains(where: Path | str, field: str, gains: PidGains) -> None:
    for name in ("kp", "ki", "kd", "derivative_filter"):
        value = getattr(gains, name)
        require(not_negative(value), where, f"{field}.{name}", value, "give a finite number, 0 or more")
    require(gains.tracking_time > 0, where, f"{field}.tracking_time", gains.tracking_time, "give a time above 0 s")


def _check_sensor(where: Path | str, scenario: Scenario) -> None:
    sensor = scenario.sensor
    require(sensor.sections >= 1, where, "sensor.sections", sensor.sections, "give 1 or more")
    require(positive(sensor.period), where, "sensor.period", sensor.period, "give a time above 0 s")
    threshold = sensor.contact_threshold
    require(not_negative(threshold), where, "sensor.contact_threshold", threshold, "give 0 or more, N m")
    if sensor.response:
        try:
            ResponseCurve(tuple(map(tuple, sensor.response)))
        except InputError as error:
            raise error.inside(where) from None


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
