"""The evaluation again with sensor errors, wrong nominal models and other plants: the command.

In: the folder of an evaluation. Out: tables, a summary as docs/studies/robustness.csv, a figure and claims. Sensors of
every noise read the recordings of the evaluation, every other plant is simulated; the tables have a row for each
estimator. Another table of the summary is an entry of `tables` in `summary`.
"""

import argparse
import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from itertools import product
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from soft_gripper.diagrams.recording import Recording
from soft_gripper.diagrams.simulation import run_station
from soft_gripper.diagrams.station import make_private_station
from soft_gripper.errors import InputError
from soft_gripper.estimators.named_estimators import SHAPE_FUNCTIONS, find_estimator
from soft_gripper.extras.paper.commands.printing import print_claims
from soft_gripper.extras.paper.scenario_run import SCENARIOS, SECTIONS, evaluated_scenario, is_finished
from soft_gripper.files.output import writable_folder
from soft_gripper.files.row_table import print_rows
from soft_gripper.pictures.style import save_figure
from soft_gripper.scenario.scenario_file import load_scenario
from studies.kept_rows import counted_jobs, kept_rows
from studies.robustness.claims import map_figure, realistic_rows, robustness_claims
from studies.robustness.plants import PLANTS, RUBBER, touched_fingers
from studies.robustness.rows import (
    NOISES,
    NOMINAL_ERRORS,
    PlantRow,
    RobustnessRow,
    nominal_name,
    plant_table,
    robustness_table,
)

FOLDER = "robustness"  # below that of the evaluation
NOISY, OTHERS, SUMMARY = "sensors.csv", "plants.csv", "robustness.csv"
SHOWN = "arcs", "gaussian", "recursive"  # estimators of the page
NOISE_JOBS = [(scenario, noise) for noise in NOISES for scenario in SCENARIOS]
PLANT_JOBS = [(plant.name, scenario) for plant in PLANTS for scenario in SCENARIOS]


def noise_rows(name: str, noise: float, out: Path, seeds: int, estimators: Sequence[str]) -> list[RobustnessRow]:
    """The rows of a scenario at a noise, from its recording below the folder of an evaluation."""
    recording = Recording.load(out / name / "recording.nc")
    fingers = touched_fingers(name, make_private_station(load_scenario(name)), recording)
    return robustness_table(name, fingers, noise, seeds, estimators)


def plant_rows(plant_name: str, name: str, seeds: int, estimators: Sequence[str]) -> list[PlantRow]:
    """The rows of a scenario with another plant, which is simulated."""
    (plant,) = (plant for plant in PLANTS if plant.name == plant_name)
    with TemporaryDirectory(prefix="soft-gripper-") as folder:
        station = make_private_station(plant.scenario(name, Path(folder)))
        fingers = touched_fingers(name, station, run_station(station, described=False))
        return plant_table(plant, name, fingers, seeds, estimators)


@dataclass(frozen=True)
class SummaryRow:
    """Errors or coverage with 1, 2 and 4 sensors per side, as the page prints them."""

    table: str
    scenario: str
    estimator: str
    sensors_1: str
    sensors_2: str
    sensors_4: str
    covered_percent_2: str = ""  # with two sensors, of another plant


def summary(
    rows: Sequence[RobustnessRow], plants: Sequence[PlantRow], estimators: Sequence[str] = SHOWN
) -> Iterator[SummaryRow]:
    """Yields summary rows: realistic sensors with the worst nominal model, coverage over nominal models, and rubber.

    Estimators without a covariance have errors with realistic sensors alone.
    """

    def errors(rows: Sequence[Any]) -> str:
        return f"{max(row.mean_mm for row in rows):.2f}/{max(row.p95_mm for row in rows):.2f}"

    def coverage(rows: Sequence[Any]) -> str:
        percents = [100 * row.coverage for row in rows]
        return f"{min(percents):.0f}-{max(percents):.0f}"

    scenarios, counts = list(dict.fromkeys(row.scenario for row in rows)), (1, 2, 4)
    tables: list[tuple[str, Callable[[Sequence[Any]], str]]] = [
        ("realistic sensors and worst nominal model: mean/95th percentile [mm]", errors),
        ("coverage of 95 % bands, least-greatest [%]", coverage),
    ]
    for (table, text), scenario, name in product(tables, scenarios, estimators):
        cells = [text([row for row in realistic_rows(rows, name, n) if row.scenario == scenario]) for n in counts]
        if "nan-nan" not in cells:
            yield SummaryRow(table, scenario, name, *cells)
    for scenario, name in product(scenarios, estimators):
        key = RUBBER.name, scenario, name
        rows_by_count = {row.sections: row for row in plants if (row.plant, row.scenario, row.estimator) == key}
        if not math.isnan(rows_by_count[2].coverage):
            cells = [*(errors([rows_by_count[n]]) for n in counts), f"{100 * rows_by_count[2].coverage:.0f}"]
            table = "another plant: mean/95th percentile [mm]"
            yield SummaryRow(table, scenario, name, *cells)


def run(options: argparse.Namespace) -> int:
    """Runs the command; the exit code is 1 if a claim does not hold."""
    console, out = options.console, options.out
    for name in options.estimator:
        find_estimator(name, field="--estimator")
    if not all(is_finished(out / name, evaluated_scenario(name)) for name in SCENARIOS):
        expected = f"give the folder of an evaluation: soft-gripper evaluate --out {out}"
        raise InputError("robustness", "--out", out, expected)
    estimators = [*SHAPE_FUNCTIONS, *options.estimator]
    settings = {"seeds": options.seeds, "estimators": estimators}
    pairs = list(product(map(str, SECTIONS), estimators))
    nominals = [nominal_name(*errors) for errors in NOMINAL_ERRORS]
    noise_jobs = {
        (name, noise): [(name, e, nominal, f"{noise:.6f}", n) for nominal in nominals for n, e in pairs]
        for name, noise in NOISE_JOBS
    }
    plant_jobs = {job: [(*job, e, n) for n, e in pairs] for job in PLANT_JOBS}
    note = f"`python -m studies robustness --out {out} --seeds {options.seeds} --resume` runs the others"
    with counted_jobs(options, len(noise_jobs) + len(plant_jobs), "robustness jobs", note) as (executor, ended):
        folder, run_by = writable_folder(out / FOLDER), (executor, ended, options.resume)
        rows = kept_rows(folder / NOISY, RobustnessRow, noise_rows, noise_jobs, {"evaluation": out} | settings, *run_by)
        plant_results = kept_rows(folder / OTHERS, PlantRow, plant_rows, plant_jobs, settings, *run_by)
    save_figure(map_figure(rows), folder / "robustness")
    claims = robustness_claims(rows, plant_results)
    summary_rows = list(summary(rows, plant_results, [*SHOWN, *options.estimator]))
    print_rows(summary_rows)
    console.table("robustness", summary_rows, folder / SUMMARY)
    print_claims(claims)
    console.table("claims", claims)
    console.wrote(*(folder / file for file in (SUMMARY, NOISY, OTHERS, "robustness.png")))
    return 0 if all(claim.holds for claim in claims) else 1
