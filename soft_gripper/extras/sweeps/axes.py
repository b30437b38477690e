"""The varied keys of a sweep, and the points at which it runs a scenario."""

import itertools
import math
import re
from collections.abc import Sequence
from dataclasses import dataclass
from numbers import Integral, Real
from typing import Any

import numpy as np
from scipy.stats import qmc

from soft_gripper.errors import InputError
from soft_gripper.files.yaml_text import parse_yaml

MAX_RUNS = 1_000_000  # in a sweep; its table takes some 2 GB while it is written
METHODS = ("grid", "latin", "sobol")
SweepPoint = dict[str, Any]  # values by dotted keys, see `changed_scenario`

_NUMBER = r"([-+]?[0-9.]{1,400}(?:[eE][-+]?[0-9]+)?)"
_RANGE = re.compile(rf"\s*+{_NUMBER}\s*+\.\.\s*+{_NUMBER}\s*+(%?)\s*+(?::\s*+([0-9]++))?\s*+")
_SPAN = re.compile(rf"\s*+{_NUMBER}\s*+(?:[-:\u2013]|\.{{3}}|to)\s*+{_NUMBER}\s*+(%?)\s*+")  # in other notations
_ENDS = "give the lower limit, the upper limit, and 2 or more values"
_EXPECTED = "write KEY=1,2,3 or KEY=0.5..0.9:5 (five values) or, with --sample, KEY=0.5..0.9"


@dataclass(frozen=True)
class Values:
    """A key takes each value of a list."""

    key: str
    values: tuple[Any, ...]

    def __post_init__(self) -> None:
        is_list = isinstance(self.values, Sequence | np.ndarray) and not isinstance(self.values, str)
        if not is_list or not len(self.values):
            raise InputError("sweep", self.key, self.values, "give at least one value, in a tuple")

    def at(self, share: float) -> Any:
        """The value at a fraction, 0 to 1, of the list."""
        return self.values[min(int(share * len(self.values)), len(self.values) - 1)]


@dataclass(frozen=True)
class Range:
    """A key takes any value in a range: integers if both limits are integers, percentages if they are percentages."""

    key: str
    least: float
    most: float
    is_whole: bool = False
    is_relative: bool = False

    def __post_init__(self) -> None:
        are_numbers = isinstance(self.least, Real) and isinstance(self.most, Real)
        if not are_numbers or not -math.inf < self.least < self.most < math.inf:
            raise InputError("sweep", self.key, [self.least, self.most], "give the lower limit, then the upper limit")

    def at(self, share: float) -> Any:
        """The value at a fraction, 0 to 1, of the range."""
        if self.is_whole:
            return min(int(self.least + math.floor(share * (self.most - self.least + 1))), int(self.most))
        value = self.least + share * (self.most - self.least)
        return f"{value:+.9g} %" if self.is_relative else float(f"{value:.12g}")

    def spread(self, count: int) -> Values:
        """A number of equally spaced values, at least two, including both limits."""
        if not isinstance(count, Integral) or count < 2:
            raise InputError("sweep", self.key, count, "give a whole number of values, 2 or more")
        shares = [i / (count - 1) for i in range(count)]
        exact_values = [self.least + share * (self.most - self.least) for share in shares]
        if self.is_whole and all(value.is_integer() for value in map(float, exact_values)):
            return Values(self.key, tuple(int(value) for value in exact_values))
        continuous = Range(self.key, self.least, self.most, False, self.is_relative)
        return Values(self.key, tuple(continuous.at(share) for share in shares))


Axis = Values | Range


