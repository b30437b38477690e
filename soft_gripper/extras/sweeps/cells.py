"""Cells of a table of runs: values as text, and back."""

from collections.abc import Sequence
from contextlib import suppress
from typing import Any

import numpy as np

from soft_gripper.arrays import Array
from soft_gripper.files.number import number

Column = Sequence[str]


def cell(value: Any) -> str:
    """A value as text; numbers have nine significant digits."""
    if isinstance(value, float):
        return f"{value + 0.0:.9g}"
    return "" if value is None else str(value)


def numbers_in(cells: Column) -> Array:
    """Cells as numbers, true as 1 and percentages without their sign; NaN for other cells."""
    numbers = np.full(len(cells), np.nan)
    for i, text in enumerate(cells):
        with suppress(ValueError):
            numbers[i] = _TRUTH[text] if text in _TRUTH else number(text.removesuffix("%"))
    return numbers


_TRUTH = {"True": 1.0, "False": 0.0}
