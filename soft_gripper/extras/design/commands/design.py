"""soft-gripper design: searches the best design of a gripper for a set of objects, and tests it."""

import argparse
import time
from dataclasses import replace
from typing import Any

from soft_gripper.extras.design.figure import design_figure
from soft_gripper.extras.design.files import design_files, write_design
from soft_gripper.extras.design.run_design import SHIPPED, TABLE, DesignResult, most_runs, own_measures, run_design
from soft_gripper.extras.design.study_file import load_design_study
from soft_gripper.extras.design.study_tables import (
    Table,
    design_rows,
    reason,
    sensitivity_rows,
    short_names,
    test_rows,
    write_tables,
)
from soft_gripper.extras.sweeps.agreement import AGREEMENT, agreement_with_drake, print_agreement
from soft_gripper.extras.sweeps.executor import open_executor
from soft_gripper.extras.sweeps.job_progress import count_jobs
from soft_gripper.files.output import lock_folder
from soft_gripper.files.row_table import print_rows, print_table
from soft_gripper.pictures.style import save_figure
from soft_gripper.scenario.scenario_file import changed_scenario, files_read

FIGURE, BEST = "design", "best"
_SHOWN_DESIGNS = 5  # designs of the front


def run(options: argparse.Namespace) -> int:
    """Runs the command; fails if no design is allowed."""
    loaded_study = study = load_design_study(options.study)
    if options.engine is not None:
        study = replace(loaded_study, fixed={**loaded_study.fixed, "engine": options.engine})
    scenario = changed_scenario(study.scenario, study.fixed)
    file_names = [TABLE, *(f"{BEST}/{name}" for name in design_files(scenario))]
    lock_folder(options.out, file_names, [options.study, *files_read(study.scenario, scenario)])
    executor = open_executor(options.jobs, options.scheduler)
    warning = f"their results are in {options.out / TABLE}; --resume runs the others"
    begin = time.monotonic()
    with count_jobs(options.console, most_runs(study), "runs", warning) as report, executor as workers:
        result = run_design(study, options.out, workers, options.resume, lambda is_held: report())
        measures = list(own_measures(study).values())
        pairs = agreement_with_drake(study.scenario, result.tests, options.check, study.config.seed, workers, measures)
    minutes = (time.monotonic() - begin) / 60
    files = [options.out / name for name in write_tables(result, options.out)]
    save_figure(design_figure(result), options.out / FIGURE)
    files += [options.out / f"{FIGURE}{suffix}" for suffix in (".png", ".svg")]
    if result.best is not None:
        files += write_design(loaded_study, result.designs[result.best].values, options.out / BEST)
    tests = test_rows(result)
    sensitivities = sensitivity_rows(result)
    _print(result, minutes, tests)
    if result.best is not None and sensitivities:
        print_rows(sensitivities, "What matters, among the designs that were tried")
    if pairs:
        print_agreement(pairs, options.console, options.out)
        files.append(options.out / AGREEMENT)
    options.console.document["tests"] = tests
    options.console.table("sensitivity", sensitivities)
    options.console.wrote(options.out / TABLE, *files)
    return 0 if result.best is not None else 1


def _print(result: DesignResult, minutes: float, tests: Table) -> None:
    """Prints the best designs of the front by the first end, and the best one in the test, on new draws."""
    refusals = sum(bool(design.score.refused) for design in result.designs)
    allowed = sum(design.score.is_allowed for design in result.designs[1:])
    count = len(result.designs) - 1
    print(
        f"{count} designs in {minutes:.1f} minutes: {refusals} refused before a run, {allowed} hold within all limits"
    )
    if result.best is None:
        print(f"No design holds within all limits; of the last: {reason(result, count)}")
        return
    rows = design_rows(result)
    end = result.study.config.ends[0].measure
    shown_designs = [SHIPPED, result.best, *(i for i in result.front if i != result.best)][: 1 + _SHOWN_DESIGNS]
    names = [name for name in rows[0] if name not in ("allowed", "front", "reason")]
    title = f"Pareto front, {len(result.front)} designs; by {end} design {result.best} is best; {SHIPPED} is as it is"
    _print_table(short_names(names), [[rows[i][name] for name in names] for i in shown_designs], title)
    changes_text = ", ".join(f"{key} = {_shorten(value)}" for key, value in result.reference.values.items())
    drive = f"the fingers as they are, at their best drive: {changes_text}" if changes_text else "the scenario as it is"
    title = f"Test, with new draws; the reference, {result.reference.number}, is {drive}"
    _print_table(list(tests[0]), [list(row.values()) for row in tests], title)
    for name in result.study.objects:
        reference, best = (row[end] for row in tests if row["object"] == name)
        print(f"{end} of the best design with {name}: {best / reference:.2f} times that of the reference")


def _print_table(names: list[str], rows: list[list[Any]], title: str) -> None:
    columns = {name.replace("_percent", " [%]"): ">" for name in names}
    print_table(columns, [[*map(_shorten, row)] for row in rows], title)


def _shorten(value: object) -> str:
    return f"{value:.4g}" if isinstance(value, float) else "" if value is None else str(value)