def read_axis(text: str) -> Axis:
    """Parses "KEY=VALUES", where VALUES is "1,2,3", "0.5..0.9:5", "0.5..0.9", or "-10..10 %:5".

    Raises:
        InputError: if it cannot be parsed.
    """
    key, equals, values = text.partition("=")
    if not equals or not key or not values.strip():
        raise InputError("sweep", "--vary", text, _EXPECTED)
    if match := _RANGE.fullmatch(values):
        return _read_range(key, text, *match.groups())
    if span := next(filter(None, map(_SPAN.fullmatch, values.strip(" []").split(","))), None):
        ends = f"{span[1]}..{span[2]} {span[3]}".rstrip()
        raise InputError("sweep", "--vary", text, f"write {ends}:N, with N values, or list them")
    try:
        content = parse_yaml("sweep", f"values: {values if values.lstrip().startswith('[') else f'[{values}]'}")
    except InputError:
        raise InputError("sweep", "--vary", text, _EXPECTED) from None
    listed_values = content["values"]
    if not isinstance(listed_values, list) or not listed_values:
        raise InputError("sweep", "--vary", text, _EXPECTED)
    return Values(key, tuple(listed_values))


def _read_range(key: str, text: str, least: str, most: str, percent: str, count: str | None) -> Axis:
    if count in ("0", "1"):
        raise InputError("sweep", "--vary", text, _ENDS)
    try:
        is_whole = not percent and all(end.lstrip("+-").isdecimal() for end in (least, most))
        ends = float(least), float(most)
    except ValueError:
        raise InputError("sweep", "--vary", text, _EXPECTED) from None
    number = 2.0 if count is None else float(count)
    if not -math.inf < ends[0] < ends[1] < math.inf or number > MAX_RUNS:
        raise InputError("sweep", "--vary", text, f"{_ENDS}, {MAX_RUNS} at most")
    axis = Range(key, *ends, is_whole, bool(percent))
    return axis if count is None else axis.spread(int(number))


def sweep_points(axes: Sequence[Axis], method: str = "grid", number: int = 0, seed: int = 0) -> list[SweepPoint]:
    """The points of a sweep, in numerical order.

    Args:
        axes: the varied keys, each once.
        method: "grid": all combinations of the values, the last key fastest; "latin" (Latin hypercube) or "sobol"
            (scrambled) sample them and ranges (scipy.stats.qmc).
        number: number of samples.
        seed: seed of the samples.

    Raises:
        InputError: if keys repeat, a range has no values on a grid, the number does not suit the method, or there
            would be more than MAX_RUNS.
    """
    if not isinstance(axes, Sequence) or not axes or not all(isinstance(axis, Axis) for axis in axes):
        raise InputError("sweep", "axes", axes, "give a list of at least one Values or Range")
    if method not in METHODS:
        raise InputError("sweep", "method", method, f"known: {', '.join(METHODS)}")
    for name, value in (("number", number), ("seed", seed)):
        if not isinstance(value, Integral) or value < 0:
            raise InputError("sweep", name, value, "give a whole number, 0 or more")
    keys = [axis.key for axis in axes]
    for key in keys:
        if keys.count(key) > 1:
            raise InputError("sweep", "--vary", key, "appears more than once")
    if method == "grid":
        number = math.prod(len(_listed(axis)) for axis in axes)
    if number > MAX_RUNS:
        expected = f"would be {number} runs, above the limit of {MAX_RUNS}: give fewer values, or a smaller --sample"
        raise InputError("sweep", "--vary", ", ".join(keys), expected)
    if method == "grid":
        return [dict(zip(keys, values, strict=True)) for values in itertools.product(*map(_listed, axes))]
    if number < 1 or (method == "sobol" and number & (number - 1)):
        expected = "give a power of 2, so that the Sobol sequence is balanced" if number else "give a number"
        raise InputError("sweep", "--sample", number, expected)
    engine = {"latin": qmc.LatinHypercube, "sobol": qmc.Sobol}[method]
    shares = engine(len(axes), rng=np.random.default_rng(seed)).random(number)
    return [{axis.key: axis.at(float(share)) for axis, share in zip(axes, row, strict=True)} for row in shares]


def _listed(axis: Axis) -> tuple[Any, ...]:
    if isinstance(axis, Range):
        expected = "give the number of values, such as 0.5..0.9:5, or give --sample"
        raise InputError("sweep", "--vary", axis.key, expected)
    return axis.values
