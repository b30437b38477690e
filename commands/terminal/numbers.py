"""Numbers that options give."""

import os
from contextlib import suppress

from soft_gripper.errors import InputError

MOST_SEED = 2**32 - 1
_MOST_JOBS = 256
_DIGITS = 10


def whole_number(command: str, option: str, text: str, least: int, most: int = 10_000) -> int:
    """The number that an option gives.

    Raises:
        InputError: unless it is a whole number from `least` to `most`, by default the most that anybody waits for.
    """
    number = int(text) if text.isascii() and text.isdecimal() and len(text) <= _DIGITS else None
    if number is None or not least <= number <= most:
        raise InputError(command, option, text, f"give a whole number of at least {least}, {most} at most")
    return number


def number_from_zero(command: str, option: str, text: str, most: float) -> float:
    """The number that an option gives.

    Raises:
        InputError: unless it is a number from 0 to `most`.
    """
    with suppress(ValueError):
        if 0 <= (number := float(text)) <= most:
            return number
    raise InputError(command, option, text, f"give a number from 0 to {most:g}")


def number_of_jobs(command: str, text: str | None) -> int:
    """The processes that --jobs gives; without it, one a core.

    Raises:
        InputError: unless it is a whole number that a machine may bear.
    """
    return os.cpu_count() or 1 if text is None else whole_number(command, "--jobs", text, 1, _MOST_JOBS)
