"""soft-gripper sweep: a scenario run with many values of its fields, in one table."""

import argparse
from pathlib import Path

from soft_gripper.pictures.style import save_figure
from soft_gripper.runs.executor import open_executor
from soft_gripper.runs.sweep.axes import Variation, points, read_axis
from soft_gripper.runs.sweep.figure import sweep_figure
from soft_gripper.runs.sweep.run import TABLE, run_sweep
from soft_gripper.runs.sweep.table import ERROR, NUMBER, SweepTable
from soft_gripper.scenario.scenario_file import read_override

FIGURE = "sweep"


def run(options: argparse.Namespace) -> int:
    """Runs the command."""
    axes = [read_axis(text) for text in options.vary]
    variations = points(axes, options.method, options.sample or 0, options.seed)
    fixed = dict(map(read_override, options.set))
    if options.sections is not None:
        fixed["sensor.sections"] = options.sections
    executor = open_executor(options.jobs, options.scheduler)
    fine: list[bool] = []  # of every run that has ended, whether it came off
    with options.console.counter(len(variations), "runs") as bar:

        def report(came_off: bool) -> None:
            fine.append(came_off)
            bar.set_postfix_str(f"{fine.count(False)} failed")
            bar.update()

        try:
            with executor as opened:
                table = run_sweep(
                    options.scenario,
                    variations,
                    options.out,
                    opened,
                    fixed=fixed,
                    resume=options.resume,
                    report=report,
                )
        except KeyboardInterrupt:
            bar.close()
            print(f"\n{len(fine)} of {len(variations)} runs ended; they are in {options.out / TABLE}, --resume goes on")
            raise
    files = [TABLE, *_draw(table, variations, options)]
    print(f"{len(variations)} runs, {fine.count(False)} failed")
    options.console.document["runs"] = [dict(zip(table.header, table.rows[i], strict=True)) for i in sorted(table.rows)]
    options.console.wrote(*(options.out / file for file in files))
    return 0


def _draw(table: SweepTable, variations: list[Variation], options: argparse.Namespace) -> list[str]:
    """Draws the figure, if the sweep has one; returns its files."""
    keys, rows = list(variations[0]), list(zip(*(table.rows[i] for i in sorted(table.rows)), strict=True))
    columns = dict(zip(table.header, rows, strict=True))
    measured = {name: cells for name, cells in columns.items() if name not in (NUMBER, ERROR, *keys)}
    title = f"{Path(options.scenario).stem}: {len(variations)} runs"
    figure = sweep_figure({key: columns[key] for key in keys}, measured, title)
    if figure is None:
        return []
    save_figure(figure, options.out / FIGURE)
    return [f"{FIGURE}.png", f"{FIGURE}.svg"]
