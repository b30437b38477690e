"""Agreement of runs in another engine with the same runs in Drake, measure by measure.

Drake is the judge: a random part of the runs is repeated there, and their measures are compared.
"""

from collections.abc import Iterator, Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass
from typing import Annotated, Any

import numpy as np

from soft_gripper.files.number import number
from soft_gripper.runs.study import results
from soft_gripper.runs.sweep.cells import cell
from soft_gripper.runs.sweep.measured_runs import ENGINE_STEP, ERROR, measured_runs
from soft_gripper.scenario.schema import DRAKE

NAN = float("nan")


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
    own: Sequence[str] = (),
) -> list[Agreement]:
    """Repeats some runs of another engine in Drake and compares their measures.

    Args:
        scenario: name of a shipped one, or path of a file.
        runs: of the other engine: cells by column, and changes of the scenario; those that failed are left out.
        checked: number of runs to repeat.
        seed: of their choice.
        executor: makes the runs.
        own: user measures.
    """
    fine = [run for run in runs if run[0][ERROR] == ""]
    picked = draw_indices(len(fine), checked, seed)
    drake = {"engine": DRAKE, ENGINE_STEP: None}
    jobs = {i: (scenario, [{**fine[i][1], **drake}], own) for i in picked}
    repeated = results(executor, measured_runs, jobs)
    both = [(fine[i][0], {name: cell(v) for name, v in repeated[i][0].items()}) for i in picked]
    same = [(row, other) for row, other in both if ERROR not in other]
    return agreement([{name: row[name] for name in other} for row, other in same], [other for _, other in same])


def draw_indices(count: int, checked: int, seed: int) -> list[int]:
    """Draws the indices of `checked` runs to repeat, at random, in rising order."""
    drawn = np.random.default_rng([seed, count]).permutation(count)[:checked]
    return sorted(map(int, drawn))


def agreement(rows: Sequence[Mapping[str, str]], in_drake: Sequence[Mapping[str, str]]) -> list[Agreement]:
    """A row for every measure, from the cells of the same runs in both engines.

    A number that is missing in either run, such as the area of contact at points, is not compared.
    """
    return [*_compare(rows, in_drake)]


def _compare(rows: Sequence[Mapping[str, str]], in_drake: Sequence[Mapping[str, str]]) -> Iterator[Agreement]:
    for name in rows[0] if rows else ():
        cells = [(one[name], other[name]) for one, other in zip(rows, in_drake, strict=True)]
        numbers = np.array([[_number(cell) for cell in both] for both in cells])
        both = numbers[np.isfinite(numbers).all(axis=1)]
        if len(both):
            size = np.abs(both[:, 0] - both[:, 1])
            statistics = (np.median(size), np.quantile(size, 0.95), size.max())
            yield Agreement(name, len(both), NAN, float(np.median(both[:, 1])), *map(float, statistics))
        elif words := [cell_pair for cell_pair in cells if all(map(_is_word, cell_pair))]:
            yield Agreement(name, len(words), float(sum(one == other for one, other in words)))


def _number(cell: str) -> float:
    try:
        return number(cell)
    except ValueError:
        return NAN


def _is_word(cell: str) -> bool:
    return bool(cell) and cell != "nan" and np.isnan(_number(cell))
