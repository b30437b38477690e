"""soft-gripper evaluate: the paper's evaluation."""

import argparse
from collections.abc import Sequence
from concurrent.futures import Executor
from pathlib import Path

from soft_gripper.commands.terminal.console import Console, add_console_options
from soft_gripper.commands.terminal.options import (
    Subparsers,
    add_command,
    add_executor_options,
    add_out_folder,
    chosen_executor,
    whole_number,
)
from soft_gripper.commands.terminal.tables import print_claims
from soft_gripper.evaluation.paper.scenario_run import SCENARIOS, SECTIONS
from soft_gripper.evaluation.report.evaluate import RUNS, run_scenarios, summarize, unfinished
from soft_gripper.evaluation.report.report import Evaluation
from soft_gripper.evaluation.robustness.claims import realistic, summarize_robustness
from soft_gripper.evaluation.robustness.maps import CASES, FOLDER, run_cases, unfinished_cases
from soft_gripper.evaluation.robustness.plant_runs import RUNS as PLANT_RUNS
from soft_gripper.evaluation.robustness.plant_runs import run_plants, unfinished_runs
from soft_gripper.evaluation.robustness.plant_table import PlantRow
from soft_gripper.evaluation.robustness.table import RobustnessRow
from soft_gripper.files.output import claim_folder
from soft_gripper.runs.scores.poses import PoseRow, mean_errors, of_estimator
from soft_gripper.scenario.scenario_file import load_scenario


def add_parser(subparsers: Subparsers) -> None:
    """Declares the command."""
    parser = add_command(
        subparsers,
        "evaluate",
        "run the paper's evaluation with 1 to 4 sensors per side",
        "                    report.html, tables, figures, and whether each claim holds",
        "--robustness        also with sensors that err, wrong beliefs, and other plants",
        "--resume            what an interrupted one left",
    )
    add_console_options(parser)
    add_out_folder(parser, Path("results/evaluation"))
    add_executor_options(parser)
    parser.add_argument("--resume", action="store_true", help="run only what an interrupted evaluation left")
    parser.add_argument(
        "--robustness", action="store_true", help="also with sensors that err, wrong beliefs, and other plants"
    )
    parser.add_argument("--seeds", metavar="N", default="20", help="of --robustness (default: %(default)s)")
    parser.set_defaults(command=_run)


def _run(options: argparse.Namespace) -> int:
    opened = chosen_executor("evaluate", options)
    seeds = whole_number("evaluate", "--seeds", options.seeds, 1)
    out = claim_folder(options.out)
    with opened as executor:
        evaluation = _evaluate(out, options.resume, executor, options.console)
        robust = not options.robustness or _robustness(out, seeds, executor, options.resume, options.console)
    return 0 if robust and all(claim.holds for claim in evaluation.claims) else 1


def _evaluate(out: Path, resume: bool, executor: Executor, console: Console) -> Evaluation:
    """Runs the scenarios, and prints what comes of them."""
    try:
        names = unfinished(out) if resume else list(RUNS)
        duration = sum(load_scenario(name).duration for name in names)
        with console.seconds(duration, f"scenarios: {len(names)}") as bar:
            run_scenarios(names, out, executor, bar.update)
    except KeyboardInterrupt:
        print(f"\nMissing: {', '.join(unfinished(out))}; `soft-gripper evaluate --out {out} --resume` runs them")
        raise
    evaluation = summarize(out)
    _print_errors(of_estimator(evaluation.poses, "arcs"))
    _print_estimators(evaluation.poses)
    print_claims(evaluation.claims)
    console.table("poses", evaluation.poses)
    console.table("claims", evaluation.claims)
    print(f"\nFigures, and a folder for every scenario, are in {out}")
    console.wrote(*(out / file for file in ("report.html", "metrics.csv", "forces.csv", "contact.csv")))
    return evaluation


def _robustness(out: Path, seeds: int, executor: Executor, resume: bool, console: Console) -> bool:
    """Runs what there is on robustness; whether all its claims hold."""
    cases = unfinished_cases(out, seeds) if resume else CASES
    runs = unfinished_runs(out, seeds) if resume else PLANT_RUNS
    try:
        with console.counter(len(cases) + len(runs), "robustness") as bar:
            run_cases(cases, out, seeds, executor, bar.update)
            run_plants(runs, out, seeds, executor, bar.update)
    except KeyboardInterrupt:
        print(f"\n`soft-gripper evaluate --out {out} --robustness --seeds {seeds} --resume` goes on")
        raise
    found = summarize_robustness(out)
    _print_robustness(found.rows)
    _print_plants(found.plants)
    print_claims(found.claims)
    console.table("robustness_claims", found.claims)
    console.wrote(*(out / FOLDER / file for file in ("robustness.csv", "plants.csv", "robustness.png")))
    return all(claim.holds for claim in found.claims)


def _print_robustness(rows: Sequence[RobustnessRow]) -> None:
    """The belief that is worst for each number of sensors."""
    print(f"\n{'realistic sensors':<20}{'mean pose error [mm]':^32}{'95th percentile [mm]':^32}")
    for scenario in SCENARIOS:
        print(f"estimators, {scenario}")
        for name in dict.fromkeys(row.estimator for row in rows):
            cells = [[row for row in realistic(rows, name, n) if row.scenario == scenario] for n in SECTIONS]
            means, p95s = ([max(getattr(r, key) for r in cell) for cell in cells] for key in ("mean_mm", "p95_mm"))
            print(f"  {name:<18}" + "".join(f"{error:>8.2f}" for error in (*means, *p95s)))


def _print_plants(rows: Sequence[PlantRow]) -> None:
    """The scenario that is worst for each number of sensors."""
    print(f"\n{'other plants':<20}{'mean pose error [mm]':^32}{'95th percentile [mm]':^32}")
    for plant, name in dict.fromkeys((row.plant, row.estimator) for row in rows):
        cells = [[r for r in rows if (r.plant, r.estimator, r.sections) == (plant, name, n)] for n in SECTIONS]
        means, p95s = ([max(getattr(r, key) for r in cell) for cell in cells] for key in ("mean_mm", "p95_mm"))
        print(f"{plant + ', ' + name:<22}" + "".join(f"{error:>8.2f}" for error in (*means, *p95s)))


def _print_errors(rows: Sequence[PoseRow]) -> None:
    print(f"\n{'':<20}{'mean pose error [mm]':^32}{'mean fingertip error [mm]':^32}")
    print(f"{'sensors per side':<20}" + 2 * "".join(f"{n:>8}" for n in SECTIONS))
    for scenario in SCENARIOS:
        print(f"{scenario:<20}{_means(rows, scenario, '>8.2f')}")


def _print_estimators(rows: Sequence[PoseRow]) -> None:
    print()
    for scenario in SCENARIOS:
        print(f"estimators, {scenario}")
        for name in dict.fromkeys(row.estimator for row in rows):
            print(f"  {name:<18}{_means(of_estimator(rows, name), scenario, '>8.3f')}")


def _means(rows: Sequence[PoseRow], scenario: str, form: str) -> str:
    """Pose and fingertip error with 1 to 4 sensors per side."""
    means = [*mean_errors(rows, scenario, "pose_error_mm"), *mean_errors(rows, scenario, "tip_error_mm")]
    return "".join(f"{mean:{form}}" for mean in means)
