"""Calibration files: their schema, and how they are read and applied."""

import math
from collections.abc import Iterator
from dataclasses import dataclass, field, replace

import numpy as np

from soft_gripper.errors import InputError
from soft_gripper.files.document import load_config
from soft_gripper.files.yaml_text import read_yaml
from soft_gripper.fingers.statics import softened, strengthened
from soft_gripper.quantity import Violation, quantity
from soft_gripper.scenario.fitted_states_config import FittedStatesConfig
from soft_gripper.scenario.model_files import model_path
from soft_gripper.sensors.calibrated_states import DRIVE, CalibratedStates
from soft_gripper.sensors.measurement import MeasurementModel
from soft_gripper.sensors.response_curve import CalibratedResponse, ResponseCurve
from soft_gripper.sensors.sensor_layout import SensorLayout, strain_sensors


@dataclass
class FingerCalibrationConfig:
    """The calibration of one finger, relative to its nominal model, and which finger it was."""

    length: float = quantity(0.0, "m")
    sensor_spacing: float = quantity(0.0, "m")
    one_sided: bool = False
    section_lengths: list[float] = quantity([], "m")  # from the base to the tip
    bend_ratio: float = quantity(1.0, above=0)  # bend under the same pressure over that of the nominal model
    bend_variation: float = quantity(0.0, above=-1, below=1)  # by which it changes from the middle to the tip
    strength: float = quantity(1.0, above=0)  # stiffness and pressure torque over the nominal ones, by measured forces
    gains: list[float] = quantity([], above=0)  # of the strain of every reading
    offsets: list[float] = field(default_factory=list)  # of every reading, extension ratio
    response_curvature: float = 0.0  # of all readings: they are of s + curvature s^2, with the strain s
    pressure_offset: float = quantity(0.0, "Pa")  # what the pressure sensor reads too much
    residual: float = 0.0  # root mean square of the residuals, extension ratio
    # Standard deviations, of which estimators use those of the bend; they use the hysteresis, but no drift, friction,
    # strength_std or doubts
    bend_ratio_std: float = quantity(0.0, least=0)
    bend_variation_std: float = quantity(0.0, least=0)
    bend_gain_std: float = quantity(0.0, least=0)  # of the product of gain and bend of a reading, as a share
    strength_std: float = quantity(0.0, least=0)  # 0 if no force was measured
    friction: float = 0.0  # of the finger with what measured its force, positive toward the tip
    gain_stds: list[float] = quantity([], least=0)
    offset_stds: list[float] = quantity([], least=0)
    response_curvature_std: float = quantity(0.0, least=0)
    pressure_offset_std: float = quantity(0.0, "Pa", least=0)
    hysteresis: float = 0.0  # loop width, share of the stroke
    drifts: list[float] = quantity([], "1/s")  # of the extension ratio of every reading
    # If not, a common gain and the bend per pressure are known only as well as the gains were before.
    tip_measured: bool = False
    doubtful: list[str] = field(default_factory=list)  # holds of recordings that are not free bending
    # States of the calibration: strains path after path, torque of the drive at the first joint, gravity along x and z
    fitted: FittedStatesConfig | None = None

    def violations(self) -> Iterator[Violation]:
        if len(self.offsets) != len(self.gains):
            yield "offsets", self.offsets, f"must be {len(self.gains)} numbers, one for every gain"
        if self.fitted is not None and len(self.fitted.names) != len(self.gains) + DRIVE:
            yield "fitted.names", self.fitted.names, f"must be {len(self.gains)} readings and {DRIVE} of the drive"
        if self.fitted is not None and len(self.fitted.floor) != 1:
            yield "fitted.floor", self.fitted.floor, "must be one number: that of every strain"


@dataclass
class CalibrationConfig:
    """A calibration of the fingers of a gripper, by their names."""

    assumed: str = ""  # in words
    fingers: dict[str, FingerCalibrationConfig] = field(default_factory=dict)


def apply_calibration(sensors: MeasurementModel, calibration: CalibrationConfig) -> SensorLayout:
    """Nominal layout with the calibration of its finger; raises an InputError if that is for another one."""
    layout = strain_sensors(sensors, "nominal.calibration")
    name, finger, curve = layout.finger.name, layout.finger, layout.response
    if name not in calibration.fingers:
        raise InputError("nominal.calibration", "fingers", list(calibration.fingers), f"has none for '{name}'")
    config = calibration.fingers[name]
    values = config.length, config.sensor_spacing, config.one_sided, config.section_lengths
    expected_values = layout_identity(layout)
    identity, expected = [*values[:3], *values[3]], [*expected_values[:3], *expected_values[3]]
    if len(identity) != len(expected) or not np.allclose(identity, expected, rtol=1e-6):
        quantities = "length, sensor spacing, one_sided and section lengths"
        raise InputError("nominal.calibration", name, values, f"{quantities} of the finger are {expected_values}")
    assert isinstance(curve, ResponseCurve)  # as in a scenario
    response = CalibratedResponse(curve, tuple(config.gains), tuple(config.offsets), config.response_curvature)
    finger = strengthened(softened(finger, config.bend_ratio, config.bend_variation), config.strength)
    finger = replace(finger, pressure_offset=config.pressure_offset)
    kept, states = config.fitted, None
    if kept is not None:
        disagreement = math.inf if kept.disagreement is None else kept.disagreement
        stds = config.bend_ratio_std / config.bend_ratio, config.bend_variation_std
        gain_std = math.hypot(config.bend_gain_std, config.hysteresis) if config.bend_gain_std > 0 else None
        states = CalibratedStates(kept.fitted, kept.widths, disagreement, layout.sections, kept.noise, *stds, gain_std)
    return replace(layout, finger=finger, response=response, calibrated=states)


def load_calibration(file: str) -> CalibrationConfig:
    """Reads a file written by `soft-gripper calibrate`.

    Raises:
        InputError: if the file is missing, is not a calibration, or has impossible values.
    """
    path = model_path(file)
    return load_config(path, read_yaml(path), CalibrationConfig)


def layout_identity(layout: SensorLayout) -> tuple[float, float, bool, list[float]]:
    """Length, sensor spacing, one-sidedness and section lengths, which identify the finger of a calibration."""
    return layout.finger.length, layout.finger.sensor_spacing, layout.one_sided, layout.rest_lengths.tolist()
