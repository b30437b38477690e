"""YAML text from users -> plain data: the only place where it is parsed."""

import copy
import unicodedata
from functools import lru_cache
from pathlib import Path
from typing import Any

import yaml
from pydrake.common.yaml import yaml_load_data

from soft_gripper.errors import InputError, first_line, in_one_line
from soft_gripper.files.number import is_number
from soft_gripper.files.text import read_text

_DEEPEST_VALUE = 40  # mappings and lists inside each other
_LARGEST = 100_000  # values; those of an alias count every time
_TAGS = ("!Rpy",)  # Drake's, of poses; others are of random quantities


def read_yaml(path: Path) -> Any:
    """The data of a file; raises as `parse_yaml` and `read_text`."""
    return parse_yaml(path, read_text(path))


def parse_yaml(where: Path | str, text: str) -> Any:
    """The data of YAML text: mappings with text as keys, lists, text, numbers, true, false and null.

    Keys of the outermost mapping that begin with _ are templates, and are left out. A tag is the key `_tag`.

    Raises:
        InputError: if the text is not YAML, contains anything else, repeats a key, or is nested or repeated too deeply.
    """
    return copy.deepcopy(_parsed(where, text))


@lru_cache(maxsize=16)  # a sweep reads the same file for every run
def _parsed(where: Path | str, text: str) -> Any:
    name = Path(where).name
    try:
        _check_size(where, text)
        data = yaml_load_data(text, private=True)
    except yaml.YAMLError as error:
        raise InputError(where, "file", name, f"is not YAML: {' '.join(str(error).split())}") from None
    except InputError:
        raise
    except ValueError as error:  # of numbers and dates
        raise InputError(where, "file", name, f"holds what is no value: {in_one_line(first_line(error))}") from None
    _check_plain(where, data, "")
    return {key: data[key] for key in data if not key.startswith("_")} if isinstance(data, dict) else data


class _Open:
    """A mapping or list that is being read."""

    def __init__(self, event: Any):
        self.anchor, self.size = event.anchor, 1
        self.keys: set[str] | None = set() if isinstance(event, yaml.MappingStartEvent) else None
        self.at_key = True


def _check_size(where: Path | str, text: str) -> None:
    """Checks the parser's events, which need no recursion for what is nested."""
    sizes: dict[str, int] = {}
    path = [_Open(yaml.SequenceStartEvent(None, None, True))]
    for event in yaml.parse(text, Loader=yaml.SafeLoader):
        if isinstance(event, yaml.CollectionStartEvent):
            path.append(_Open(event))
        elif isinstance(event, yaml.CollectionEndEvent):
            closed = path.pop()
            _count(where, path[-1], closed.size, "")
            sizes[closed.anchor] = closed.size
        elif isinstance(event, yaml.AliasEvent):
            if event.anchor not in sizes:
                raise InputError(where, "alias", event.anchor, "stands inside what it stands for, or before it")
            _count(where, path[-1], sizes[event.anchor], "")
        elif isinstance(event, yaml.ScalarEvent):
            _count(where, path[-1], 1, event.value)
            sizes[event.anchor] = 1
            _check_number(where, event)
        if len(path) > _DEEPEST_VALUE:
            raise InputError(
                where, "depth", len(path), f"give no more than {_DEEPEST_VALUE} lists or mappings in each other"
            )


def _check_number(where: Path | str, event: yaml.ScalarEvent) -> None:
    """Checks that what YAML takes for a number is one to everybody: not 1_0, 0x10, octal 010, or 1:30 of base 60."""
    text = event.value
    resolvers = yaml.SafeLoader.yaml_implicit_resolvers.get(text[:1], ()) if event.implicit[0] else ()
    kinds = {tag.rpartition(":")[2] for tag, expression in resolvers if expression.match(text)}
    size = text.lower().lstrip("+-")
    is_decimal = is_number(text) and not ("int" in kinds and size.startswith("0") and size != "0")
    if kinds & {"int", "float"} and not is_decimal and size not in (".inf", ".nan"):
        raise InputError(where, "number", text, "give a decimal number, such as 10 or 1.5; put text in quotes")


def _count(where: Path | str, holder: _Open, size: int, key: str) -> None:
    """Counts a value, or a key, of the mapping or list that contains it."""
    holder.size += size
    if holder.size > _LARGEST:
        raise InputError(where, "size", holder.size, f"give no more than {_LARGEST} values")
    if holder.keys is not None and holder.at_key and key:
        if key in holder.keys and key != "<<":
            raise InputError(where, "key", key, "appears more than once")
        holder.keys.add(key)
    holder.at_key = not holder.at_key


def _check_plain(where: Path | str, value: Any, field: str) -> None:
    if isinstance(value, dict):
        for key, item in value.items():
            if not isinstance(key, str):
                raise InputError(where, field or "key", key, "give text as the key; put it in quotes")
            _check_plain(where, item, f"{field}.{key}" if field else key)
        if value.get("_tag", _TAGS[0]) not in _TAGS:
            raise InputError(where, field, value["_tag"], f"no such tag here; known: {', '.join(_TAGS)}")
    elif isinstance(value, list):
        for i, item in enumerate(value):
            _check_plain(where, item, f"{field}[{i}]")
    elif isinstance(value, str):
        if any(unicodedata.category(char) in ("Cc", "Cs") and char not in "\n\t" for char in value):
            raise InputError(where, field, value, "leave out control characters and halves of characters")
    elif not isinstance(value, int | float | None):
        raise InputError(where, field, value, "give text, in quotes, or a number")
