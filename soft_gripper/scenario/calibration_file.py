"""Calibration files: their schema, and how they are read and written."""

import math
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path

import numpy as np
from pydrake.common.yaml import yaml_dump, yaml_load_typed

from soft_gripper.errors import InputError
from soft_gripper.estimators.calibration import Calibration
from soft_gripper.files.document import check_document
from soft_gripper.files.output import atomic_file
from soft_gripper.files.yaml_text import read_yaml
from soft_gripper.fingers.statics import softened
from soft_gripper.scenario.model_files import model_path
from soft_gripper.sensors.measurement import MeasurementModel
from soft_gripper.sensors.response_curve import CalibratedResponse, ResponseCurve
from soft_gripper.sensors.sensor_layout import SensorLayout, strain_sensors


@dataclass
class FingerCalibrationConfig:
    """What was found of one finger, relative to what was believed of it, and which finger it was."""

    length: float = 0.0  # m
    sensor_spacing: float = 0.0  # m
    one_sided: bool = False
    section_lengths: list[float] = field(default_factory=list)  # m, from the base to the tip
    bend_ratio: float = 1.0  # how much further it bends under the same pressure than was believed
    gains: list[float] = field(default_factory=list)  # of the strain of every reading
    offsets: list[float] = field(default_factory=list)  # of every reading, extension ratio
    residual: float = 0.0  # root mean square of what is left, extension ratio


@dataclass
class CalibrationConfig:
    """A calibration of the fingers of a gripper, by their names."""

    assumed: str = ""  # in words
    fingers: dict[str, FingerCalibrationConfig] = field(default_factory=dict)


def as_config(layout: SensorLayout, found: Calibration) -> FingerCalibrationConfig:
    """What is kept of the calibration of a finger with that believed layout."""
    numbers = float(found.bend_ratio), found.gains.tolist(), found.offsets.tolist(), found.residual
    return FingerCalibrationConfig(*_identity(layout), *numbers)


def calibrated(sensors: MeasurementModel, calibration: CalibrationConfig) -> SensorLayout:
    """The believed layout with the gains, offsets and stiffness that were found for its finger.

    Raises:
        InputError: if the calibration is of other fingers or sensors.
    """
    layout = strain_sensors(sensors, "believed.calibration")
    name, finger, curve = layout.finger.name, layout.finger, layout.response
    if name not in calibration.fingers:
        raise InputError("believed.calibration", "fingers", list(calibration.fingers), f"has none for '{name}'")
    config = calibration.fingers[name]
    found, own = (config.length, config.sensor_spacing, config.one_sided, config.section_lengths), _identity(layout)
    flat, expected = [*found[:3], *found[3]], [*own[:3], *own[3]]
    if len(flat) != len(expected) or not np.allclose(flat, expected, rtol=1e-6):
        of = "length, sensor spacing, one_sided and section lengths"
        raise InputError("believed.calibration", name, found, f"{of} of the finger are {own}")
    assert isinstance(curve, ResponseCurve)  # as a scenario gives it
    response = CalibratedResponse(curve, tuple(config.gains), tuple(config.offsets))
    return replace(layout, finger=softened(finger, config.bend_ratio), response=response)


def save_calibration(calibration: CalibrationConfig, path: Path) -> None:
    """Writes a calibration."""
    with atomic_file(path) as partial:
        partial.write_text(yaml_dump(asdict(calibration)), encoding="utf-8")


def load_calibration(file: str) -> CalibrationConfig:
    """Reads what `save_calibration` wrote.

    Raises:
        InputError: if the file is missing, no calibration, or what is in it cannot be.
    """
    path = model_path(file)
    document = read_yaml(path)
    check_document(path, document, CalibrationConfig)
    config: CalibrationConfig = yaml_load_typed(schema=CalibrationConfig, data=yaml_dump(document))
    for name, finger in config.fingers.items():
        _check(path, f"fingers.{name}", finger)
    return config


def _identity(layout: SensorLayout) -> tuple[float, float, bool, list[float]]:
    return layout.finger.length, layout.finger.sensor_spacing, layout.one_sided, layout.rest_lengths.tolist()


def _check(path: Path, field: str, config: FingerCalibrationConfig) -> None:
    if not 0 < config.bend_ratio < math.inf:
        raise InputError(path, f"{field}.bend_ratio", config.bend_ratio, "give a finite number above 0")
    if not all(0 < gain < math.inf for gain in config.gains):
        raise InputError(path, f"{field}.gains", config.gains, "give finite numbers above 0")
    fits = len(config.offsets) == len(config.gains) and all(map(math.isfinite, config.offsets))
    if not fits:
        raise InputError(path, f"{field}.offsets", config.offsets, "give a finite number for every gain")
