"""The maps of robustness, run case by case: a scenario at a noise, which leaves a file of rows."""

from collections.abc import Callable, Sequence
from concurrent.futures import Executor, Future
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import LogNorm
from matplotlib.figure import Figure
from matplotlib.image import AxesImage

from soft_gripper.arrays import Array
from soft_gripper.diagrams.recording.recording import Recording
from soft_gripper.diagrams.station import make_station
from soft_gripper.errors import InputError
from soft_gripper.evaluation.paper.scenario_run import SCENARIOS
from soft_gripper.evaluation.robustness.plants import touched_fingers
from soft_gripper.evaluation.robustness.table import RobustnessRow, robustness_table
from soft_gripper.files.csv_table import cells, read_csv, write_csv
from soft_gripper.files.row_sums import read_sums, row_sum, write_sums
from soft_gripper.pictures.style import STYLE
from soft_gripper.runs.executor import Call, make_calls
from soft_gripper.scenario.scenario_file import load_scenario

Case = tuple[str, float]
CASES: tuple[Case, ...] = tuple((scenario, noise) for noise in (1.0, 4.0, 2.0, 0.0) for scenario in SCENARIOS)
FOLDER = "robustness"  # below that of the evaluation


def case_file(out: Path, case: Case) -> Path:
    """Where the rows of a case are, below the folder of the evaluation."""
    scenario, noise = case
    return out / FOLDER / scenario / f"noise_{noise:g}.csv"


def unfinished_cases(out: Path, seeds: int) -> list[Case]:
    """Of CASES, those of which there are no rows of so many seeds, as they were written."""
    return [case for case in CASES if not _has_rows(case_file(out, case), seeds)]


def _has_rows(file: Path, seeds: int) -> bool:
    try:
        rows = read_csv(file, RobustnessRow)
    except InputError:
        return False
    return all(row.seeds == seeds for row in rows) and set(_sums(rows)) == read_sums(file)


def write_case(file: Path, rows: Sequence[RobustnessRow]) -> None:
    """Writes the rows of a case, and their checksums."""
    file.parent.mkdir(parents=True, exist_ok=True)
    write_csv(file, rows)
    write_sums(file, _sums(rows))


def _sums(rows: Sequence[RobustnessRow]) -> list[str]:
    return [row_sum(cells(row)) for row in rows]


def run_cases(cases: Sequence[Case], out: Path, seeds: int, executor: Executor, advance: Callable[[], Any]) -> None:
    """Runs cases on the recordings in `out`; `advance` is called after each.

    Raises:
        InputError, WorkerDiedError: if a case fails; the others are finished first.
    """
    recordings = {name: Recording.load(out / name / "recording.nc") for name in {name for name, _ in cases}}
    failed: list[BaseException] = []

    def ended(call: Call, future: Future[list[RobustnessRow]]) -> None:
        name, noise, *_ = call
        if error := future.exception():
            failed.append(error)
        else:
            write_case(case_file(out, (name, noise)), future.result())
        advance()

    make_calls(executor, case_rows, [(name, noise, recordings[name], seeds) for name, noise in cases], ended)
    if failed:
        raise failed[0]


def case_rows(name: str, noise: float, recording: Recording, seeds: int) -> list[RobustnessRow]:
    """The rows of a case from the recording of its scenario."""
    fingers = touched_fingers(name, make_station(load_scenario(name)), recording)
    return robustness_table(name, fingers, noise, seeds)


def gather_maps(out: Path) -> list[RobustnessRow]:
    """The rows of all cases, which are written into one table."""
    rows = [
        row for case in sorted(CASES, key=lambda case: case[1]) for row in read_csv(case_file(out, case), RobustnessRow)
    ]
    write_csv(out / FOLDER / "robustness.csv", rows)
    return rows


LEAST, MOST = 0.03, 10.0  # mm, of the colours
_WHITE_ABOVE = 0.8  # mm, where the colours are dark


def map_figure(rows: Sequence[RobustnessRow]) -> Figure:
    """Mean pose error in the scenario where it is largest: a panel a belief and number of sensors."""
    beliefs, counts, estimators, noises = (
        list(dict.fromkeys(getattr(row, name) for row in rows)) for name in ("belief", "sections", "estimator", "noise")
    )
    with mpl.rc_context({**STYLE, "axes.grid": False}):
        figure = Figure(figsize=(9.5, 2.15 * len(beliefs) + 0.6), layout="constrained")
        panels = figure.subplots(len(beliefs), len(counts), sharex=True, sharey=True, squeeze=False)
        for line, belief in zip(panels, beliefs, strict=True):
            for axes, count in zip(line, counts, strict=True):
                of_panel = [row for row in rows if (row.belief, row.sections) == (belief, count)]
                image = _draw(axes, _largest(of_panel, estimators, noises))
                axes.set_xticks(range(len(noises)), ["0" if n == 0 else f"{n:g}×" for n in noises])
                axes.set_yticks(range(len(estimators)), estimators)
            line[0].set_ylabel(f"believed:\n{belief}" if belief != "as simulated" else "believed:\nas it is")
        for axes, count in zip(panels[0], counts, strict=True):
            axes.set_title(f"{count} sensor{'s' * (count > 1)} per side")
        for axes in panels[-1]:
            axes.set_xlabel("errors of the sensors")
        figure.colorbar(image, ax=panels, label="mean pose error, worst scenario [mm]", format="{x:g}", shrink=0.7)
    return figure


def _largest(rows: Sequence[RobustnessRow], estimators: Sequence[str], noises: Sequence[float]) -> Array:
    """Of all scenarios, mm, (estimators, noises)."""

    def largest(estimator: str, noise: float) -> float:
        return float(np.max([row.mean_mm for row in rows if (row.estimator, row.noise) == (estimator, noise)]))

    return np.array([[largest(estimator, noise) for noise in noises] for estimator in estimators])


def _draw(axes: Axes, errors: Array) -> AxesImage:
    image = axes.imshow(np.maximum(errors, LEAST), norm=LogNorm(LEAST, MOST), cmap="YlGnBu", aspect="auto")
    axes.tick_params(length=0)
    for (line, column), error in np.ndenumerate(errors):
        color = "white" if error > _WHITE_ABOVE else "0.15"
        axes.text(column, line, f"{error:.2f}", ha="center", va="center", fontsize=8, color=color)
    for spine in axes.spines.values():
        spine.set_visible(False)
    return image
