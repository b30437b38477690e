"""Numbers that options give."""

import math
from contextlib import suppress

from soft_gripper.errors import InputError


def whole_number(command: str, option: str, text: str, least: int) -> int:
    """The number that an option gives.

    Raises:
        InputError: unless it is a whole number of at least `least`.
    """
    if not text.isdecimal() or int(text) < least:
        raise InputError(command, option, text, f"give a whole number of at least {least}")
    return int(text)


def number_from_zero(command: str, option: str, text: str) -> float:
    """The number that an option gives.

    Raises:
        InputError: unless it is finite and at least 0.
    """
    with suppress(ValueError):
        if 0 <= (number := float(text)) < math.inf:
            return number
    raise InputError(command, option, text, "give a number of at least 0")
