"""soft-gripper design: searches the best design of a gripper for a set of objects, and tests it."""

import argparse
import time
from collections.abc import Mapping
from copy import deepcopy
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

from soft_gripper.extras.design.figure import design_figure, short_names
from soft_gripper.extras.design.mould import cores, shell
from soft_gripper.extras.design.run_design import SHIPPED, TABLE, DesignResult, most_runs, own_measures, run_design
from soft_gripper.extras.design.study_file import DesignStudy, load_design_study
from soft_gripper.extras.design.study_tables import Table, design_rows, sensitivity_rows, test_rows, write_tables
from soft_gripper.extras.sweeps.agreement import AGREEMENT, agreement_with_drake, print_agreement
from soft_gripper.extras.sweeps.executor import open_executor
from soft_gripper.extras.sweeps.job_progress import count_jobs
from soft_gripper.files.output import atomic_folder, lock_folder
from soft_gripper.files.row_table import print_rows, print_table
from soft_gripper.fingers.finger import Finger
from soft_gripper.fingers.urdf import changed_urdf
from soft_gripper.pictures.section_figure import section_figure
from soft_gripper.pictures.style import save_figure
from soft_gripper.scenario.finger_changes import mounted_finger
from soft_gripper.scenario.model_files import model_path, mounted_fingers
from soft_gripper.scenario.scenario_file import changed_scenario, dump_scenario, files_read

FIGURE, BEST, SCENARIO = "design", "best", "scenario.yaml"
_SHOWN_DESIGNS = 5  # designs of the front


def run(options: argparse.Namespace) -> int:
    """Runs the command; fails if no design is allowed."""
    loaded_study = study = load_design_study(options.study)
    if options.engine is not None:
        study = replace(loaded_study, fixed={**loaded_study.fixed, "engine": options.engine})
    scenario = changed_scenario(study.scenario, study.fixed)
    best_names = [SCENARIO, *(f"{model.name}.urdf" for model in scenario.models)]
    inputs = [options.study, *files_read(study.scenario, scenario)]
    lock_folder(options.out, [TABLE, *(f"{BEST}/{name}" for name in best_names)], inputs)
    executor = open_executor(options.jobs, options.scheduler)
    warning = f"their results are in {options.out / TABLE}; --resume runs the others"
    begin = time.monotonic()
    with count_jobs(options.console, most_runs(study), "runs", warning) as report, executor as workers:
        result = run_design(study, options.out, workers, options.resume, report)
        measures = own_measures(study)
        pairs = agreement_with_drake(study.scenario, result.tests, options.check, study.config.seed, workers, measures)
    minutes = (time.monotonic() - begin) / 60
    files = [options.out / name for name in write_tables(result, options.out)]
    save_figure(design_figure(result), options.out / FIGURE)
    files += [options.out / f"{FIGURE}{suffix}" for suffix in (".png", ".svg")]
    if result.best is not None:
        files += write_design(loaded_study, result.best.values, options.out / BEST)
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


def write_design(study: DesignStudy, values: Mapping[str, Any], folder: Path) -> list[Path]:
    """Writes a design into a folder; returns the files.

    The models with fingers become URDF files of their own, and the scenario uses these. Fingers that are alike share
    one drawing, one shell and their cores.
    """
    scenario = deepcopy(changed_scenario(study.scenario, {**study.fixed, **values}))
    fingers = list[Finger]()
    with atomic_folder(folder) as partial_folder:
        for model in scenario.models:
            if mounts := mounted_fingers(model, model.name):
                fingers += [element.finger for element in mounts]
                change = partial(mounted_finger, where=model.name, configs=model.fingers)
                file = f"{model.name}.urdf"
                text = changed_urdf(model_path(model.file), model.segments, model.name, model.without, change)
                (partial_folder / file).write_text(text, encoding="utf-8")
                model.file, model.fingers, model.segments, model.without = str(folder / file), {}, None, []
        (partial_folder / SCENARIO).write_text(dump_scenario(scenario, folder), encoding="utf-8")
        for finger in {repr(finger.unnamed): finger for finger in reversed(fingers)}.values():
            save_figure(section_figure(finger), partial_folder / f"{finger.name}_section")
            shell(finger).export(partial_folder / f"{finger.name}_shell.stl")
            for i, core in enumerate(cores(finger), 1):
                core.export(partial_folder / f"{finger.name}_core_{i}.stl")
        names = [file.name for file in partial_folder.iterdir()]
    return [folder / name for name in sorted(names)]


def _print(result: DesignResult, minutes: float, tests: Table) -> None:
    """Prints the best designs of the front by the first end, and the best one in the test, on new draws."""
    refusals = sum(bool(design.refused) for design in result.designs)
    allowed = sum(design.is_allowed for design in result.designs[1:])
    count = len(result.designs) - 1
    counts = f"{refusals} refused before a run, {allowed} hold within all limits"
    print(f"{count} designs in {minutes:.1f} minutes: {counts}")
    if result.best is None:
        print(f"No design holds within all limits; of the last: {result.designs[-1].reason}")
        return
    rows = design_rows(result)
    end = result.study.config.ends[0].measure
    best = result.best.number
    shown_designs = [SHIPPED, best, *(number for number in result.front if number != best)][: 1 + _SHOWN_DESIGNS]
    names = [name for name in rows[0] if name not in ("allowed", "front", "reason")]
    title = f"Pareto front, {len(result.front)} designs; by {end} design {best} is best; {SHIPPED} is as it is"
    _print_table(short_names(names), [[rows[i][name] for name in names] for i in shown_designs], title)
    changes_text = ", ".join(f"{key} = {_shorten(value)}" for key, value in result.reference.values.items())
    drive = f"the fingers as they are, at their best drive: {changes_text}" if changes_text else "the scenario as it is"
    title = f"Test, with new draws; the reference, {result.reference.number}, is {drive}"
    _print_table(list(tests[0]), [list(row.values()) for row in tests], title)
    for name in result.study.objects:
        reference_end, best_end = (row[end] for row in tests if row["object"] == name)
        print(f"{end} of the best design with {name}: {best_end / reference_end:.2f} times that of the reference")


def _print_table(names: list[str], rows: list[list[Any]], title: str) -> None:
    columns = {name.replace("_percent", " [%]"): ">" for name in names}
    print_table(columns, [[*map(_shorten, row)] for row in rows], title)


def _shorten(value: object) -> str:
    return f"{value:.4g}" if isinstance(value, float) else "" if value is None else str(value)
