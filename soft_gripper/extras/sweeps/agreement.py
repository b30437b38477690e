"""Agreement of runs in another engine with the same runs in Drake, measure by measure.

Drake is the judge: a random part of the runs is repeated there, and their measures are compared.
"""

import math
from collections.abc import Iterator, Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

import numpy as np

from soft_gripper.commands.console import Console
from soft_gripper.extras.sweeps.cells import cell
from soft_gripper.extras.sweeps.measured_runs import ENGINE_STEP, ERROR, measured_runs
from soft_gripper.extras.sweeps.study import results
from soft_gripper.files.number import number
from soft_gripper.files.row_table import print_rows
from soft_gripper.scenario.schema import DRAKE

NAN = float("nan")
AGREEMENT = "agreement.csv"


@dataclass(frozen=True)
class Agreement:
    """Agreement of one measure over all repeated runs.

    alike: runs with the same word; of a number NaN.
    in_drake: median of a number in Drake, in the unit of the measure.
    median_difference, difference_q95, largest_difference: sizes of the differences; q95: of 95 % of the runs at most.
    """

    measure: str
    runs: int
    alike: Annotated[float, ".0f"] = NAN
    in_drake: Annotated[float, ".4g"] = NAN
    median_difference: Annotated[float, ".3g"] = NAN
    difference_q95: Annotated[float, ".3g"] = NAN
    largest_difference: Annotated[float, ".3g"] = NAN


def agreement_with_drake(
    scenario: str,
    runs: Sequence[tuple[Mapping[str, str], Mapping[str, Any]]],
    checked: int,
    seed: int,
    executor: Executor,
    measures: Sequence[str] = (),
) -> list[Agreement]:
    """Repeats some runs of another engine in Drake and compares their measures.

    Args:
        scenario: name of a shipped one, or path of a file.
        runs: of the other engine: cells by column, and changes of the scenario; those that failed are left out.
        checked: number of runs to repeat.
        seed: of their choice.
        executor: makes the runs.
        measures: user measures.
    """
    complete_runs = [run for run in runs if run[0][ERROR] == ""]
    indices = draw_indices(len(complete_runs), checked, seed)
    drake = {"engine": DRAKE, ENGINE_STEP: None}
    jobs = {i: (scenario, [{**complete_runs[i][1], **drake}], measures) for i in indices}
    drake_runs = results(executor, measured_runs, jobs)
    row_pairs = [
        (complete_runs[i][0], {name: cell(value) for name, value in drake_runs[i][0].items()}) for i in indices
    ]
    complete = [(row, drake_row) for row, drake_row in row_pairs if ERROR not in drake_row]
    rows = [{name: row[name] for name in drake_row} for row, drake_row in complete]
    return agreement(rows, [drake_row for _, drake_row in complete])


def draw_indices(count: int, checked: int, seed: int) -> list[int]:
    """Draws the indices of `checked` runs to repeat, at random, in rising order."""
    indices = np.random.default_rng([seed, count]).permutation(count)[:checked]
    return sorted(map(int, indices))


def agreement(rows: Sequence[Mapping[str, str]], drake_rows: Sequence[Mapping[str, str]]) -> list[Agreement]:
    """A row for every measure, from the cells of the same runs in both engines.

    A number that is missing in either run, such as the area of contact at points, is not compared.
    """
    return [*_compare(rows, drake_rows)]


def _compare(rows: Sequence[Mapping[str, str]], drake_rows: Sequence[Mapping[str, str]]) -> Iterator[Agreement]:
    for name in rows[0] if rows else ():
        cells = [(row[name], drake_row[name]) for row, drake_row in zip(rows, drake_rows, strict=True)]
        numbers = np.array([[_number(cell) for cell in pair] for pair in cells])
        pairs = numbers[np.isfinite(numbers).all(axis=1)]
        if len(pairs):
            size = np.abs(pairs[:, 0] - pairs[:, 1])
            statistics = (np.median(size), np.quantile(size, 0.95), size.max())
            yield Agreement(name, len(pairs), NAN, float(np.median(pairs[:, 1])), *map(float, statistics))
        elif words := [cell_pair for cell_pair in cells if all(map(_is_word, cell_pair))]:
            yield Agreement(name, len(words), float(sum(row == drake_row for row, drake_row in words)))


def _number(cell: str) -> float:
    try:
        return number(cell)
    except ValueError:
        return NAN


def _is_word(cell: str) -> bool:
    return bool(cell) and cell != "nan" and np.isnan(_number(cell))


def print_agreement(rows: Sequence[Agreement], console: Console, out: Path) -> None:
    """Prints and writes how runs of another engine agree with the same runs in Drake."""
    console.table("agreement", rows, out / AGREEMENT)
    print(f"\n{max(row.runs for row in rows)} of the runs repeated in Drake:")
    for row in rows:
        if math.isfinite(row.alike):
            print(f"  {row.measure} alike in {row.alike:.0f} of {row.runs}")
    numbers = [row for row in rows if not math.isfinite(row.alike)]
    if numbers:
        print_rows(numbers, "Sizes of the differences", ("alike",))
