"""What the estimators believe of a finger and its sensors, from the simulated ones and what a scenario changes."""

import os
from dataclasses import replace

from soft_gripper.diagrams.wiring.sensors import sensor_layout
from soft_gripper.errors import InputError
from soft_gripper.fingers.finger import Finger
from soft_gripper.fingers.urdf import expand_urdf
from soft_gripper.scenario.calibration_file import calibrated, load_calibration
from soft_gripper.scenario.finger_changes import OF_FINGER, OF_SECTION, changed_finger
from soft_gripper.scenario.model_files import model_path
from soft_gripper.scenario.scenario import BelievedConfig, SensorConfig
from soft_gripper.sensors.measurement import MeasurementModel


def believed_layout(finger: Finger, sensor: SensorConfig, believed: BelievedConfig) -> MeasurementModel:
    """Sensors and finger as the estimators believe them to be.

    Raises:
        InputError: if a change is no number, or leads to what cannot be a finger, or the calibration is of another.
    """
    response = sensor.response if believed.response is None else believed.response
    layout = sensor_layout(believed_finger(finger, believed), replace(sensor, response=response))
    return layout if believed.calibration is None else calibrated(layout, load_calibration(believed.calibration))


def believed_finger(finger: Finger, believed: BelievedConfig) -> Finger:
    """The finger as it is believed to be; raises as `believed_layout`."""
    found = finger if believed.file is None else _from_file(finger, believed.file)
    found = found if believed.creep else replace(found, creep=())
    return changed_finger(found, "believed", believed, OF_FINGER)


def describe_belief(believed: BelievedConfig) -> str:
    """The belief in a few words, for tables."""
    changes = [f"{name} {text}" for name in (*OF_SECTION, *OF_FINGER) if (text := getattr(believed, name))]
    creep = [] if believed.creep else ["no creep"]
    response = ["response"] if believed.response is not None else []
    file = [believed.file.rpartition("/")[2]] if believed.file is not None else []
    calibration = [believed.calibration.rpartition("/")[2]] if believed.calibration is not None else []
    return "; ".join([*file, *changes, *creep, *response, *calibration]) or "as simulated"


def _from_file(finger: Finger, file: str) -> Finger:
    path = model_path(file)
    if not os.path.isfile(path):
        raise InputError("believed", "file", file, f"there is no file {path}")
    fingers = expand_urdf(path, finger.segments).fingers
    named = [other for other in fingers if other.name == finger.name] or list(fingers)
    if len(named) != 1:
        names = ", ".join(other.name for other in fingers) or "none"
        raise InputError("believed", "file", file, f"holds no finger '{finger.name}', nor a single one; it has {names}")
    return replace(named[0], name=finger.name)
