"""Other plants, run: every scenario with every one of them is simulated once and leaves a recording and its rows."""

from collections.abc import Callable, Sequence
from concurrent.futures import Executor, Future
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from soft_gripper.diagrams.simulation import run_station
from soft_gripper.diagrams.station import make_station
from soft_gripper.errors import InputError
from soft_gripper.evaluation.paper.scenario_run import SCENARIOS
from soft_gripper.evaluation.robustness.maps import FOLDER
from soft_gripper.evaluation.robustness.plant_table import PlantRow, plant_table
from soft_gripper.evaluation.robustness.plants import PLANTS, touched_fingers
from soft_gripper.files.csv_table import read_csv, write_csv
from soft_gripper.files.output import is_whole, read_folder, write_folder
from soft_gripper.runs.executor import Call, make_calls

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


def run_plants(runs: Sequence[Run], out: Path, seeds: int, executor: Executor, advance: Callable[[], Any]) -> None:
    """Simulates runs, each into its own folder; `advance` is called after each.

    Raises:
        InputError, SimulationDivergedError, WorkerDiedError: if a run fails; the others are finished first.
    """
    failed: list[BaseException] = []

    def ended(call: Call, future: Future[dict[str, bytes]]) -> None:
        plant, scenario, _ = call
        if error := future.exception():
            failed.append(error)
        else:
            write_folder(run_folder(out, (plant, scenario)), future.result())
        advance()

    make_calls(executor, run_plant, [(*run, seeds) for run in runs], ended)
    if failed:
        raise failed[0]


def run_plant(plant_name: str, name: str, seeds: int) -> dict[str, bytes]:
    """The files of a run, by their names: model files, recording.nc and rows.csv."""
    (plant,) = (plant for plant in PLANTS if plant.name == plant_name)
    with TemporaryDirectory(prefix="soft-gripper-") as temporary:
        folder = Path(temporary)
        station = make_station(plant.scenario(name, folder))
        recording = run_station(station)
        recording.save(folder / "recording.nc")
        write_csv(folder / TABLE, plant_table(plant, name, touched_fingers(name, station, recording), seeds))
        return read_folder(folder)


def gather_plants(out: Path) -> list[PlantRow]:
    """The rows of all runs, which are written into one table."""
    rows = [row for run in RUNS for row in read_csv(run_folder(out, run) / TABLE, PlantRow)]
    write_csv(out / FOLDER / "plants.csv", rows)
    return rows
