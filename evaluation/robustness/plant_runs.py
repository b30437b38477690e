"""Other plants, run: every scenario with every one of them is simulated once and leaves a recording and its rows."""

from collections.abc import Callable, Sequence
from concurrent.futures import Future
from pathlib import Path
from typing import Any

from soft_gripper.checksums import is_whole
from soft_gripper.diagrams.simulation import run_station
from soft_gripper.diagrams.station import make_station
from soft_gripper.errors import InputError
from soft_gripper.evaluation.csv_table import read_csv, write_csv
from soft_gripper.evaluation.paper.scenario_run import SCENARIOS
from soft_gripper.evaluation.processes import call_in_processes
from soft_gripper.evaluation.robustness.finger_at_rest import touched_fingers
from soft_gripper.evaluation.robustness.maps import FOLDER
from soft_gripper.evaluation.robustness.plant_table import PlantRow, plant_table
from soft_gripper.evaluation.robustness.plants import PLANTS
from soft_gripper.files import atomic_folder, remove_partial

Run = tuple[str, str]
RUNS: tuple[Run, ...] = tuple((plant.name, scenario) for plant in PLANTS for scenario in SCENARIOS)
TABLE = "rows.csv"


def run_folder(out: Path, run: Run) -> Path:
    """Where the files of a run are, below the folder of the evaluation."""
    plant, scenario = run
    return out / FOLDER / plant.replace(" ", "_") / scenario


def unfinished_runs(out: Path, seeds: int) -> list[Run]:
    """Of RUNS, those of which there are no rows of so many seeds."""
    folders = {run: run_folder(out, run) for run in RUNS}
    return [run for run, folder in folders.items() if not (is_whole(folder) and _has_rows(folder / TABLE, seeds))]


def _has_rows(file: Path, seeds: int) -> bool:
    try:
        return all(row.seeds == seeds for row in read_csv(file, PlantRow))
    except InputError:
        return False


def run_plants(runs: Sequence[Run], out: Path, seeds: int, jobs: int, advance: Callable[[], Any]) -> None:
    """Simulates runs in `jobs` processes; `advance` is called after each.

    Raises:
        InputError, SimulationDivergedError: if a run fails; the others are finished first.
    """
    finished: list[Future[None]] = []

    def ended(call: object, future: Future[None]) -> None:
        finished.append(future)
        advance()

    try:
        call_in_processes(run_plant, [(*run, out, seeds) for run in runs], jobs, ended)
    except KeyboardInterrupt:
        for run in runs:
            remove_partial(run_folder(out, run))
        raise
    for future in finished:
        future.result()


def run_plant(plant_name: str, name: str, out: Path, seeds: int) -> None:
    """Fills the folder of a run: model files, recording.nc and rows.csv; it appears when it is whole, or not at all."""
    (plant,) = (plant for plant in PLANTS if plant.name == plant_name)
    with atomic_folder(run_folder(out, (plant_name, name))) as partial:
        station = make_station(plant.scenario(name, partial))
        recording = run_station(station)
        recording.save(partial / "recording.nc")
        write_csv(partial / TABLE, plant_table(plant, name, touched_fingers(name, station, recording), seeds))


def gather_plants(out: Path) -> list[PlantRow]:
    """The rows of all runs, which are written into one table."""
    rows = [row for run in RUNS for row in read_csv(run_folder(out, run) / TABLE, PlantRow)]
    write_csv(out / FOLDER / "plants.csv", rows)
    return rows
