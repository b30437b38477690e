"""soft-gripper evaluate: the paper's evaluation."""

import argparse
from collections.abc import Sequence
from concurrent.futures import Executor
from pathlib import Path

from soft_gripper.commands.console import Console
from soft_gripper.extras.paper.bars import ARCS
from soft_gripper.extras.paper.commands.printing import print_claims, print_sensor_errors
from soft_gripper.extras.paper.evaluate import RUNS, run_scenarios, summarize, unfinished_runs
from soft_gripper.extras.paper.page import Evaluation
from soft_gripper.extras.paper.pose_rows import estimator_rows, mean_errors
from soft_gripper.extras.paper.scenario_run import SCENARIOS
from soft_gripper.extras.sweeps.executor import open_executor
from soft_gripper.files.output import lock_folder
from soft_gripper.runs.scores.poses import PoseRow
from soft_gripper.scenario.scenario_file import load_scenario


def run(options: argparse.Namespace) -> int:
    """Runs the command."""
    opened = open_executor(options.jobs, options.scheduler)
    out = lock_folder(options.out)
    with opened as executor:
        evaluation = _evaluate(out, options.resume, executor, options.console)
    return 0 if all(claim.holds for claim in evaluation.claims) else 1


def _evaluate(out: Path, resume: bool, executor: Executor, console: Console) -> Evaluation:
    """Runs the scenarios and prints their results."""
    try:
        names = unfinished_runs(out) if resume else list(RUNS)
        duration = sum(load_scenario(name).duration for name in names)
        with console.seconds_bar(duration, f"scenarios: {len(names)}") as bar:
            run_scenarios(names, out, executor, bar.update)
    except KeyboardInterrupt:
        print(f"\nMissing: {', '.join(unfinished_runs(out))}; `soft-gripper evaluate --out {out} --resume` runs them")
        raise
    evaluation = summarize(out)
    _print_errors(evaluation.poses)
    print_claims(evaluation.claims)
    console.table("poses", evaluation.poses)
    console.table("claims", evaluation.claims)
    print(f"\nFigures and a folder for each scenario are in {out}")
    console.wrote(*(out / file for file in ("report.html", "metrics.csv", "forces.csv", "contact.csv")))
    return evaluation


def _print_errors(rows: Sequence[PoseRow]) -> None:
    """Prints mean errors of the arcs by scenario, and of all estimators in each scenario."""
    arcs = estimator_rows(rows, ARCS)
    names = dict.fromkeys(row.estimator for row in rows)
    scenario_means = {scenario: _sensor_means(arcs, scenario) for scenario in SCENARIOS}
    print_sensor_errors(f"mean errors of {ARCS}", ("pose", "tip"), scenario_means, ".2f")
    for scenario in SCENARIOS:
        errors = {name: _sensor_means(estimator_rows(rows, name), scenario) for name in names}
        print_sensor_errors(f"{scenario}: mean errors", ("pose", "tip"), errors, ".3f")


def _sensor_means(rows: Sequence[PoseRow], scenario: str) -> list[float]:
    """Mean pose and fingertip errors, mm, with 1 to 4 sensors per side."""
    return [*mean_errors(rows, scenario, "pose_error_mm"), *mean_errors(rows, scenario, "tip_error_mm")]
