"""JSON text from users -> plain data: the only place where it is parsed."""

import json
from pathlib import Path
from typing import Any

from soft_gripper.errors import InputError, first_line, single_line
from soft_gripper.files.text import read_bytes

_MAX_BYTES = 2**26
_MAX_VALUES = 1_500_000
_MAX_KEYS = 100_000  # of an object
_MAX_DEPTH = 40  # objects and lists inside each other
_MAX_DIGITS = 19  # of a whole number, as 2^63 has


def read_json(path: Path) -> Any:
    """The data of a file; raises as `parse_json` and `read_bytes`."""
    return parse_json(path, read_bytes(path, _MAX_BYTES))


def parse_json(where: Path | str, text: str | bytes, finite: bool = True) -> Any:
    """The data of JSON text; not `finite`: with NaN and Infinity, which many programs write.

    Raises an InputError if the text is not JSON, repeats a key, has a whole number of more than 19 digits or half a
    character, or is nested too deeply or too large.
    """
    try:
        if isinstance(text, bytes):
            text = text.decode(json.detect_encoding(text))
        value_count = text.count("[") + text.count("{")
        count = value_count + text.count(",")
        if count > _MAX_VALUES:
            raise InputError(where, "size", count, f"give no more than {_MAX_VALUES} values")
        data = (_FINITE_DECODER if finite else _DECODER).decode(text)
        if "\\u" in text:
            json.dumps(data, ensure_ascii=False).encode()
    except RecursionError:
        value_count, data = _MAX_VALUES, None
    except InputError:
        raise
    except ValueError as error:
        reason = f"cannot be read as JSON: {single_line(first_line(error))}"
        raise InputError(where, "file", Path(where).name, reason) from None
    level = [data]
    for _ in range(_MAX_DEPTH if value_count > _MAX_DEPTH and data is not None else 0):  # without recursion
        parts = (part for entry in level for part in (entry.values() if isinstance(entry, dict) else entry))
        level = [part for part in parts if isinstance(part, list | dict)]
    if value_count > _MAX_DEPTH and level:
        raise InputError(where, "depth", f"more than {_MAX_DEPTH}", "give fewer lists or objects in each other")
    return data


def _unique_keys(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    if len(pairs) > _MAX_KEYS:
        raise ValueError(f"an object has more than {_MAX_KEYS} keys")
    data = dict(pairs)
    if len(data) < len(pairs):
        names = [name for name, _ in pairs]
        raise ValueError(f"the key {next(name for name in data if names.count(name) > 1)!r} appears more than once")
    return data


def _whole_number(digits: str) -> int:
    if len(digits.lstrip("-")) > _MAX_DIGITS:
        raise ValueError(f"a whole number of {len(digits)} digits")
    return int(digits)


def _refuse_constant(name: str) -> None:
    raise ValueError(f"{name} is not a number of JSON")


_HOOKS: dict[str, Any] = {"object_pairs_hook": _unique_keys, "parse_int": _whole_number}
_DECODER = json.JSONDecoder(**_HOOKS)
_FINITE_DECODER = json.JSONDecoder(**_HOOKS, parse_constant=_refuse_constant)
