"""soft-gripper recognition: learns from random grasps to recognize the object held, and tests it on others."""

import argparse
from collections.abc import Mapping

import numpy as np

from soft_gripper.arrays import Array
from soft_gripper.commands.tables import print_table
from soft_gripper.extras.recognition.object_classifier import UNKNOWN, save_object_classifier
from soft_gripper.extras.recognition.random_grasps import (
    SECTIONS,
    SETS,
    SHAPES,
    check_scenario_for_recognition,
    confusion,
    confusion_figure,
    grasp_row,
    left_out,
    run_grasps,
    train,
)
from soft_gripper.files.csv_table import write_csv
from soft_gripper.files.output import lock_folder
from soft_gripper.pictures.style import save_figure
from soft_gripper.runs.executor import open_executor

TABLE, FIGURE = "grasps.csv", "recognition"


def run(options: argparse.Namespace) -> None:
    """Runs the command."""
    numbers = dict(zip(SETS, (options.train, options.test), strict=True))
    executor = open_executor(options.jobs, options.scheduler)
    check_scenario_for_recognition(options.scenario)
    out = lock_folder(options.out)
    total, kept = sum(numbers.values()) * len(SHAPES), "nothing is written until the last"
    with options.console.jobs(total, "grasps", kept) as ended, executor as opened:
        grasps = run_grasps(options.scenario, numbers, options.seed, opened, ended)
    models = {sections: train(options.scenario, grasps, sections) for sections in SECTIONS}
    rows = [grasp_row(grasp, models) for grasp in grasps]
    matrices = {sections: confusion(rows, sections) for sections in SECTIONS}
    write_csv(out / TABLE, rows)
    for sections, model in models.items():
        save_object_classifier(model, out / _model_file(sections))
    save_figure(confusion_figure(list(SHAPES), matrices, numbers[SETS[1]]), out / FIGURE)
    _print_summary(matrices, numbers[SETS[1]])
    for sections in SECTIONS:
        unknown = ", ".join(
            f"{shape} {share:.0f} %" for shape, share in left_out(options.scenario, grasps, sections).items()
        )
        print(f"{sections} sections, unknown to a model that was trained without the shape: {unknown}")
    for row in rows:
        if row.cause:
            print(f"{row.set} grasp {row.grasp} of the {row.shape}: {row.cause}")
    files = [TABLE, *map(_model_file, SECTIONS), f"{FIGURE}.png", f"{FIGURE}.svg"]
    options.console.table("grasps", rows)
    options.console.wrote(*(out / file for file in files))


def _model_file(sections: int) -> str:
    return f"objects_{sections}_sections.json"


def _print_summary(matrices: Mapping[int, Array], number: int) -> None:
    """Prints, for each shape, how its test grasps were classified."""
    for sections, matrix in matrices.items():
        right, total = float(np.trace(matrix)), number * len(SHAPES)
        title = f"{sections} sections: {right:.4g} of {total} right ({100 * right / total:.1f} %)"
        rows = [(shape, *counts) for shape, counts in zip(SHAPES, matrix, strict=True)]
        print_table({"held": "", **dict.fromkeys([*SHAPES, UNKNOWN], ".4g")}, rows, title)
