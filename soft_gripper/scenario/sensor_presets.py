"""The errors of sensors that a scenario asks for, presets and all, and what is uncertain because of them."""

from dataclasses import asdict, fields
from functools import cache
from typing import Any

from pydrake.common.yaml import yaml_load_file

from soft_gripper.errors import InputError
from soft_gripper.estimators.uncertainty import Uncertainty, uncertainty_of
from soft_gripper.scenario.scenario import DeadSensorConfig, EstimatorConfig, SensorConfig
from soft_gripper.scenario.shipped import PRESETS
from soft_gripper.sensors.pressure_errors import PressureErrors
from soft_gripper.sensors.sensor_layout import path_names
from soft_gripper.sensors.strain_errors import StrainErrors


def strain_errors(sensor: SensorConfig) -> StrainErrors | None:
    """The errors of the strain sensors; None if they are ideal.

    Raises:
        InputError: for an unknown preset, a number out of range, or a dead sensor that there is not.
    """
    config = sensor.errors
    if config is None:
        return None
    names = {field.name for field in fields(StrainErrors)} - {"dead"}
    given = {name: value for name in names if (value := getattr(config, name)) is not None}
    values = (_preset(config.preset) if config.preset is not None else {}) | given
    if "saturation" in values:
        values["saturation"] = _range(values["saturation"])
    return StrainErrors(**values, dead=tuple(_reading(sensor, i, dead) for i, dead in enumerate(config.dead)))


def pressure_errors(sensor: SensorConfig) -> PressureErrors | None:
    """The errors of the pressure sensor; None if it is ideal.

    Raises:
        InputError: for a number out of range.
    """
    return None if sensor.pressure_errors is None else PressureErrors(**asdict(sensor.pressure_errors))


def uncertainty(estimator: EstimatorConfig, sensor: SensorConfig) -> Uncertainty:
    """What an estimator believes to be uncertain: what is given, or what follows from the errors of the sensors.

    Raises:
        InputError: as `strain_errors` and `pressure_errors`.
    """
    given = estimator.uncertainty
    return uncertainty_of(strain_errors(sensor), pressure_errors(sensor)) if given is None else given


@cache
def presets() -> dict[str, dict[str, Any]]:
    """The errors of known kinds of sensors."""
    found: dict[str, dict[str, Any]] = yaml_load_file(str(PRESETS))
    return found


def _preset(name: str) -> dict[str, Any]:
    if name not in presets():
        raise InputError("sensor.errors", "preset", name, f"known: {', '.join(presets())}")
    return presets()[name]


def _range(limits: list[float]) -> tuple[float, float]:
    if len(limits) != 2:
        raise InputError("sensor.errors", "saturation", limits, "give [least, greatest] extension ratio")
    return limits[0], limits[1]


def _reading(sensor: SensorConfig, i: int, dead: DeadSensorConfig) -> int:
    """Which of the readings a dead sensor would give."""
    paths = path_names(sensor.one_sided)
    if dead.path not in paths:
        raise InputError("sensor.errors", f"dead[{i}].path", dead.path, f"known: {', '.join(paths)}")
    if not 0 <= dead.section < sensor.sections:
        raise InputError("sensor.errors", f"dead[{i}].section", dead.section, f"give 0 to {sensor.sections - 1}")
    return paths.index(dead.path) * sensor.sections + dead.section
