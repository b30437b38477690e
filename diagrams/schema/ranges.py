"""What a number in a scenario may be."""

import math
from pathlib import Path

from soft_gripper.errors import InputError


def require(fine: bool, where: Path | str, field: str, value: object, expected: str) -> None:
    """Raises an InputError unless `fine`."""
    if not fine:
        raise InputError(where, field, value, expected)


def positive(value: float) -> bool:
    """Finite and above zero."""
    return math.isfinite(value) and value > 0


def not_negative(value: float) -> bool:
    """Finite and not below zero."""
    return math.isfinite(value) and value >= 0
