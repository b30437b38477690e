"""The jobs of the robustness study: every scenario with sensors of every noise, and with every other plant.

Each job writes a folder with its rows; those of a plant also have its recording and models.
"""

from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import Executor
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from soft_gripper.diagrams.recording import Recording
from soft_gripper.diagrams.simulation import run_station
from soft_gripper.diagrams.station import make_private_station
from soft_gripper.errors import InputError
from soft_gripper.evaluation.paper.scenario_run import SCENARIOS
from soft_gripper.extras.studies.robustness.plants import PLANTS, touched_fingers
from soft_gripper.extras.studies.robustness.rows import NOISES, PlantRow, RobustnessRow, plant_table, robustness_table
from soft_gripper.files.output import is_whole, read_folder, write_folder
from soft_gripper.files.row_table import Row, read_csv, write_csv
from soft_gripper.runs.study import run_study
from soft_gripper.scenario.scenario_file import load_scenario

FOLDER = "robustness"  # below that of the evaluation
TABLE = "rows.csv"
NOISE_JOBS = {f"{scenario}/noise_{noise:g}": (scenario, noise) for noise in NOISES for scenario in SCENARIOS}
PLANT_JOBS = {f"{plant.name.replace(' ', '_')}/{name}": (plant.name, name) for plant in PLANTS for name in SCENARIOS}


def unfinished(out: Path, seeds: int, estimators: Sequence[str]) -> list[str]:
    """The jobs, by folder, without complete rows for so many seeds and these estimators."""
    kinds: dict[str, type[Any]] = dict.fromkeys(NOISE_JOBS, RobustnessRow) | dict.fromkeys(PLANT_JOBS, PlantRow)
    return [job for job, kind in kinds.items() if not _is_finished(out / FOLDER / job, kind, seeds, estimators)]


def _is_finished(folder: Path, kind: type[Any], seeds: int, estimators: Sequence[str]) -> bool:
    try:
        rows = read_csv(folder / TABLE, kind) if is_whole(folder) else []
    except InputError:
        return False
    return {(row.seeds, row.estimator) for row in rows} == {(seeds, estimator) for estimator in estimators}


def run_robustness(
    jobs: Iterable[str],
    out: Path,
    seeds: int,
    estimators: Sequence[str],
    executor: Executor,
    advance: Callable[[], Any],
) -> None:
    """Runs jobs, each into its folder; those with noise on the recordings in `out`; `advance` is called after each.

    Raises:
        InputError, SimulationDivergedError, WorkerDiedError: if a job fails; the others are finished first.
    """
    wanted, shared = set(jobs), (seeds, tuple(estimators))
    noisy = {job: case for job, case in NOISE_JOBS.items() if job in wanted}
    recordings = {name: Recording.load(out / name / "recording.nc") for name in {name for name, _ in noisy.values()}}
    calls: dict[str, Sequence[Any]] = {
        job: (noise_files, *case, recordings[case[0]], *shared) for job, case in noisy.items()
    }
    calls |= {job: (plant_files, *run, *shared) for job, run in PLANT_JOBS.items() if job in wanted}
    folders = {out / FOLDER / job: call for job, call in calls.items()}
    run_study(executor, files_of_job, folders, write_folder, ended=lambda folder: advance())


def files_of_job(make: Callable[..., dict[str, bytes]], *arguments: Any) -> dict[str, bytes]:
    """The files of a job, by their names, from the function that makes them."""
    return make(*arguments)


def noise_files(
    name: str, noise: float, recording: Recording, seeds: int, estimators: Sequence[str]
) -> dict[str, bytes]:
    """The rows of a scenario at a noise, from its recording."""
    fingers = touched_fingers(name, make_private_station(load_scenario(name)), recording)
    with TemporaryDirectory(prefix="soft-gripper-") as folder:
        write_csv(Path(folder) / TABLE, robustness_table(name, fingers, noise, seeds, estimators))
        return read_folder(Path(folder))


def plant_files(plant_name: str, name: str, seeds: int, estimators: Sequence[str]) -> dict[str, bytes]:
    """The models, the recording and the rows of a scenario with another plant, which is simulated."""
    (plant,) = (plant for plant in PLANTS if plant.name == plant_name)
    with TemporaryDirectory(prefix="soft-gripper-") as temporary:
        folder = Path(temporary)
        station = make_private_station(plant.scenario(name, folder))
        recording = run_station(station)
        recording.save(folder / "recording.nc")
        fingers = touched_fingers(name, station, recording)
        write_csv(folder / TABLE, plant_table(plant, name, fingers, seeds, estimators))
        return read_folder(folder)


def gather(out: Path, jobs: Iterable[str], kind: type[Row], table: str) -> list[Row]:
    """The rows of all jobs of one kind, also written into one table."""
    rows = [row for job in jobs for row in read_csv(out / FOLDER / job / TABLE, kind)]
    write_csv(out / FOLDER / table, rows)
    return rows
