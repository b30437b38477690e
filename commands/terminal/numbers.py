"""Numbers that options give."""

import math
from contextlib import suppress

from soft_gripper.errors import InputError

_MOST = 1_000_000  # of trials, simulations, processes, and seeds
_DIGITS = 9


def whole_number(command: str, option: str, text: str, least: int) -> int:
    """The number that an option gives.

    Raises:
        InputError: unless it is a whole number of at least `least`, and no larger than can be meant.
    """
    number = int(text) if text.isascii() and text.isdecimal() and len(text) <= _DIGITS else None
    if number is None or not least <= number <= _MOST:
        raise InputError(command, option, text, f"give a whole number of at least {least}, {_MOST} at most")
    return number


def number_from_zero(command: str, option: str, text: str) -> float:
    """The number that an option gives.

    Raises:
        InputError: unless it is finite and at least 0.
    """
    with suppress(ValueError):
        if 0 <= (number := float(text)) < math.inf:
            return number
    raise InputError(command, option, text, "give a number of at least 0")
