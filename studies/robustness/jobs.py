"""The jobs of the robustness study: every scenario with sensors of every noise, and with every other plant."""

from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Executor
from itertools import product
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from soft_gripper.diagrams.recording import Recording
from soft_gripper.diagrams.simulation import run_station
from soft_gripper.diagrams.station import make_private_station
from soft_gripper.extras.paper.scenario_run import SCENARIOS, SECTIONS
from soft_gripper.files.output import writable_folder
from soft_gripper.files.row_table import Row, cells, columns, row_from_cells
from soft_gripper.runs.study import StudyTables
from soft_gripper.scenario.scenario_file import load_scenario
from studies.robustness.plants import PLANTS, touched_fingers
from studies.robustness.rows import (
    NOISES,
    NOMINAL_ERRORS,
    PlantRow,
    RobustnessRow,
    plant_table,
    robustness_table,
)

FOLDER = "robustness"  # below that of the evaluation
NOISE_JOBS = [(scenario, noise) for noise in NOISES for scenario in SCENARIOS]
PLANT_JOBS = [(plant.name, scenario) for plant in PLANTS for scenario in SCENARIOS]
Keys = list[tuple[str, ...]]  # of the rows of a job


def run_robustness(
    out: Path,
    seeds: int,
    estimators: Sequence[str],
    executor: Executor,
    report: Callable[[Any], Any],
    resume: bool = False,
) -> tuple[list[RobustnessRow], list[PlantRow]]:
    """Runs NOISE_JOBS, on the recordings of an evaluation, and PLANT_JOBS; their rows are in two tables.

    Args:
        out: folder of the evaluation; the tables are in FOLDER below it.
        seeds: sets of sensors to draw.
        estimators: names of shape estimators.
        executor: makes the calls.
        report: called with each job as it ends, or at once if its rows exist.
        resume: keep existing rows.

    Raises:
        InputError: if the study to be resumed is another one.
        InputError, SimulationDivergedError, WorkerDiedError: if a job fails; others of its table are finished first.
    """
    folder, shared = writable_folder(out / FOLDER), (seeds, tuple(estimators))
    recordings = {name: Recording.load(out / name / "recording.nc") for name in SCENARIOS}

    def run(name: str, kind: type[Row], work: Any, calls: Mapping[Any, Any], keys: Callable[[Any], Keys]) -> list[Row]:
        tables = StudyTables(folder, f"{name}.txt", {f"{name}.csv": columns(kind)}, len(keys(next(iter(calls)))[0]))
        tables.begin(f"seeds: {seeds}\nestimators: {' '.join(estimators)}\n", resume)

        def keep(job: Any, rows: list[Row]) -> None:
            for row in rows:
                tables.add(cells(row))

        tables.run(executor, work, calls, keep, ended=report, keys=keys)
        tables.finish(key for job in calls for key in keys(job))
        return [row_from_cells(row, kind) for (row,) in tables.rows.values()]

    def noise_keys(job: tuple[str, float]) -> Keys:
        each = product(NOMINAL_ERRORS, SECTIONS, estimators)
        return [(job[0], name, nominal.name, f"{job[1]:.6f}", str(sections)) for nominal, sections, name in each]

    def plant_keys(job: tuple[str, str]) -> Keys:
        return [(*job, name, str(sections)) for sections, name in product(SECTIONS, estimators)]

    noisy = {job: (*job, recordings[job[0]], *shared) for job in NOISE_JOBS}
    plants = {job: (*job, *shared) for job in PLANT_JOBS}
    return (
        run("robustness", RobustnessRow, noise_rows, noisy, noise_keys),
        run("plants", PlantRow, plant_rows, plants, plant_keys),
    )


def noise_rows(
    name: str, noise: float, recording: Recording, seeds: int, estimators: Sequence[str]
) -> list[RobustnessRow]:
    """The rows of a scenario at a noise, from its recording."""
    fingers = touched_fingers(name, make_private_station(load_scenario(name)), recording)
    return robustness_table(name, fingers, noise, seeds, estimators)


def plant_rows(plant_name: str, name: str, seeds: int, estimators: Sequence[str]) -> list[PlantRow]:
    """The rows of a scenario with another plant, which is simulated."""
    (plant,) = (plant for plant in PLANTS if plant.name == plant_name)
    with TemporaryDirectory(prefix="soft-gripper-") as folder:
        station = make_private_station(plant.scenario(name, Path(folder)))
        fingers = touched_fingers(name, station, run_station(station, described=False))
        return plant_table(plant, name, fingers, seeds, estimators)
