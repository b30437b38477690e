"""The maps of robustness, run case by case: a scenario at a noise, which leaves a file of rows."""

from collections.abc import Callable, Sequence
from concurrent.futures import Future
from pathlib import Path
from typing import Any

from soft_gripper.diagrams.recording.recording import Recording
from soft_gripper.diagrams.schema.scenario_file import load_scenario
from soft_gripper.diagrams.station import make_station
from soft_gripper.errors import InputError
from soft_gripper.evaluation.csv_table import read_csv, write_csv
from soft_gripper.evaluation.paper.scenario_run import SCENARIOS
from soft_gripper.evaluation.processes import call_in_processes
from soft_gripper.evaluation.robustness.finger_at_rest import touched_fingers
from soft_gripper.evaluation.robustness.robustness_table import RobustnessRow, robustness_table

Case = tuple[str, float]
CASES: tuple[Case, ...] = tuple((scenario, noise) for noise in (1.0, 4.0, 2.0, 0.0) for scenario in SCENARIOS)
FOLDER = "robustness"  # below that of the evaluation


def case_file(out: Path, case: Case) -> Path:
    """Where the rows of a case are, below the folder of the evaluation."""
    scenario, noise = case
    return out / FOLDER / scenario / f"noise_{noise:g}.csv"


def unfinished_cases(out: Path, seeds: int) -> list[Case]:
    """Of CASES, those of which there are no rows of so many seeds."""
    return [case for case in CASES if not _has_rows(case_file(out, case), seeds)]


def _has_rows(file: Path, seeds: int) -> bool:
    try:
        return all(row.seeds == seeds for row in read_csv(file, RobustnessRow))
    except InputError:
        return False


def run_cases(cases: Sequence[Case], out: Path, seeds: int, jobs: int, advance: Callable[[], Any]) -> None:
    """Runs cases in `jobs` processes on the recordings in `out`; `advance` is called after each.

    Raises:
        InputError: if a case fails; the others are finished first.
    """
    finished: list[Future[None]] = []

    def ended(call: object, future: Future[None]) -> None:
        finished.append(future)
        advance()

    call_in_processes(_work, [(*case, out, seeds) for case in cases], jobs, ended)
    for future in finished:
        future.result()


def _work(name: str, noise: float, out: Path, seeds: int) -> None:
    station, recording = make_station(load_scenario(name)), Recording.load(out / name / "recording.nc")
    file = case_file(out, (name, noise))
    file.parent.mkdir(parents=True, exist_ok=True)
    write_csv(file, robustness_table(name, touched_fingers(name, station, recording), noise, seeds))


def gather_maps(out: Path) -> list[RobustnessRow]:
    """The rows of all cases, which are written into one table."""
    rows = [
        row for case in sorted(CASES, key=lambda case: case[1]) for row in read_csv(case_file(out, case), RobustnessRow)
    ]
    write_csv(out / FOLDER / "robustness.csv", rows)
    return rows
