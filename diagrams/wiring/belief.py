"""What the estimators believe of a finger and its sensors, from the simulated ones and what a scenario changes."""

import math
import os
from dataclasses import fields, replace
from typing import Any

from soft_gripper.diagrams.loading.calibration_file import calibrated, load_calibration
from soft_gripper.diagrams.loading.model_files import model_path
from soft_gripper.diagrams.schema.scenario import BelievedConfig, SensorConfig
from soft_gripper.diagrams.wiring.sensors import sensor_layout
from soft_gripper.errors import InputError
from soft_gripper.fingers.cross_section import CrossSection
from soft_gripper.fingers.finger import Finger
from soft_gripper.fingers.urdf import expand_urdf
from soft_gripper.sensors.sensor_layout import SensorLayout

_OF_SECTION = tuple(field.name for field in fields(CrossSection))
_OF_FINGER = ("length", "relaxation_time", "sensor_spacing")
_FAR = 20.0  # times the simulated value: more is taken for a change whose "%" was forgotten
_EXPECTED = 'give a number, or a change such as "+10 %"'


def believed_layout(finger: Finger, sensor: SensorConfig, believed: BelievedConfig) -> SensorLayout:
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
    try:
        sections = {end: _changed(getattr(found, end), believed, _OF_SECTION) for end in ("base", "tip")}
        return replace(_changed(found, believed, _OF_FINGER), **sections)
    except InputError as error:
        raise (error if error.where == "believed" else error.inside("believed")) from None


def describe_belief(believed: BelievedConfig) -> str:
    """The belief in a few words, for tables."""
    changes = [f"{name} {text}" for name in (*_OF_SECTION, *_OF_FINGER) if (text := getattr(believed, name))]
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


def _changed(part: Any, believed: BelievedConfig, names: tuple[str, ...]) -> Any:
    texts = {name: getattr(believed, name) for name in names}
    return replace(
        part, **{name: _value(name, text, getattr(part, name)) for name, text in texts.items() if text is not None}
    )


def _value(name: str, text: str, simulated: float) -> float:
    """What a change leads to."""
    number, percent, rest = str(text).partition("%")
    try:
        value = float(number)
    except ValueError:
        value = math.nan
    relative, sign = bool(percent), number.strip()[:1]
    wrong = rest.strip() or (relative and sign not in ("+", "-")) or (not relative and sign == "+")
    if wrong or not math.isfinite(value):
        raise InputError("believed", name, text, _EXPECTED)
    if not relative and value > 0 and not 1 / _FAR <= value / simulated <= _FAR:
        expected = f'is far from the simulated {simulated:g}; a change is written "+10 %"'
        raise InputError("believed", name, text, expected)
    return simulated * (1 + value / 100) if relative else value
