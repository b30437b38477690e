"""The setup of an estimator in the studies: its sensors, its nominal model and the uncertainty that it declares.

In: numbers and labels by which tables name a setup. Out: errors of the sensors, sensors of a finger, nominal finger and
uncertainty. Another kind of model is a label, in MODELS if contacts are estimated with it, and what it declares in
`EstimatorSetup.uncertainty`.
"""

import math
from dataclasses import dataclass, replace

from soft_gripper.estimators.uncertainty import EXACT, Uncertainty, uncertainty_of
from soft_gripper.fingers.finger import Finger
from soft_gripper.scenario.nominal_model import describe_nominal_model, read_nominal_model
from soft_gripper.scenario.schema import NominalConfig, SensorConfig, StrainErrorsConfig
from soft_gripper.scenario.sensor_presets import sensor_layout, strain_errors
from soft_gripper.sensors.measurement import MeasurementModel
from soft_gripper.sensors.strain_errors import StrainErrors

REALISTIC = "realistic"  # preset of the errors of sensors
MODELS = "exact, declared", "wrong, defaults", "wrong, called exact"
NOMINAL = "as simulated, defaults"
_ERROR_SIZES = ("creep", "hysteresis", "gain_error", "offset", "drift", "low_frequency_noise", "noise")


@dataclass(frozen=True)
class EstimatorSetup:
    """Sensors and nominal model of an estimator."""

    sections: int
    noise: float = 0.0  # errors of the sensors, relative to REALISTIC
    model: str = MODELS[0]  # or NOMINAL; a wrong one has random stiffness and pressure unless these are given
    borders: tuple[float, ...] | None = None  # of the sections, fractions of the length; None: equal sections
    averaged: int = 1  # samples in a reading
    reading: float | None = None  # declared standard deviation of extension ratios; None: follows from the errors
    stiffness: float = 0.0  # relative error of the nominal Young's modulus
    pressure: float = 0.0  # relative error of the measured pressure
    declared: float = 0.0  # relative error of the bend per pressure, unless the model has the default
    calibration: str = "none"  # key of CALIBRATIONS

    @property
    def is_exact(self) -> bool:
        """Whether stiffness and pressure are the nominal ones."""
        return self.model in (MODELS[0], NOMINAL)

    @property
    def errors(self) -> StrainErrors | None:
        """Errors of the sensors; None: they are ideal."""
        preset = strain_errors(SensorConfig(errors=StrainErrorsConfig(preset=REALISTIC)))
        if preset is None or not self.noise:
            return None
        return replace(preset, **{name: self.noise * getattr(preset, name) for name in _ERROR_SIZES})

    @property
    def uncertainty(self) -> Uncertainty:
        """The uncertainty that the estimator declares."""
        sensor_uncertainty = uncertainty_of(self.errors) if self.reading is None else Uncertainty(reading=self.reading)
        if self.model in (MODELS[1], NOMINAL):
            return sensor_uncertainty
        return replace(sensor_uncertainty, bend_per_pressure=math.hypot(EXACT, self.declared))

    @property
    def sensors(self) -> str:
        """Word for the sensors."""
        return REALISTIC if self.noise else "ideal"

    @property
    def nominal(self) -> str:
        """The nominal finger in a few words."""
        return describe_nominal_model(self._nominal)

    def nominal_finger(self, finger: Finger) -> Finger:
        """The nominal finger of a simulated one."""
        return read_nominal_model(self._nominal).finger(finger)

    def layout(self, finger: Finger, kind: str = "sides") -> MeasurementModel:
        """The sensors on a finger, in a layout of `SensorConfig`."""
        borders = None if self.borders is None else list(self.borders)
        return sensor_layout(finger, SensorConfig(sections=self.sections, borders=borders, layout=kind))

    @property
    def _nominal(self) -> NominalConfig:
        return NominalConfig({"youngs_modulus": f"{100 * self.stiffness:+g} %"} if self.stiffness else {})
