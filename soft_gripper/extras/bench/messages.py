"""Messages between a bench and its estimators: numbers by name, in one of four formats.

| format | a message |
|---|---|
| json | an object with a number, null or a list of numbers for each name |
| text | numbers between commas, in an order that both sides know |
| float32, float64 | numbers in that order, packed little-endian |

Whatever arrives is checked before anything is done with it: a message that is too large, has other fields than
described, or a number that is not finite, is malformed. Only `null`, in JSON, says that a sensor was not read.

Another packed format is an entry of `_PACKED_TYPES`.
"""

import json
import math
from collections.abc import Mapping, Sequence
from contextlib import suppress
from typing import Any

import numpy as np

from soft_gripper.arrays import Array
from soft_gripper.errors import InputError
from soft_gripper.files.json_text import parse_json
from soft_gripper.files.number import number

MAX_MESSAGE_BYTES = 65536  # of a message
_MAX_COUNT = 2**53  # beyond, a float is not a whole number
_PACKED_TYPES: dict[str, np.dtype[Any]] = {"float32": np.dtype("<f4"), "float64": np.dtype("<f8")}


class MalformedError(ValueError):
    """A message does not match the description of its bench."""


def decoded(message: bytes, form: str, fields: Sequence[str]) -> dict[str, float]:
    """The numbers of a message by name; NaN: not read.

    Args:
        message: as it arrived.
        form: one of `bench_schema.FORMATS`.
        fields: the names, in the order of a message that has none.

    Raises:
        MalformedError: if it is none of that format.
    """
    if len(message) > MAX_MESSAGE_BYTES:
        raise MalformedError(f"has {len(message)} bytes, more than {MAX_MESSAGE_BYTES}")
    if form == "json":
        return _from_json(message)
    if form == "text":
        return _named_numbers(_from_text(message), fields)
    size = _PACKED_TYPES[form].itemsize
    if len(message) != size * len(fields):
        raise MalformedError(f"has {len(message)} bytes instead of {size * len(fields)}")
    return _named_numbers(np.frombuffer(message, _PACKED_TYPES[form]).astype(float).tolist(), fields)


def select_numbers(values: Mapping[str, float], names: Sequence[str]) -> Array:
    """Selects numbers of a message by name, (len(names),).

    Raises:
        MalformedError: if one is missing, or is no number.
    """
    try:
        numbers = np.array([values[name] for name in names], dtype=float)
    except KeyError as error:
        raise MalformedError(f"has no field {error}") from None
    except (TypeError, ValueError, OverflowError) as error:
        raise MalformedError(f"has a field that is not a number: {error}"[:80]) from None
    if numbers.shape != (len(names),):
        raise MalformedError("has a list where there should be a number")
    return numbers


def count_of(value: float) -> int:
    """Converts a number from a message to the count of the message.

    Raises:
        MalformedError: if it is not a whole number from 0 on.
    """
    if not (0 <= value < _MAX_COUNT and value == int(value)):
        raise MalformedError(f"has the number {value}")
    return int(value)


def encoded(results: Mapping[str, float | Array], form: str) -> bytes:
    """Encodes named scalars and vectors, in some formats as unnamed numbers in order. NaN is null in JSON."""
    if form == "json":
        return (json.dumps({name: _plain_value(value) for name, value in results.items()}) + "\n").encode()
    numbers = np.concatenate([np.ravel(value) for value in results.values()])
    if form == "text":
        return (",".join(f"{value:.9g}" for value in numbers) + "\n").encode()
    return numbers.astype(_PACKED_TYPES[form]).tobytes()


def _from_json(message: bytes) -> dict[str, float]:
    try:
        document = parse_json("message", message)
    except InputError:
        raise MalformedError("is not JSON") from None
    if not isinstance(document, dict):
        raise MalformedError("is not a JSON object")
    return {name: _number(name, value) for name, value in _flat_entries(document)}


def _flat_entries(document: Mapping[str, object]) -> list[tuple[str, object]]:
    """Yields entries of a document; those of a list are named `{name}[0]`, `{name}[1]` ..."""
    entries: list[tuple[str, object]] = []
    for name, value in document.items():
        entries += (
            [(f"{name}[{i}]", entry) for i, entry in enumerate(value)] if isinstance(value, list) else [(name, value)]
        )
    return entries


def _number(name: str, value: object) -> float:
    if value is None:
        return math.nan
    if isinstance(value, int | float) and not isinstance(value, bool):
        with suppress(OverflowError):  # of a whole number with hundreds of digits
            if math.isfinite(size := float(value)):
                return size
    raise MalformedError(f"has {name} = {value!r}"[:80])


def _from_text(message: bytes) -> list[float]:
    try:
        return [number(entry) for entry in message.decode("ascii").split(",")]
    except ValueError:
        raise MalformedError("is not numbers between commas") from None


def _named_numbers(numbers: Sequence[float], fields: Sequence[str]) -> dict[str, float]:
    if len(numbers) != len(fields):
        raise MalformedError(f"has {len(numbers)} numbers instead of {len(fields)}")
    if not all(map(math.isfinite, numbers)):
        raise MalformedError("has a number that is not finite")
    return dict(zip(fields, numbers, strict=True))


def _plain_value(value: float | Array) -> object:
    if isinstance(value, np.ndarray):
        return [entry if math.isfinite(entry) else None for entry in value.ravel().tolist()]
    return value if math.isfinite(value) else None
