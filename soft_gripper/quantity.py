"""Rules for the fields of a dataclass, declared beside them: unit, range, choices, length of a list.

    period: float = quantity(0.01, "s", above=0)
    gravity: list[float] = quantity([0.0, 0.0, -9.81], "m/s^2", length=3)
    side: str = quantity("inner", known=("inner", "outer"))
    mass: float = field(metadata=valid("kg", above=0))  # must be given

`files/document.py` compares values with these rules; the schema pages of the documentation print them. Rules across
fields are a method `violations` of the dataclass, which yields the field, its value and what would be right.
"""

import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from copy import deepcopy
from dataclasses import dataclass, field, fields
from functools import cache
from typing import Any, TypeVar

NAME_RULE = "must be a name of up to 60 letters (a to z), digits, _ and -, beginning with a letter"
SMALLEST, LARGEST = 1e-15, 1e15  # of the size of a number that is not 0; beyond it, computed values overflow
Violation = tuple[str, object, str]  # a field, its value, and what would be right
_NAME_PATTERN = re.compile(r"[A-Za-z][A-Za-z0-9_-]{0,59}")
_RULE_KEY = "rule"
_T = TypeVar("_T")


def is_name(text: str) -> bool:
    return _NAME_PATTERN.fullmatch(text) is not None


@dataclass(frozen=True)
class Rule:
    """Rule for a field; of a list or mapping, for each of its entries."""

    unit: str = ""
    above: float | None = None
    least: float | None = None
    below: float | None = None
    most: float | None = None
    sizes: tuple[float, float] = (SMALLEST, LARGEST)  # of a number that is not 0, whatever its sign
    known: Sequence[str] | Callable[[], Sequence[str]] = ()  # texts to choose from
    is_name: bool = False
    length: int | None = None  # of a list
    filled: bool = False  # a list, mapping or text that is not empty
    span: bool = False  # a list [least, most]
    framed: bool = False  # poses may be in a frame
    paths: Mapping[str, "Rule"] = field(default_factory=dict)  # of changes by dotted keys, see `dotted_changes`
    parts: Mapping[str, "Rule"] = field(default_factory=dict)  # of the fields of a config of Drake's

    @property
    def limits(self) -> str:
        """The range of a number in words, without its unit; empty if there is none."""
        low = [f"above {self.above:g}"] if self.above is not None else []
        low += [f"at least {self.least:g}"] if self.least is not None else []
        high = [f"below {self.below:g}"] if self.below is not None else []
        high += [f"at most {self.most:g}"] if self.most is not None else []
        return " and ".join(low + high)

    @property
    def choices(self) -> tuple[str, ...]:
        """The texts to choose from; none if any will do."""
        return tuple(self.known() if callable(self.known) else self.known)

    def violation(self, value: object) -> str | None:
        """Violated rule of a text, number, list or mapping, in words; None if valid."""
        if isinstance(value, int | float):
            return None if isinstance(value, bool) else self._number_violation(value)
        if isinstance(value, str) and self.is_name and not is_name(value):
            return NAME_RULE
        if isinstance(value, str) and self.known and value not in self.choices:
            return f"must be one of {', '.join(self.choices)}"
        if isinstance(value, Sequence | Mapping) and self.filled and not value:
            return "must not be empty"
        unit = f", {self.unit}" if self.unit else ""
        if not isinstance(value, Sequence) or isinstance(value, str):
            return None
        if self.length is not None and len(value) != self.length:
            return f"must have {self.length} entries{unit}"
        if self.span and not (len(value) == 2 and value[0] <= value[1]):
            return f"must be [least, most]{unit}"
        return None

    def _number_violation(self, value: float) -> str | None:
        low_enough = (self.below is None or value < self.below) and (self.most is None or value <= self.most)
        high_enough = (self.above is None or value > self.above) and (self.least is None or value >= self.least)
        if not (low_enough and high_enough):
            return f"must be {self.limits} {self.unit}".rstrip()
        low, high = self.sizes
        fits = value == 0 or low <= abs(value) <= high
        return None if fits else f"must be a finite number: 0, or {low:g} to {high:g} in size"


_ANY_RULE = Rule()


def valid(unit: str = "", **rule: Any) -> dict[str, Rule]:
    """Metadata of a field, from the fields of a Rule."""
    return {_RULE_KEY: Rule(unit, **rule)}


def quantity(default: _T, unit: str = "", **rule: Any) -> _T:
    """A field with a default and a Rule; a list or mapping is copied."""
    if isinstance(default, list | dict):
        declaration: Any = field(default_factory=lambda: deepcopy(default), metadata=valid(unit, **rule))
    else:
        declaration = field(default=default, metadata=valid(unit, **rule))
    return declaration


def like(cls: type, name: str) -> Any:
    """A field that is None by default, and otherwise follows the rule of a field of another class."""
    return field(default=None, metadata={_RULE_KEY: rules(cls)[name]})


@cache
def rules(cls: type) -> dict[str, Rule]:
    return {part.name: part.metadata.get(_RULE_KEY, _ANY_RULE) for part in fields(cls)}


def violations(config: object) -> Iterator[Violation]:
    """Violations of rules across fields, of a dataclass with fields that are valid one by one."""
    return config.violations() if hasattr(config, "violations") else iter(())
