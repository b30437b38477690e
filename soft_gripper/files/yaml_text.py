"""YAML text from users -> plain data: the only place where it is parsed."""

import copy
import unicodedata
from collections.abc import Sequence
from functools import lru_cache
from pathlib import Path
from typing import Any

import yaml

from soft_gripper.errors import InputError, first_line, single_line
from soft_gripper.files.number import is_number
from soft_gripper.files.text import read_text

_MAX_TEXT = 300_000  # characters: a second of work
_MAX_SCALAR = 50_000  # characters of a value
_MAX_DEPTH = 40  # mappings and lists inside each other
_MAX_VALUES = 40_000  # those of an alias count every time
_MAX_NUMBER = 2**63  # of whole numbers
_POSE_TAGS = ("!Rpy", "!AngleAxis", "!Identity")  # Drake's, of poses; others are of random quantities


def read_yaml(path: Path) -> Any:
    """The data of a file; raises as `parse_yaml` and `read_text`."""
    return parse_yaml(path, read_text(path))


def parse_yaml(where: Path | str, text: str) -> Any:
    """The data of YAML text: mappings with text as keys, lists, text, numbers, true, false and null.

    Keys of the outermost mapping that begin with _ are templates, and are left out. A tag is the key `_tag`.

    Raises:
        InputError: if the text is not YAML, contains anything else, repeats a key, or is nested or repeated too deeply.
    """
    return copy.deepcopy(_parse(where, text))


@lru_cache(maxsize=16)  # a sweep reads the same file for every run
def _parse(where: Path | str, text: str) -> Any:
    name = Path(where).name
    if len(text) > _MAX_TEXT:
        raise InputError(where, "length", len(text), f"give no more than {_MAX_TEXT} characters")
    try:
        data = _Loader(where, text).get_single_data()
    except yaml.YAMLError as error:
        raise InputError(where, "file", name, f"is not YAML: {' '.join(str(error).split())}") from None
    except InputError:
        raise
    except (ValueError, OverflowError) as error:  # of numbers and dates
        raise InputError(where, "file", name, f"holds what is no value: {single_line(first_line(error))}") from None
    _check_plain(where, data, "")
    return {key: data[key] for key in data if not key.startswith("_")} if isinstance(data, dict) else data


class _Loader(yaml.SafeLoader):
    """Reads tags as Drake's `yaml_load_data` does; the values that a text stands for are counted before they exist."""

    def __init__(self, where: Path | str, text: str):
        super().__init__(text)
        self._where, self._depth = where, 0
        self._sizes: dict[yaml.Node, int] = {}  # values in each node that is complete

    def compose_scalar_node(self, anchor: str | None) -> yaml.ScalarNode:
        node = super().compose_scalar_node(anchor)
        self._require(len(node.value) <= _MAX_SCALAR, "length", len(node.value), f"{_MAX_SCALAR} characters of a value")
        self._count(node, 1)
        kind, size = node.tag.rpartition(":")[2], node.value.lower().lstrip("+-")
        if node.style is None and kind in ("int", "float") and size not in (".inf", ".nan"):
            is_octal = kind == "int" and size.startswith("0") and size != "0"
            if is_octal or not is_number(node.value):  # such as 1_0, 0x10, or 1:30 of base 60
                expected = "give a decimal number, such as 10 or 1.5; put text in quotes"
                raise InputError(self._where, "number", node.value, expected)
        return node

    def compose_sequence_node(self, anchor: str | None) -> yaml.SequenceNode:
        self._descend()
        node = super().compose_sequence_node(anchor)
        self._ascend(node, node.value)
        return node

    def compose_mapping_node(self, anchor: str | None) -> yaml.MappingNode:
        self._descend()
        node = super().compose_mapping_node(anchor)
        keys = [key.value for key, _ in node.value if isinstance(key, yaml.ScalarNode) and key.value != "<<"]
        if len(set(keys)) < len(keys):
            key = next(key for i, key in enumerate(keys) if key in keys[:i])
            raise InputError(self._where, "key", key, "appears more than once")
        self._ascend(node, [part for pair in node.value for part in pair])
        return node

    def _descend(self) -> None:
        self._depth += 1
        self._require(self._depth <= _MAX_DEPTH, "depth", self._depth, f"{_MAX_DEPTH} lists or mappings in each other")

    def _ascend(self, node: yaml.Node, parts: Sequence[yaml.Node]) -> None:
        self._depth -= 1
        if open_part := next((part for part in parts if part not in self._sizes), None):
            (alias,) = (name for name, value in self.anchors.items() if value is open_part)
            raise InputError(self._where, "alias", alias, "stands inside what it stands for")
        self._count(node, 1 + sum(map(self._sizes.__getitem__, parts)))

    def _count(self, node: yaml.Node, size: int) -> None:
        self._sizes[node] = size
        count = max(size, len(self._sizes))
        self._require(count <= _MAX_VALUES, "size", count, f"{_MAX_VALUES} values")

    def _require(self, is_valid: bool, field: str, number: int, limit: str) -> None:
        if not is_valid:
            raise InputError(self._where, field, number, f"give no more than {limit}")


_Loader.add_multi_constructor("", lambda loader, tag, node: loader.construct_mapping(node) | {"_tag": tag})


def _check_plain(where: Path | str, value: Any, field: str) -> None:
    if isinstance(value, dict):
        for key, item in value.items():
            if not isinstance(key, str):
                raise InputError(where, field or "key", key, "give text as the key; put it in quotes")
            _check_plain(where, item, f"{field}.{key}" if field else key)
        if value.get("_tag", _POSE_TAGS[0]) not in _POSE_TAGS:
            raise InputError(where, field, value["_tag"], f"no such tag here; known: {', '.join(_POSE_TAGS)}")
    elif isinstance(value, list):
        for i, item in enumerate(value):
            _check_plain(where, item, f"{field}[{i}]")
    elif isinstance(value, str):
        if any(unicodedata.category(char) in ("Cc", "Cs") and char not in "\n\t" for char in value):
            raise InputError(where, field, value, "leave out control characters and halves of characters")
    elif isinstance(value, int) and abs(value) >= _MAX_NUMBER:
        raise InputError(where, field, value, f"give a whole number below {_MAX_NUMBER}")
    elif not isinstance(value, int | float | None):
        raise InputError(where, field, value, "give text, in quotes, or a number")
