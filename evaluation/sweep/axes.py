"""What a sweep varies: keys of a scenario, each with values or a range, and the points that follow."""

import itertools
import math
import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.stats import qmc

from soft_gripper.diagrams.schema.yaml_text import parse_yaml
from soft_gripper.errors import InputError

MOST_RUNS = 10_000  # of a sweep: more than anybody waits for
METHODS = ("grid", "latin", "sobol")
Variation = dict[str, Any]  # values by dotted keys, see `changed_scenario`

_NUMBER = r"([-+]?[0-9.]+(?:[eE][-+]?[0-9]+)?)"
_RANGE = re.compile(rf"\s*{_NUMBER}\s*\.\.\s*{_NUMBER}\s*(%?)\s*(?::\s*([0-9]+))?\s*")
_EXPECTED = "write KEY=1,2,3 or KEY=0.5..0.9:5 (five values) or, with --sample, KEY=0.5..0.9"


@dataclass(frozen=True)
class Values:
    """A key takes each of some values."""

    key: str
    values: tuple[Any, ...]

    def at(self, share: float) -> Any:
        """The value that lies so far along them, 0 to 1."""
        return self.values[min(int(share * len(self.values)), len(self.values) - 1)]


@dataclass(frozen=True)
class Range:
    """A key takes any value of a range; whole numbers if its ends are whole numbers, percent if they are."""

    key: str
    least: float
    most: float
    is_whole: bool = False
    is_relative: bool = False

    def at(self, share: float) -> Any:
        """The value that lies so far along it, 0 to 1."""
        if self.is_whole:
            return min(int(self.least + math.floor(share * (self.most - self.least + 1))), int(self.most))
        value = self.least + share * (self.most - self.least)
        return f"{value:+.9g} %" if self.is_relative else float(f"{value:.12g}")

    def spread(self, count: int) -> Values:
        """So many values, as far from each other, from end to end."""
        shares = [i / max(count - 1, 1) for i in range(count)]
        exact = [self.least + share * (self.most - self.least) for share in shares]
        if self.is_whole and all(value.is_integer() for value in map(float, exact)):
            return Values(self.key, tuple(int(value) for value in exact))
        continuous = Range(self.key, self.least, self.most, False, self.is_relative)
        return Values(self.key, tuple(continuous.at(share) for share in shares))


Axis = Values | Range


def read_axis(text: str) -> Axis:
    """What "KEY=VALUES" means: "1,2,3", "0.5..0.9:5", "0.5..0.9", or "-10..10 %:5".

    Raises:
        InputError: if it means nothing.
    """
    key, equals, values = text.partition("=")
    if not equals or not key or not values.strip():
        raise InputError("sweep", "--vary", text, _EXPECTED)
    if match := _RANGE.fullmatch(values):
        return _read_range(key, text, *match.groups())
    try:
        listed = parse_yaml("sweep", f"values: {values if values.lstrip().startswith('[') else f'[{values}]'}")
    except InputError:
        raise InputError("sweep", "--vary", text, _EXPECTED) from None
    found = listed["values"]
    if not isinstance(found, list) or not found:
        raise InputError("sweep", "--vary", text, _EXPECTED)
    return Values(key, tuple(found))


def _read_range(key: str, text: str, least: str, most: str, percent: str, count: str | None) -> Axis:
    try:
        is_whole = not percent and all(end.lstrip("+-").isdecimal() for end in (least, most))
        found = Range(key, float(least), float(most), is_whole, bool(percent))
    except ValueError:
        raise InputError("sweep", "--vary", text, _EXPECTED) from None
    number = None if count is None else float(count)
    if not -math.inf < found.least < found.most < math.inf or (number is not None and not 2 <= number <= MOST_RUNS):
        expected = f"give the lower end, the higher end, and 2 values or more, {MOST_RUNS} at most"
        raise InputError("sweep", "--vary", text, expected)
    return found if number is None else found.spread(int(number))


def points(axes: Sequence[Axis], method: str = "grid", number: int = 0, seed: int = 0) -> list[Variation]:
    """The points of a sweep, in the order in which they are numbered.

    Args:
        axes: the keys that vary, each once.
        method: "grid": all combinations of the values, the last key fastest; "latin" (Latin hypercube) or "sobol"
            (scrambled) sample them and ranges (scipy.stats.qmc).
        number: of samples.
        seed: of them.

    Raises:
        InputError: if keys repeat, a range has no values on a grid, the number does not suit the method, or there
            would be more than MOST_RUNS.
    """
    keys = [axis.key for axis in axes]
    for key in keys:
        if keys.count(key) > 1:
            raise InputError("sweep", "--vary", key, "appears more than once")
    if method == "grid":
        number = math.prod(len(_listed(axis)) for axis in axes)
    if number > MOST_RUNS:
        expected = f"would be {number} runs, of at most {MOST_RUNS}: give fewer values, or a smaller --sample"
        raise InputError("sweep", "--vary", ", ".join(keys), expected)
    if method == "grid":
        return [dict(zip(keys, values, strict=True)) for values in itertools.product(*map(_listed, axes))]
    if number < 1 or (method == "sobol" and number & (number - 1)):
        expected = "give a power of 2: the points of a Sobol sequence are balanced then" if number else "give a number"
        raise InputError("sweep", "--sample", number, expected)
    engine = {"latin": qmc.LatinHypercube, "sobol": qmc.Sobol}[method]
    shares = engine(len(axes), rng=np.random.default_rng(seed)).random(number)
    return [{axis.key: axis.at(float(share)) for axis, share in zip(axes, row, strict=True)} for row in shares]


def _listed(axis: Axis) -> tuple[Any, ...]:
    if isinstance(axis, Range):
        expected = "say how many values, such as 0.5..0.9:5, or give --sample"
        raise InputError("sweep", "--vary", axis.key, expected)
    return axis.values
