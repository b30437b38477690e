"""Changes that a scenario makes to the fingers of a file: values, or "+10 %" of what the file gives.

Its key is the path of a number of a `Finger`: `contact.friction`, or `chambers.width`, which is that of every chamber.
A number of a `CrossSection` by itself, such as `width`, is that of every section, or chamber if the finger has some.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import asdict, is_dataclass, replace
from functools import partial
from typing import Any, get_type_hints

from pydrake.math import RollPitchYaw, RotationMatrix

from soft_gripper.errors import InputError
from soft_gripper.files.document import Place, read, unwrap_optional
from soft_gripper.files.number import CHANGE, changed
from soft_gripper.fingers.cross_section import CrossSection
from soft_gripper.fingers.finger import Finger
from soft_gripper.fingers.finger_element import FingerElement
from soft_gripper.quantity import Rule, rules

TILT = "tilt"  # about its bending axis at the base, on top of that of its file; positive: toward the object
# Keys of 0.2, whose recordings have them; others were those of today
FORMER_PATHS = {key: f"contact.{key}" for key in ("friction", "hydroelastic_modulus", "dissipation")}
FORMER_PATHS |= {f"tendon_{key}": f"tendons.{key}" for key in ("stiffness", "friction", "slack")}
_CHAMBER_PATHS = {f"chamber_{key}": f"chambers.{key}" for key in ("width", "thickness")}
_CHAMBER_PATHS["chamber_center"] = "chambers.x"
_ALL_FINGERS = "all"
_SUSPICIOUS_FACTOR = 20.0  # times the value so far; a larger change is taken for one whose "%" was forgotten


def _paths(kind: Any) -> Iterator[tuple[str, Rule]]:
    """Paths of the numbers in a dataclass, and of lists of words, with their rules."""
    for name, hint in get_type_hints(kind).items():
        _, outer, inner = unwrap_optional(hint)
        part = inner if outer is tuple else outer
        if is_dataclass(part):
            yield from ((f"{name}.{path}", rule) for path, rule in _paths(part))
        elif part is float or (part is str and outer is tuple):
            yield name, rules(kind)[name]


_SECTION_PATHS = dict(_paths(CrossSection))
FINGER_PATHS = _SECTION_PATHS | dict(_paths(Finger))
MODEL_PATHS = {TILT: Rule("rad")} | FINGER_PATHS
del MODEL_PATHS["pressure_offset"]  # of nominal fingers


def check_names(where: str, configs: Mapping[str, Mapping[str, str]], names: Sequence[str]) -> None:
    """Raises an InputError unless changes are for "all" or for one of the named fingers."""
    finger_names = (_ALL_FINGERS, *names) if names else ()
    for name in configs:
        if name not in finger_names:
            raise InputError(where, "fingers", name, f"no such finger; known: {', '.join(finger_names) or 'none'}")


def mounted_finger(mounted: FingerElement, where: str, configs: Mapping[str, Mapping[str, str]]) -> FingerElement:
    """A finger and its place with the changes for all and, on top of them, its own.

    Changes are by names of fingers, or for "all". Raises an InputError if one is no number, or the result no finger.
    """
    finger, rpy = mounted.finger, mounted.rpy
    for name in (_ALL_FINGERS, mounted.finger.name):
        place, changes = f"{where}.fingers.{name}", dict(configs.get(name, {}))
        if (tilt := changes.pop(TILT, None)) is not None:
            if "%" in tilt:
                raise InputError(place, TILT, tilt, "must be an angle, rad, which is added to that of the file")
            R_tilt = RotationMatrix.MakeYRotation(_value(place, TILT, tilt, 0.0))
            rpy = tuple(map(float, RollPitchYaw(RollPitchYaw(rpy).ToRotationMatrix() @ R_tilt).vector()))
        finger = changed_finger(finger, place, changes)
    return replace(mounted, finger=finger, rpy=rpy)


def changed_finger(finger: Finger, where: str, changes: Mapping[str, str]) -> Finger:
    """A finger with changes by their paths, those of one section on top of those of all; raises as `mounted_finger`."""
    if not changes:
        return finger
    document: Any = asdict(finger)
    sections = ("base", "tip", "sections") if finger.sections else ("base", "tip")
    for key, text in sorted(changes.items(), key=lambda change: change[0] not in _SECTION_PATHS):
        paths = [f"{section}.{key}" for section in sections] if key in _SECTION_PATHS else [key]
        if finger.chambers and key in _CHAMBER_PATHS:
            paths = [_CHAMBER_PATHS[key]]
        for path in paths:
            document = _apply_change(document, path.split("."), partial(_value, where, key, text))
    return read(document, Finger, Rule(), Place(f"{where}: finger '{finger.name}'"))


def _apply_change(node: Any, path: Sequence[str], change: Callable[[Any], Any]) -> Any:
    """Plain data with a change of the value at a path; a list of numbers counts as one value."""
    if isinstance(node, tuple | list) and node and not isinstance(node[0], str):
        return [_apply_change(entry, path, change) for entry in node]
    if path and node:
        return node | {path[0]: _apply_change(node[path[0]], path[1:], change)}
    return change(node)


def _value(where: str, name: str, text: str, old: Any) -> Any:
    """The value after a change: words, or a number."""
    if old is None or old == ():
        raise InputError(where, name, text, "leave it out: the finger has none")
    if isinstance(old, tuple):
        return tuple(text.split())
    try:
        value = changed(text, old)
    except ValueError:
        raise InputError(where, name, text, f"must be a number, {CHANGE}") from None
    is_comparable = "%" not in text and min(value, old) > 0
    if is_comparable and not 1 / _SUSPICIOUS_FACTOR <= value / old <= _SUSPICIOUS_FACTOR:
        raise InputError(where, name, text, f'is far from the simulated {old:g}; a change is written "+10 %"')
    return value
