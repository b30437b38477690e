"""soft-gripper sweep: runs a scenario with many values of its fields, and writes one table."""

import argparse
from pathlib import Path

from soft_gripper.extras.sweeps.agreement import AGREEMENT, agreement_with_drake, print_agreement
from soft_gripper.extras.sweeps.axes import SweepPoint, read_axis, sweep_points
from soft_gripper.extras.sweeps.executor import open_executor
from soft_gripper.extras.sweeps.figure import sweep_figure
from soft_gripper.extras.sweeps.job_progress import count_jobs
from soft_gripper.extras.sweeps.measured_runs import DEPENDS, ERROR
from soft_gripper.extras.sweeps.sweep import NUMBER, TABLE, run_sweep
from soft_gripper.pictures.style import save_figure
from soft_gripper.runs.scores.slipping import as_predicted
from soft_gripper.scenario.scenario_file import read_override

FIGURE = "sweep"


def run(options: argparse.Namespace) -> int:
    """Runs the command; the exit code is 1 if every run failed."""
    axes = [read_axis(text) for text in options.vary]
    points = sweep_points(axes, options.method, options.sample or 0, options.seed)
    fixed_changes = dict(map(read_override, options.set))
    option_values = {"sensor.sections": options.sections, "engine": options.engine}
    fixed_changes |= {key: value for key, value in option_values.items() if value is not None}
    executor = open_executor(options.jobs, options.scheduler)
    note = f"their results are in {options.out / TABLE}; --resume runs the others"
    with count_jobs(options.console, len(points), "runs", note) as report, executor as opened:
        rows = run_sweep(
            options.scenario,
            points,
            options.out,
            opened,
            fixed=fixed_changes,
            own=options.measure,
            check_step=options.check_step,
            resume=options.resume,
            report=report,
        )
        runs = [(row, {**fixed_changes, **point}) for row, point in zip(rows, points, strict=True)]
        agreements = agreement_with_drake(options.scenario, runs, options.check, options.seed, opened, options.measure)
    files = [TABLE, *_draw(rows, points, options), *([AGREEMENT] if agreements else [])]
    failure_count = sum(row[ERROR] != "" for row in rows)
    print(f"{len(rows)} runs, {failure_count} failed")
    predicted_rows = [row for row in rows if row.get("predicted")]
    if predicted_rows:
        correct = sum(as_predicted(row["predicted"], row["grasp"]) for row in predicted_rows)
        print(f"Held or lost as predicted before the lift: {correct} of {len(predicted_rows)} runs")
    if options.check_step:
        flagged = sorted({name for row in rows for name in row[DEPENDS].split()})
        print(f"With half the time step, {', '.join(flagged) if flagged else 'nothing'} changes by more than 5 %")
    if agreements:
        print_agreement(agreements, options.console, options.out)
    options.console.document["runs"] = rows
    options.console.wrote(*(options.out / file for file in files))
    return 1 if failure_count == len(rows) else 0


def _draw(rows: list[dict[str, str]], points: list[SweepPoint], options: argparse.Namespace) -> list[str]:
    """Draws the figure, if the sweep has one; returns its files."""
    keys, columns = list(points[0]), {name: [row[name] for row in rows] for name in rows[0]}
    measure_cells = {name: cells for name, cells in columns.items() if name not in (NUMBER, DEPENDS, ERROR, *keys)}
    title = f"{Path(options.scenario).stem}: {len(points)} runs"
    figure = sweep_figure({key: columns[key] for key in keys}, measure_cells, title)
    if figure is None:
        return []
    save_figure(figure, options.out / FIGURE)
    return [f"{FIGURE}.png", f"{FIGURE}.svg"]
