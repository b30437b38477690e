"""soft-gripper recognition: which shape is held, learned from random grasps and tried on others."""

import argparse
from collections.abc import Mapping
from concurrent.futures import Executor
from contextlib import AbstractContextManager

import numpy as np

from soft_gripper.arrays import Array
from soft_gripper.commands.console import Console
from soft_gripper.evaluation.recognition import (
    SECTIONS,
    SETS,
    SHAPES,
    Grasp,
    check_scenario_for_recognition,
    confusion,
    confusion_figure,
    grasp_row,
    run_grasps,
    train,
)
from soft_gripper.files.csv_table import write_csv
from soft_gripper.files.output import lock_folder
from soft_gripper.pictures.style import save_figure
from soft_gripper.recognition.model_file import save_shape_model
from soft_gripper.runs.executor import open_executor

TABLE, FIGURE = "grasps.csv", "recognition"


def run(options: argparse.Namespace) -> None:
    """Runs the command."""
    numbers = dict(zip(SETS, (options.train, options.test), strict=True))
    executor = open_executor(options.jobs, options.scheduler)
    check_scenario_for_recognition(options.scenario)
    out = lock_folder(options.out)
    grasps = _run_grasps(options.scenario, numbers, options.seed, executor, options.console)
    models = {sections: train(options.scenario, grasps, sections) for sections in SECTIONS}
    rows = [grasp_row(grasp, models) for grasp in grasps]
    matrices = {sections: confusion(rows, sections) for sections in SECTIONS}
    write_csv(out / TABLE, rows)
    for sections, model in models.items():
        save_shape_model(model, out / _model_file(sections))
    save_figure(confusion_figure(list(SHAPES), matrices, numbers[SETS[1]]), out / FIGURE)
    _print_summary(matrices, numbers[SETS[1]])
    for row in rows:
        if row.cause:
            print(f"{row.set} grasp {row.grasp} of the {row.shape}: {row.cause}")
    files = [TABLE, *map(_model_file, SECTIONS), f"{FIGURE}.png", f"{FIGURE}.svg"]
    options.console.table("grasps", rows)
    options.console.wrote(*(out / file for file in files))


def _model_file(sections: int) -> str:
    return f"shapes_{sections}_sections.json"


def _run_grasps(
    file: str, numbers: Mapping[str, int], seed: int, executor: AbstractContextManager[Executor], console: Console
) -> list[Grasp]:
    total = sum(numbers.values()) * len(SHAPES)
    with console.counter(total, "grasps") as bar:
        ended = 0

        def report(grasp: Grasp) -> None:
            nonlocal ended
            ended += 1
            bar.update()

        try:
            with executor as opened:
                return run_grasps(file, numbers, seed, opened, report)
        except KeyboardInterrupt:
            bar.close()
            print(f"\n{ended} of {total} grasps ended; nothing is written before the last")
            raise


def _print_summary(matrices: Mapping[int, Array], number: int) -> None:
    """Of every shape, what its test grasps were recognized as."""
    for sections, matrix in matrices.items():
        right, total = int(np.trace(matrix)), number * len(SHAPES)
        print(f"\n{sections} sections: {right} of {total} right ({100 * right / total:.1f} %)")
        print(f"  {'held':<12}" + "".join(f"{shape:>12}" for shape in SHAPES))
        for shape, row in zip(SHAPES, matrix, strict=True):
            print(f"  {shape:<12}" + "".join(f"{count:>12}" for count in row))
