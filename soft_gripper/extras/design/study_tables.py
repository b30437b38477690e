"""The tables of a design study: every design, what matters, and the test."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import astuple, dataclass
from pathlib import Path
from typing import Any

import numpy as np

from soft_gripper.extras.design.ranking import GRASP, number, over
from soft_gripper.extras.design.run_design import DESIGN, Designed
from soft_gripper.extras.design.sensitivity import Sensitivity, sensitivities
from soft_gripper.extras.design.study_file import EndConfig
from soft_gripper.files.row_table import columns, write_rows
from soft_gripper.runs.scores.grasp import HELD
from soft_gripper.runs.sweep.run_sweep import cell

DESIGNS, SENSITIVITY, TESTS = "designs.csv", "sensitivity.csv", "tests.csv"
_SHORT = 5  # letters of a word that says too little by itself
SHARE_HELD = "held"  # the share of runs that hold, as if it were an end


@dataclass(frozen=True)
class TestRow:
    """A design with one object in the test; ends over the runs that hold it, NaN if none does."""

    design: int
    object: str
    unseen: bool
    held: int
    runs: int
    ends: tuple[float, ...]


def short_names(keys: Sequence[str]) -> list[str]:
    """The last words of dotted keys; the keys themselves, if that does not tell them apart."""
    names = [_short_name(key) for key in keys]
    return names if len(set(names)) == len(names) else list(keys)


def _short_name(key: str) -> str:
    words = [word for word in key.split(".") if not word.isdecimal() and word != "all"]
    return words[-1].replace("_", " ") if len(words[-1]) > _SHORT or len(words) < 2 else " ".join(words[-2:])


def design_cells(found: Designed) -> tuple[list[str], list[list[str]]]:
    """Columns and rows of the table of all designs; the first is the scenario as it is."""
    config = found.study.config
    keys = [axis.key for axis in found.study.axes]
    ends = [end.measure for end in config.ends]
    names = [DESIGN, *keys, "held", "runs", *ends, "allowed", "front", "reason"]
    rows = []
    for i, design in enumerate(found.designs):
        score, given = design.score, map(design.values.get, keys)
        known = score.held, score.runs, *(score.ends or [math.nan] * len(ends))
        rows.append([design.number, *given, *known, score.is_allowed, i in found.front, reason(found, i)])
    return names, [list(map(cell, row)) for row in rows]


def reason(found: Designed, index: int) -> str:
    """Why a design is not allowed; empty if it is."""
    score = found.designs[index].score
    if score.refused:
        return score.refused
    if score.held < score.runs:
        return f"holds in {score.held} of {score.runs} runs"
    return "; ".join(f"not: {name}" for name, excess in score.excess.items() if excess > 0)


def sensitivity_rows(found: Designed) -> list[Sensitivity]:
    """Sensitivity of each end among designs that hold, and of how many runs hold among all that were simulated."""
    config, rows = found.study.config, []
    simulated = [design for design in found.designs[1:] if not design.score.refused]
    for i, end in enumerate(config.ends):
        known = [design for design in simulated if design.score.is_allowed]
        rows += _sensitivities(found, end.measure, known, [design.score.ends[i] for design in known])
    return rows + _sensitivities(found, SHARE_HELD, simulated, [d.score.held / d.score.runs for d in simulated])


def _sensitivities(found: Designed, name: str, designs: Sequence[Any], values: Sequence[float]) -> list[Sensitivity]:
    variables = {axis.key: [design.values[axis.key] for design in designs] for axis in found.study.axes}
    return sensitivities(name, np.array(values), {key: [_plain(v) for v in given] for key, given in variables.items()})


def _plain(value: Any) -> Any:
    """A value; a relative change, "+10 %", as a number."""
    if isinstance(value, str) and value.endswith("%"):
        return number(value.rstrip("% "))
    return value


def test_rows(found: Designed) -> list[TestRow]:
    """A row for each tested design and object."""
    ends, unseen = found.study.config.ends, found.study.unseen
    return [
        _test_row(tested.number, name, name in unseen, rows, ends)
        for tested in found.tested
        for name, rows in tested.rows.items()
    ]


def _test_row(
    design: int, name: str, is_unseen: bool, rows: Sequence[Mapping[str, Any]], ends: Sequence[EndConfig]
) -> TestRow:
    held = [row for row in rows if row.get(GRASP) == HELD]
    values = tuple(over(end, [number(row.get(end.measure)) for row in held]) for end in ends)
    return TestRow(design, name, is_unseen, len(held), len(rows), values)


def write_tables(found: Designed, out: Path) -> list[str]:
    """Writes the tables; returns their names."""
    ends = [end.measure for end in found.study.config.ends]
    write_rows(out / DESIGNS, *design_cells(found))
    *before, _ = columns(TestRow)
    tests = (map(cell, [*(getattr(row, name) for name in before), *row.ends]) for row in test_rows(found))
    write_rows(out / TESTS, [*before, *ends], map(list, tests))
    matters = ([cell(value) for value in astuple(row)] for row in sensitivity_rows(found))
    write_rows(out / SENSITIVITY, columns(Sensitivity), matters)
    return [DESIGNS, TESTS, SENSITIVITY]
