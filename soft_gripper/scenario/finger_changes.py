"""Changes that a scenario makes to the fingers of a file: values, or "+10 %" of what the file gives."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import fields, replace
from typing import Any, TypeVar

from pydrake.math import RollPitchYaw, RotationMatrix

from soft_gripper.errors import InputError
from soft_gripper.files.number import number
from soft_gripper.fingers.cross_section import CrossSection
from soft_gripper.fingers.finger import Finger
from soft_gripper.fingers.finger_element import FingerElement
from soft_gripper.fingers.paths import Chamber
from soft_gripper.scenario.schema import FingerChanges, FingerConfig

OF_SECTION = tuple(field.name for field in fields(CrossSection))
OF_FINGER = ("length", "relaxation_time", "sensor_spacing")
_OF_CHAMBER = {"chamber_width": "width", "chamber_thickness": "thickness"}  # fields of a Chamber, by their changes
_ALL = "all"
_SUSPICIOUS_FACTOR = 20.0  # times the value so far; a larger change is taken for one whose "%" was forgotten
_EXPECTED = 'give a number, or a change such as "+10 %"'


def check_names(where: str, configs: Mapping[str, FingerConfig], names: Sequence[str]) -> None:
    """Raises an InputError unless changes are for "all" or for one of the named fingers."""
    known = (_ALL, *names) if names else ()
    for name in configs:
        if name not in known:
            raise InputError(where, "fingers", name, f"no such finger; known: {', '.join(known) or 'none'}")


def mounted_finger(mounted: FingerElement, where: str, configs: Mapping[str, FingerConfig]) -> FingerElement:
    """A finger and its place with the changes for all and, on top of them, its own; see `configured_finger`."""
    turn = RollPitchYaw(mounted.rpy).ToRotationMatrix()
    for name in (_ALL, mounted.finger.name):
        if (config := configs.get(name)) and config.tilt is not None:
            turn = turn @ RotationMatrix.MakeYRotation(_value(f"{where}.fingers.{name}", "tilt", config.tilt, 0.0))
    is_tilted = any(config.tilt is not None for config in configs.values())
    angles = RollPitchYaw(turn)
    rpy = tuple(map(float, angles.vector())) if is_tilted else mounted.rpy
    return replace(mounted, finger=configured_finger(mounted.finger, where, configs), rpy=rpy)


def configured_finger(finger: Finger, where: str, configs: Mapping[str, FingerConfig]) -> Finger:
    """A finger with the changes for all and, on top of them, its own.

    Args:
        finger: as its file gives it.
        where: the model, for messages.
        configs: by names of fingers, or for "all".

    Raises:
        InputError: if a change is not a number, or the result cannot be a finger.
    """
    for name in (_ALL, finger.name):
        if config := configs.get(name):
            place = f"{where}.fingers.{name}"
            finger = changed_finger(finger, place, config, (*OF_FINGER, "shear_factor"))
            finger = _replaced(finger, contact=changed_part(finger.contact, place, config, ["friction"]))
            if config.yields is not None:
                finger = _with(finger, place, yields=tuple(config.yields.split()))
    return finger


def _with(finger: Finger, where: str, **changes: Any) -> Finger:
    try:
        return _replaced(finger, **changes)
    except InputError as error:
        raise InputError(where, error.field, error.value, error.expected) from None


_D = TypeVar("_D")


def _replaced(part: _D, **changes: Any) -> _D:
    """A dataclass with changes; itself if they change nothing, since a copy is checked anew."""
    return part if all(getattr(part, name) == value for name, value in changes.items()) else replace(part, **changes)  # type: ignore[type-var]


def changed_finger(finger: Finger, where: str, changes: FingerChanges, of_finger: Sequence[str]) -> Finger:
    """A finger with changes of all sections, chambers and the fields `of_finger`; raises as `configured_finger`."""
    if finger.chambers and changes.chamber_center is not None:
        expected = "leave it out: its chambers lie where <chamber> has them"
        raise InputError(where, "chamber_center", changes.chamber_center, expected)
    of_section = [name for name in OF_SECTION if not (finger.chambers and name in _OF_CHAMBER)]
    try:
        alike = changed_part(finger, where, changes, of_finger)
        chambers = tuple(_changed_chamber(chamber, where, changes) for chamber in finger.chambers)
        base, *between, tip = (changed_part(each, where, changes, of_section) for each in alike.cross_sections)
        return _replaced(alike, base=base, sections=tuple(between), tip=tip, chambers=chambers)
    except InputError as error:
        raise (error if error.where == where else error.inside(where)) from None


def changed_part(part: Any, where: str, changes: FingerChanges, names: Sequence[str]) -> Any:
    """A dataclass with changes of some of its fields."""
    texts = {name: getattr(changes, name) for name in names if getattr(changes, name) is not None}
    return _replaced(part, **{name: _value(where, name, text, getattr(part, name)) for name, text in texts.items()})


def _changed_chamber(chamber: Chamber, where: str, changes: FingerChanges) -> Chamber:
    """A chamber with changes of its width and thickness at every station."""
    values = {}
    for name, field in _OF_CHAMBER.items():
        if (text := getattr(changes, name)) is not None:
            values[field] = tuple(_value(where, name, text, before) for before in getattr(chamber, field))
    return _replaced(chamber, **values)


def _value(where: str, name: str, text: str, before: float) -> float:
    """The value after a change."""
    size, percent, rest = str(text).partition("%")
    try:
        value = number(size)
    except ValueError:
        value = math.nan
    relative, sign = bool(percent), size.strip()[:1]
    wrong = rest.strip() or (relative and sign not in ("+", "-")) or (not relative and sign == "+")
    if wrong or not math.isfinite(value):
        raise InputError(where, name, text, _EXPECTED)
    if not relative and value > 0 and before > 0 and not 1 / _SUSPICIOUS_FACTOR <= value / before <= _SUSPICIOUS_FACTOR:
        raise InputError(where, name, text, f'is far from the simulated {before:g}; a change is written "+10 %"')
    return before * (1 + value / 100) if relative else value
