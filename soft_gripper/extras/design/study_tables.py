"""The tables of a design study: every design, sensitivities, and the test."""

from collections.abc import Sequence
from math import nan
from pathlib import Path
from typing import Any

from scipy.stats import binomtest

from soft_gripper.extras.design.ranking import summarize_runs
from soft_gripper.extras.design.run_design import DESIGN, OBJECT, DesignResult
from soft_gripper.extras.design.sensitivity import Sensitivity, sensitivities
from soft_gripper.extras.sweeps.cells import cell
from soft_gripper.files.row_table import columns, write_rows

DESIGNS, SENSITIVITY, TESTS = "designs.csv", "sensitivity.csv", "tests.csv"
_SHORT_WORD = 5  # letters of a word that needs the word before it
SHARE_HELD = "held"  # fraction of runs that hold, treated as an end
Table = list[dict[str, Any]]


def short_names(keys: Sequence[str]) -> list[str]:
    """The last words of dotted keys, or the keys themselves if these words are not unique."""
    names = [_short_name(key) for key in keys]
    return names if len(set(names)) == len(names) else list(keys)


def _short_name(key: str) -> str:
    words = [word for word in key.split(".") if not word.isdecimal() and word != "all"]
    return words[-1].replace("_", " ") if len(words[-1]) > _SHORT_WORD or len(words) < 2 else " ".join(words[-2:])


def design_rows(result: DesignResult) -> Table:
    """Rows of all designs; the first is the unchanged scenario."""
    rows = []
    for i, design in enumerate(result.designs):
        score = design.score
        rows.append(
            {DESIGN: design.number}
            | {axis.key: design.values.get(axis.key) for axis in result.study.axes}
            | {"held": score.held, "runs": score.runs}
            | _named_ends(result, score.ends)
            | {"allowed": score.is_allowed, "front": i in result.front, "reason": reason(result, i)}
        )
    return rows


def _named_ends(result: DesignResult, values: Sequence[float]) -> dict[str, float]:
    names = [end.measure for end in result.study.config.ends]
    return dict(zip(names, values or [nan] * len(names), strict=True))


def reason(result: DesignResult, index: int) -> str:
    """Text that says why a design is not allowed; empty if it is."""
    score = result.designs[index].score
    if score.refused:
        return score.refused
    if score.held < score.runs:
        return f"holds in {score.held} of {score.runs} runs"
    return "; ".join(f"not: {name}" for name, excess in score.excess.items() if excess > 0)


def sensitivity_rows(result: DesignResult) -> list[Sensitivity]:
    """Sensitivity of each end among allowed designs, and of the fraction of held runs among all simulated ones."""
    simulated_designs = [design for design in result.designs[1:] if not design.score.refused]
    allowed = [design for design in simulated_designs if design.score.is_allowed]
    ends = [end.measure for end in result.study.config.ends]
    values = {name: (allowed, [design.score.ends[i] for design in allowed]) for i, name in enumerate(ends)}
    values[SHARE_HELD] = simulated_designs, [design.score.held / design.score.runs for design in simulated_designs]
    rows = []
    for name, (designs, end_values) in values.items():
        cells = {axis.key: [cell(design.values[axis.key]) for design in designs] for axis in result.study.axes}
        rows += sensitivities(name, end_values, cells)
    return rows


def test_rows(result: DesignResult) -> Table:
    """The reference and the best design with each object, and a 95 % confidence interval; ends of runs that hold it."""
    rows = []
    for number, name in dict.fromkeys((row[DESIGN], row[OBJECT]) for row, _ in result.tests):
        runs = [row for row, _ in result.tests if (row[DESIGN], row[OBJECT]) == (number, name)]
        held, ends = summarize_runs(runs, result.study.config.ends)
        low, high = binomtest(len(held), len(runs)).proportion_ci(0.95, "wilson")
        rows.append(
            {DESIGN: number, OBJECT: name, "unseen": name in result.study.unseen, "held": len(held), "runs": len(runs)}
            | {"least_percent": 100 * low, "most_percent": 100 * high}
            | _named_ends(result, ends)
        )
    return rows


def write_tables(result: DesignResult, out: Path) -> list[str]:
    """Writes the tables; returns their names."""
    tables = {DESIGNS: design_rows(result), TESTS: test_rows(result)}
    tables[SENSITIVITY] = [vars(row) for row in sensitivity_rows(result)]
    for name, rows in tables.items():
        write_rows(
            out / name, list(rows[0]) if rows else columns(Sensitivity), ([*map(cell, row.values())] for row in rows)
        )
    return list(tables)
