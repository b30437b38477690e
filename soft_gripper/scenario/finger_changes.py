"""Fingers with other parameters than their file gives them."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import fields, replace
from typing import Any

from soft_gripper.errors import InputError
from soft_gripper.fingers.cross_section import CrossSection
from soft_gripper.fingers.finger import Finger
from soft_gripper.fingers.finger_parts import ContactMaterial
from soft_gripper.scenario.scenario import FingerChanges, FingerConfig

OF_SECTION = tuple(field.name for field in fields(CrossSection))
OF_FINGER = ("length", "relaxation_time", "sensor_spacing")
_OF_CONTACT = tuple(field.name for field in fields(ContactMaterial))
_ALL = "all"
_FAR = 20.0  # times the value so far: more is taken for a change whose "%" was forgotten
_EXPECTED = 'give a number, or a change such as "+10 %"'


def check_names(where: str, configs: Mapping[str, FingerConfig], names: Sequence[str]) -> None:
    """Raises an InputError unless changes are of "all" or of one of the fingers named."""
    known = (_ALL, *names) if names else ()
    for name in configs:
        if name not in known:
            raise InputError(where, "fingers", name, f"no such finger; known: {', '.join(known) or 'none'}")


def configured_finger(finger: Finger, where: str, configs: Mapping[str, FingerConfig]) -> Finger:
    """A finger with the changes for all and, on top of them, its own.

    Args:
        finger: as its file gives it.
        where: the model, for messages.
        configs: by names of fingers, or for "all".

    Raises:
        InputError: if a change is no number, or leads to what cannot be a finger.
    """
    for name in (_ALL, finger.name):
        if config := configs.get(name):
            place = f"{where}.fingers.{name}"
            finger = changed_finger(finger, place, config, (*OF_FINGER, "shear_factor"))
            finger = replace(finger, contact=changed_part(finger.contact, place, config, _OF_CONTACT))
    return finger


def changed_finger(finger: Finger, where: str, changes: FingerChanges, of_finger: Sequence[str]) -> Finger:
    """A finger with changes of both cross-sections and of the fields `of_finger`; raises as `configured_finger`."""
    try:
        sections = {end: changed_part(getattr(finger, end), where, changes, OF_SECTION) for end in ("base", "tip")}
        return replace(changed_part(finger, where, changes, of_finger), **sections)
    except InputError as error:
        raise (error if error.where == where else error.inside(where)) from None


def changed_part(part: Any, where: str, changes: FingerChanges, names: Sequence[str]) -> Any:
    """A dataclass with changes of some of its fields."""
    texts = {name: getattr(changes, name) for name in names if getattr(changes, name) is not None}
    return replace(part, **{name: _value(where, name, text, getattr(part, name)) for name, text in texts.items()})


def _value(where: str, name: str, text: str, before: float) -> float:
    """What a change leads to."""
    number, percent, rest = str(text).partition("%")
    try:
        value = float(number)
    except ValueError:
        value = math.nan
    relative, sign = bool(percent), number.strip()[:1]
    wrong = rest.strip() or (relative and sign not in ("+", "-")) or (not relative and sign == "+")
    if wrong or not math.isfinite(value):
        raise InputError(where, name, text, _EXPECTED)
    if not relative and value > 0 and before > 0 and not 1 / _FAR <= value / before <= _FAR:
        raise InputError(where, name, text, f'is far from the simulated {before:g}; a change is written "+10 %"')
    return before * (1 + value / 100) if relative else value
