"""The maps of robustness, run case by case: a scenario at a noise, which leaves a file of rows."""

from collections.abc import Callable, Sequence
from concurrent.futures import Executor, Future
from pathlib import Path
from typing import Any

from soft_gripper.diagrams.recording.recording import Recording
from soft_gripper.diagrams.schema.scenario_file import load_scenario
from soft_gripper.diagrams.station import make_station
from soft_gripper.errors import InputError
from soft_gripper.evaluation.csv_table import cells, read_csv, write_csv
from soft_gripper.evaluation.executor.executor import Call, make_calls
from soft_gripper.evaluation.paper.scenario_run import SCENARIOS
from soft_gripper.evaluation.robustness.finger_at_rest import touched_fingers
from soft_gripper.evaluation.robustness.robustness_table import RobustnessRow, robustness_table
from soft_gripper.row_sums import read_sums, row_sum, write_sums

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
