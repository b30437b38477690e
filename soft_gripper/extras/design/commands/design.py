"""soft-gripper design: searches the best design of a gripper for a set of objects, and tests it."""

import argparse
import time
from collections.abc import Sequence
from concurrent.futures import Executor
from dataclasses import replace

from scipy.stats import binomtest

from soft_gripper.commands.printing import AGREEMENT, print_agreement
from soft_gripper.extras.design.figure import design_figure
from soft_gripper.extras.design.files import design_files, write_design
from soft_gripper.extras.design.run_design import TABLE, Designed, most_runs, own_measures, run_design, tested_runs
from soft_gripper.extras.design.sensitivity import Sensitivity
from soft_gripper.extras.design.study_file import load_design_study
from soft_gripper.extras.design.study_tables import (
    TestRow,
    reason,
    sensitivity_rows,
    short_names,
    test_rows,
    write_tables,
)
from soft_gripper.files.output import lock_folder
from soft_gripper.files.row_table import print_table
from soft_gripper.pictures.style import save_figure
from soft_gripper.runs.agreement import Agreement, chosen
from soft_gripper.runs.executor import open_executor
from soft_gripper.runs.sweep.run_sweep import ERROR, agreement_with_drake
from soft_gripper.scenario.scenario_file import changed_scenario, files_read
from soft_gripper.scenario.schema import DRAKE

FIGURE, BEST = "design", "best"
_SHOWN = 5  # designs of the front


def run(options: argparse.Namespace) -> int:
    """Runs the command; fails if no design is allowed."""
    loaded = study = load_design_study(options.study)
    if options.engine is not None:
        study = replace(loaded, fixed={**loaded.fixed, "engine": options.engine})
    scenario = changed_scenario(study.scenario, study.fixed)
    written = [TABLE, *(f"{BEST}/{name}" for name in design_files(scenario))]
    lock_folder(options.out, written, [options.study, *files_read(study.scenario, scenario)])
    executor = open_executor(options.jobs, options.scheduler)
    kept = f"their results are in {options.out / TABLE}; --resume runs the others"
    begin = time.monotonic()
    with options.console.jobs(most_runs(study), "runs", kept) as report, executor as opened:
        found = run_design(study, options.out, opened, options.resume, lambda held: report())
        agreed = _in_drake(found, options.check, opened)
    minutes = (time.monotonic() - begin) / 60
    files = [options.out / name for name in write_tables(found, options.out)]
    save_figure(design_figure(found), options.out / FIGURE)
    files += [options.out / f"{FIGURE}{suffix}" for suffix in (".png", ".svg")]
    if found.best is not None:
        files += write_design(loaded, found.designs[found.best].values, options.out / BEST)
    _print(found, minutes, options.jobs)
    if agreed:
        print_agreement(agreed, options.console, options.out)
        files.append(options.out / AGREEMENT)
    options.console.table("tests", test_rows(found))
    options.console.table("sensitivity", sensitivity_rows(found))
    options.console.wrote(options.out / TABLE, *files)
    return 0 if found.best is not None else 1


def _in_drake(found: Designed, checked: int, executor: Executor) -> list[Agreement]:
    """How runs of the test in another engine agree with some of them in Drake, if that is asked for."""
    study, runs = found.study, [each for each in tested_runs(found) if each[0][ERROR] == ""]
    picked = [runs[i] for i in chosen(len(runs), checked, study.config.seed)]
    changes = [{**each, "engine": DRAKE} for _, each in picked]
    rows, own = [row for row, _ in picked], [*own_measures(study).values()]
    return agreement_with_drake(study.scenario, rows, changes, executor, own)


def _print(found: Designed, minutes: float, jobs: int) -> None:
    refused = sum(bool(design.score.refused) for design in found.designs)
    allowed = sum(design.score.is_allowed for design in found.designs[1:])
    tried = len(found.designs) - 1
    print(f"{tried} designs in {minutes:.1f} minutes: {refused} refused before a run, {allowed} hold within all limits")
    if found.best is None:
        print(f"No design holds within all limits; of the last: {reason(found, tried)}")
        return
    _print_front(found)
    _print_tests(found, test_rows(found))
    _print_sensitivities(found, sensitivity_rows(found))


def _print_front(found: Designed) -> None:
    """The best designs of the front by the first end, after the scenario as it is."""
    config, keys = found.study.config, [axis.key for axis in found.study.axes]
    front = sorted(found.front, key=lambda i: found.designs[i].number != found.designs[found.best or 0].number)
    columns = (
        {"design": ""}
        | dict.fromkeys(short_names(keys), ">")
        | {"held": ">"}
        | {end.measure: ">" for end in config.ends}
    )
    cells = []
    for i in [0, *front[:_SHOWN]]:
        design, score = found.designs[i], found.designs[i].score
        name = "as it is" if i == 0 else f"{design.number}{', best' if i == found.best else ''}"
        values = [_short(design.values.get(key, "")) for key in keys]
        ends = [f"{value:.3g}" for value in score.ends or [float("nan")] * len(config.ends)]
        cells.append((name, *values, f"{score.held} of {score.runs}", *ends))
    print_table(columns, cells, f"Pareto front, {len(found.front)} designs; the best by {config.ends[0].measure} first")


def _short(value: object) -> str:
    return f"{value:.4g}" if isinstance(value, float) else str(value)


def _print_tests(found: Designed, rows: Sequence[TestRow]) -> None:
    """The best design beside the reference, on draws that the search was not given."""
    ends = [end.measure for end in found.study.config.ends]
    columns = {"object": "", "design": "", "held": ">", "95 % confidence": ">"} | dict.fromkeys(ends, ".3g")
    cells = []
    for row in sorted(rows, key=lambda row: (row.unseen, row.object, row.design)):
        low, high = binomtest(row.held, row.runs).proportion_ci(0.95, "wilson")
        name = f"{row.object}{', unseen' if row.unseen else ''}"
        likely = f"{100 * low:.0f} to {100 * high:.0f} %"
        cells.append(
            (name, str(row.design) if row.design > 0 else "reference", f"{row.held} of {row.runs}", likely, *row.ends)
        )
    changed = ", ".join(f"{key} = {_short(value)}" for key, value in found.reference.values.items())
    reference = f"the fingers as they are, at their best drive: {changed}" if changed else "the scenario as it is"
    print_table(columns, cells, f"Test, with new draws; the reference is {reference}")
    for name in found.study.objects:
        reference_row, best = sorted((row for row in rows if row.object == name), key=lambda row: row.design)
        ratio = best.ends[0] / reference_row.ends[0]
        print(f"{ends[0]} of the best design with {name}: {ratio:.2f} times that of the reference")


def _print_sensitivities(found: Designed, rows: Sequence[Sensitivity]) -> None:
    keys = [axis.key for axis in found.study.axes]
    names = dict(zip(keys, short_names(keys), strict=True))
    if rows:
        columns = {"end": "", "variable": "", "slope of ranks": "+.2f", "explained": ".2f", "of": ".2f", "designs": "d"}
        cells = ((row.end, names[row.variable], row.slope, row.explained, row.together, row.designs) for row in rows)
        print_table(columns, cells, "What matters, among the designs that were tried")
