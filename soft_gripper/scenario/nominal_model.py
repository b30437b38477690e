"""The nominal model of a finger and its sensors, from the simulated ones and the changes of a scenario."""

import os
from dataclasses import dataclass, field, replace

from soft_gripper.errors import InputError
from soft_gripper.fingers.finger import Finger
from soft_gripper.fingers.urdf import expand_urdf
from soft_gripper.scenario.calibration_file import CalibrationConfig, apply_calibration, load_calibration
from soft_gripper.scenario.finger_changes import FINGER_PATHS, changed_finger
from soft_gripper.scenario.model_files import model_path
from soft_gripper.scenario.schema import NominalConfig, SensorConfig
from soft_gripper.scenario.sensor_presets import sensor_layout
from soft_gripper.sensors.measurement import MeasurementModel


@dataclass(frozen=True)
class NominalModel:
    """The nominal model of a scenario, with the contents of the files that it names."""

    config: NominalConfig = field(default_factory=NominalConfig)
    fingers: tuple[Finger, ...] = ()  # of `config.file`
    calibration: CalibrationConfig | None = None

    def layout(self, finger: Finger, sensor: SensorConfig) -> MeasurementModel:
        """The nominal sensors and finger; raises an InputError if a change or the calibration does not fit."""
        response = sensor.response if self.config.response is None else self.config.response
        layout = sensor_layout(self.finger(finger), replace(sensor, response=response))
        return layout if self.calibration is None else apply_calibration(layout, self.calibration)

    def finger(self, finger: Finger) -> Finger:
        """The nominal finger; raises as `layout`."""
        nominal = finger
        if self.config.file is not None:
            candidates = [entry for entry in self.fingers if entry.name == finger.name] or [*self.fingers]
            if len(candidates) != 1:
                names = ", ".join(entry.name for entry in self.fingers) or "none"
                expected = f"holds no finger '{finger.name}', nor a single one; it has {names}"
                raise InputError("nominal", "file", self.config.file, expected)
            nominal = replace(candidates[0], name=finger.name, segments=finger.segments)
        nominal = nominal if self.config.creep else replace(nominal, creep=())
        return changed_finger(nominal, "nominal", self.config.finger)


def read_nominal_model(config: NominalConfig) -> NominalModel:
    """Reads the files that a nominal model names; raises an InputError if one is missing, or has not what it must."""
    fingers: tuple[Finger, ...] = ()
    if config.file is not None:
        path = model_path(config.file)
        if not os.path.isfile(path):
            raise InputError("nominal", "file", config.file, f"there is no file {path}")
        fingers = tuple(expand_urdf(path).fingers)
    return NominalModel(config, fingers, None if config.calibration is None else load_calibration(config.calibration))


def describe_nominal_model(nominal: NominalConfig) -> str:
    changes = [f"{path} {nominal.finger[path]}" for path in FINGER_PATHS if path in nominal.finger]
    creep = [] if nominal.creep else ["no creep"]
    response = ["response"] if nominal.response is not None else []
    files = [file.rpartition("/")[2] if file is not None else "" for file in (nominal.file, nominal.calibration)]
    return "; ".join(filter(None, [files[0], *changes, *creep, *response, files[1]])) or "as simulated"
