"""Whether the fields of a dataclass that are declared as numbers hold numbers."""

from dataclasses import fields
from numbers import Integral, Real
from typing import Any

from soft_gripper.errors import InputError

_KINDS: dict[object, tuple[type, str]] = {float: (Real, "a number"), int: (Integral, "a whole number")}


def check_numbers(where: str, values: Any) -> None:
    """Looks at the fields of a dataclass whose type is float or int; numbers of numpy are numbers.

    Raises:
        InputError: for the first that holds something else.
    """
    for field in fields(values):
        value = getattr(values, field.name)
        if expected := mistyped(field.type, value):
            raise InputError(where, field.name, value, expected)


def mistyped(kind: object, value: object) -> str | None:
    """What a value would have to be in a field of type float or int; None if it is, or the type is another."""
    number, expected = _KINDS.get(kind, (object, ""))
    is_fine = isinstance(value, number) and not (expected and isinstance(value, bool))
    return None if is_fine else f"give {expected}"
