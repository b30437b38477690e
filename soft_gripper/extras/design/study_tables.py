"""The tables of a design study: every design, what matters, and the test."""

from collections.abc import Sequence
from math import nan
from pathlib import Path
from typing import Any

from scipy.stats import binomtest

from soft_gripper.extras.design.ranking import ends_of
from soft_gripper.extras.design.run_design import DESIGN, OBJECT, Designed
from soft_gripper.extras.design.sensitivity import Sensitivity, sensitivities
from soft_gripper.files.row_table import columns, write_rows
from soft_gripper.runs.sweep.cells import cell

DESIGNS, SENSITIVITY, TESTS = "designs.csv", "sensitivity.csv", "tests.csv"
_SHORT = 5  # letters of a word that says too little by itself
SHARE_HELD = "held"  # the share of runs that hold, as if it were an end
Table = list[dict[str, Any]]


def short_names(keys: Sequence[str]) -> list[str]:
    """The last words of dotted keys; the keys themselves, if that does not tell them apart."""
    names = [_short_name(key) for key in keys]
    return names if len(set(names)) == len(names) else list(keys)


def _short_name(key: str) -> str:
    words = [word for word in key.split(".") if not word.isdecimal() and word != "all"]
    return words[-1].replace("_", " ") if len(words[-1]) > _SHORT or len(words) < 2 else " ".join(words[-2:])


def design_rows(found: Designed) -> Table:
    """All designs; the first is the scenario as it is."""
    rows = []
    for i, design in enumerate(found.designs):
        score = design.score
        rows.append(
            {DESIGN: design.number}
            | {axis.key: design.values.get(axis.key) for axis in found.study.axes}
            | {"held": score.held, "runs": score.runs}
            | _named_ends(found, score.ends)
            | {"allowed": score.is_allowed, "front": i in found.front, "reason": reason(found, i)}
        )
    return rows


def _named_ends(found: Designed, values: Sequence[float]) -> dict[str, float]:
    names = [end.measure for end in found.study.config.ends]
    return dict(zip(names, values or [nan] * len(names), strict=True))


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
    simulated = [design for design in found.designs[1:] if not design.score.refused]
    allowed = [design for design in simulated if design.score.is_allowed]
    ends = [end.measure for end in found.study.config.ends]
    values = {name: (allowed, [design.score.ends[i] for design in allowed]) for i, name in enumerate(ends)}
    values[SHARE_HELD] = simulated, [design.score.held / design.score.runs for design in simulated]
    rows = []
    for name, (designs, of_designs) in values.items():
        cells = {axis.key: [cell(design.values[axis.key]) for design in designs] for axis in found.study.axes}
        rows += sensitivities(name, of_designs, cells)
    return rows


def test_rows(found: Designed) -> Table:
    """The reference and the best design with each object, and a 95 % confidence interval; ends of runs that hold it."""
    rows = []
    for number, name in dict.fromkeys((row[DESIGN], row[OBJECT]) for row, _ in found.tests):
        runs = [row for row, _ in found.tests if (row[DESIGN], row[OBJECT]) == (number, name)]
        held, ends = ends_of(runs, found.study.config.ends)
        low, high = binomtest(len(held), len(runs)).proportion_ci(0.95, "wilson")
        rows.append(
            {DESIGN: number, OBJECT: name, "unseen": name in found.study.unseen, "held": len(held), "runs": len(runs)}
            | {"least_percent": 100 * low, "most_percent": 100 * high}
            | _named_ends(found, ends)
        )
    return rows


def write_tables(found: Designed, out: Path) -> list[str]:
    """Writes the tables; returns their names."""
    tables = {DESIGNS: design_rows(found), TESTS: test_rows(found)}
    tables[SENSITIVITY] = [vars(row) for row in sensitivity_rows(found)]
    for name, rows in tables.items():
        write_rows(
            out / name, list(rows[0]) if rows else columns(Sensitivity), ([*map(cell, row.values())] for row in rows)
        )
    return list(tables)
