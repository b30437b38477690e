"""The sensors of a scenario: where they are, their errors, presets, and the uncertainty that follows.

A kind of sensor is a class that models the measurements on a finger, made from the finger and the number of sections:

    class Curvature(MeasurementModel): ...

A strain sensor of your own is a system with an input `joint_angles` (N) rad and an output `strain`, the readings;
any other outputs are logged. It may also take `pressure` and `X_WB`. It is made by a function of the sensors on
the finger and their sampling period, s:

    def make(layout: SensorLayout, period: float) -> System
"""

from collections.abc import Callable
from dataclasses import fields, replace
from typing import Any, TypeGuard

from pydrake.systems.framework import System

from soft_gripper.errors import InputError
from soft_gripper.estimators.uncertainty import EXACT, Uncertainty, uncertainty_of
from soft_gripper.fingers.finger import Finger
from soft_gripper.registry import Registry, blamed_on
from soft_gripper.scenario.schema import (
    DeadSensorConfig,
    EstimatorConfig,
    SensorConfig,
    SensorFaultConfig,
    StrainErrorsConfig,
    presets,
)
from soft_gripper.sensors.calibrated_states import CalibratedStates
from soft_gripper.sensors.link_sensors import CurvatureSensors, OrientationSensors
from soft_gripper.sensors.measurement import MeasurementModel
from soft_gripper.sensors.path_sensors import LAYOUTS, PathSensors, SensorPath, named_paths
from soft_gripper.sensors.response_curve import LINEAR, ResponseCurve
from soft_gripper.sensors.sensor_layout import SensorLayout, path_names
from soft_gripper.sensors.strain_errors import SensorFault, StrainErrors

MakeSensor = Callable[[SensorLayout, float], System]
ALL = "all"  # names every finger
# Kinds of sensors; a user's own may also be a function that makes a strain sensor.
SENSORS = Registry[type[MeasurementModel] | MakeSensor](
    "sensor.type", {"strain": SensorLayout, "curvature": CurvatureSensors, "orientation": OrientationSensors}
)


def is_measurement_model(kind: object) -> TypeGuard[type[MeasurementModel]]:
    """Whether a registered kind is a subclass of MeasurementModel."""
    return isinstance(kind, type) and issubclass(kind, MeasurementModel)


def sensor_layout(finger: Finger, config: SensorConfig) -> MeasurementModel:
    """The sensors that a scenario puts on a finger: of the kind that it names, strain sensors by default.

    Raises:
        InputError: if there is no such kind, it fails, a path is named and it has none, there are more sections than
            segments, the borders are wrong, or the response is not a curve.
    """
    points = LINEAR if config.response is None else tuple(map(tuple, config.response))
    borders = None if config.borders is None else tuple(config.borders)
    sensor_type = SENSORS.find(config.type)
    kind = sensor_type if is_measurement_model(sensor_type) else SensorLayout
    options: dict[str, Any] = {"response": ResponseCurve(points), "borders": borders}
    if not issubclass(kind, SensorLayout):
        for name, default in (("one_sided", False), ("layout", "sides"), ("paths", [])):
            if (value := getattr(config, name)) != default:
                raise InputError("sensor", name, value, f"{config.type} has no paths; leave it out")
        dead = [] if config.errors is None else config.errors.dead
        faulty, dead_paths = [fault.path for fault in config.faults], [sensor.path for sensor in dead]
        for name, values in (("faults", faulty), ("errors.dead", dead_paths)):
            if values:
                expected = f"{config.type} has no paths; leave {name} out"
                raise InputError("sensor", f"{name}[0].path", values[0], expected)
    elif config.paths:
        kind, paths = PathSensors, list[SensorPath]()
        for path in config.paths:
            stations = {name: tuple(getattr(path, name)) for name in ("x", "y", "at")}
            paths.append(SensorPath(path.name, **stations, x_slope=path.x_slope, y_slope=path.y_slope))
        options["paths"] = tuple(paths)
    elif config.layout != "sides":
        kind, options["paths"] = PathSensors, named_paths(config.layout, finger)
    else:
        options["one_sided"] = config.one_sided
    with blamed_on("sensor.type", config.type):
        return kind(finger, config.sections, **options)


def strain_errors(sensor: SensorConfig, finger: str | None = None) -> StrainErrors | None:
    """The errors of the strain sensors, with the faults of those on a finger; None if they are ideal.

    Raises:
        InputError: for an unknown preset, a number out of range, or a dead sensor that does not exist.
    """
    faults = sensor_faults(sensor, finger)
    config = sensor.errors or (StrainErrorsConfig() if faults else None)
    if config is None:
        return None
    if config.preset is not None and config.preset not in presets():
        raise InputError("sensor.errors", "preset", config.preset, f"must be one of {', '.join(presets())}")
    names = {field.name for field in fields(StrainErrors)} - {"dead", "faults"}
    given_values = {name: value for name in names if (value := getattr(config, name)) is not None}
    values: dict[str, Any] = (presets()[config.preset] if config.preset is not None else {}) | given_values
    if "saturation" in values:
        values["saturation"] = tuple(values["saturation"])
    dead = [_reading(sensor, "sensor.errors", f"dead[{i}]", dead_config) for i, dead_config in enumerate(config.dead)]
    return StrainErrors(**values, dead=tuple(dead), faults=faults)


def uncertainty(
    estimator: EstimatorConfig, sensor: SensorConfig, calibrated: CalibratedStates | None = None
) -> Uncertainty:
    """Uncertainty that an estimator assumes, by default from errors and calibration; raises as `strain_errors`."""
    values = {name: value for name, value in vars(estimator.uncertainty).items() if value is not None}
    error_uncertainty = uncertainty_of(strain_errors(sensor), sensor.pressure_errors)
    if calibrated is not None and calibrated.gain_std is not None:
        # Gains take what varies along the finger, too.
        error_uncertainty = replace(error_uncertainty, gain=calibrated.gain_std, bend_per_pressure=EXACT)
    return replace(error_uncertainty, **values)


def sensor_faults(sensor: SensorConfig, finger: str | None = None) -> tuple[SensorFault, ...]:
    """Faults of the sensors on a finger, if one is given; raises an InputError for a sensor that does not exist."""
    faults = [(fault, _reading(sensor, "sensor", f"faults[{i}]", fault)) for i, fault in enumerate(sensor.faults)]
    finger_faults = [(fault, i) for fault, i in faults if finger is not None and fault.finger in (finger, ALL)]
    return tuple(SensorFault(fault.kind, reading, fault.time, fault.size) for fault, reading in finger_faults)


def _reading(sensor: SensorConfig, where: str, field: str, fault: DeadSensorConfig | SensorFaultConfig) -> int:
    """The index of the reading of a sensor that is named by path and section."""
    paths = path_names(sensor.one_sided) if sensor.layout == "sides" else LAYOUTS[sensor.layout]
    if sensor.paths:
        paths = tuple(path.name for path in sensor.paths)
    if fault.path not in paths:
        raise InputError(where, f"{field}.path", fault.path, f"must be one of {', '.join(paths)}")
    if not 0 <= fault.section < sensor.sections:
        raise InputError(where, f"{field}.section", fault.section, f"must be 0 to {sensor.sections - 1}")
    return paths.index(fault.path) * sensor.sections + fault.section
