"""python -m studies robustness: the evaluation again with sensor errors, wrong nominal models and other plants."""

import argparse
from collections.abc import Sequence

from soft_gripper.errors import InputError
from soft_gripper.estimators.named_estimators import SHAPE_FUNCTIONS, find_estimator
from soft_gripper.extras.paper.commands.printing import print_by_sensors, print_claims
from soft_gripper.extras.paper.scenario_run import SCENARIOS, SECTIONS, evaluated_scenario, is_finished
from soft_gripper.files.output import lock_folder
from soft_gripper.pictures.style import save_figure
from soft_gripper.runs.executor import open_executor
from studies.robustness.claims import map_figure, realistic, robustness_claims
from studies.robustness.jobs import FOLDER, NOISE_JOBS, PLANT_JOBS, run_robustness
from studies.robustness.rows import PlantRow, RobustnessRow


def run(options: argparse.Namespace) -> int:
    """Runs the command; the exit code is 1 if a claim does not hold."""
    opened, console, seeds = open_executor(options.jobs, options.scheduler), options.console, options.seeds
    for name in options.estimator:
        find_estimator(name, field="--estimator")
    out = lock_folder(options.out)
    if not all(is_finished(out / name, evaluated_scenario(name)) for name in SCENARIOS):
        raise InputError(
            "robustness", "--out", out, f"give the folder of an evaluation: soft-gripper evaluate --out {out}"
        )
    estimators = [*SHAPE_FUNCTIONS, *options.estimator]
    jobs = len(NOISE_JOBS) + len(PLANT_JOBS)
    kept = f"`python -m studies robustness --out {out} --seeds {seeds} --resume` runs the others"
    with console.jobs(jobs, "robustness jobs", kept) as ended, opened as executor:
        rows, plants = run_robustness(out, seeds, estimators, executor, lambda job: ended(), options.resume)
    save_figure(map_figure(rows), out / FOLDER / "robustness")
    claims = robustness_claims(rows, plants)
    _print_robustness(rows)
    _print_plants(plants)
    print_claims(claims)
    console.table("claims", claims)
    console.wrote(*(out / FOLDER / file for file in ("robustness.csv", "plants.csv", "robustness.png")))
    return 0 if all(claim.holds for claim in claims) else 1


def _print_robustness(rows: Sequence[RobustnessRow]) -> None:
    """The nominal model that is worst for each number of sensors."""
    names = dict.fromkeys(row.estimator for row in rows)
    for scenario in SCENARIOS:
        of_scenario = [row for row in rows if row.scenario == scenario]
        errors = {name: _worst([realistic(of_scenario, name, n) for n in SECTIONS]) for name in names}
        print_by_sensors(f"realistic sensors, {scenario}: pose error", ("mean", "p95"), errors, ".2f")


def _print_plants(rows: Sequence[PlantRow]) -> None:
    """Prints the worst scenario for each number of sensors."""
    errors = {}
    for plant, name in dict.fromkeys((row.plant, row.estimator) for row in rows):
        of_both = [row for row in rows if (row.plant, row.estimator) == (plant, name)]
        errors[f"{plant}, {name}"] = _worst([[row for row in of_both if row.sections == n] for n in SECTIONS])
    print_by_sensors("other plants: pose error", ("mean", "p95"), errors, ".2f")


def _worst(rows: Sequence[Sequence[RobustnessRow] | Sequence[PlantRow]]) -> list[float]:
    """Largest mean and largest 95th percentile of each group of rows."""
    return [max(getattr(row, key) for row in group) for key in ("mean_mm", "p95_mm") for group in rows]
