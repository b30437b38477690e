"""What the name of a file says of the experiment."""

import re
from pathlib import Path

from soft_gripper.diagrams.hardware.recording_schema import LoadNameConfig, PressureNameConfig
from soft_gripper.diagrams.hardware.units import PRESSURE
from soft_gripper.errors import InputError

_GRAM = 1e-3  # kg


def pressure_in_name(path: Path, ways: list[PressureNameConfig]) -> float | None:
    """The commanded pressure in a file's name, Pa; None if there is none.

    Raises:
        InputError: if what is found is no number.
    """
    for way in ways:
        if found := re.search(way.pattern, path.stem):
            return _number(path, "commanded_pressure", found[1]) * PRESSURE[way.unit]
    return None


def load_in_name(path: Path, load: LoadNameConfig | None) -> float:
    """The mass that hangs on the tip by a file's name, kg; 0 if it names none.

    Raises:
        InputError: if what is found is no number.
    """
    found = re.search(load.pattern, path.stem) if load else None
    if load is None or found is None:
        return 0.0
    return load.masses.get(found[1], _number(path, "load", found[1]) * _GRAM)


def _number(path: Path, field: str, text: str) -> float:
    try:
        return float(text)
    except ValueError:
        raise InputError(path, f"{field}.pattern", text, "is no number; let the group match digits alone") from None
