"""soft-gripper sweep: a scenario run with many values of its fields, in one table."""

import argparse
from pathlib import Path

from soft_gripper.commands.terminal.console import add_console_options
from soft_gripper.commands.terminal.options import (
    MOST_SEED,
    Subparsers,
    add_command,
    add_executor_options,
    add_scenario_options,
    chosen_executor,
    path,
    whole_number,
)
from soft_gripper.errors import InputError
from soft_gripper.pictures.style import save_figure
from soft_gripper.runs.sweep.axes import METHODS, Axis, Variation, points, read_axis
from soft_gripper.runs.sweep.figure import sweep_figure
from soft_gripper.runs.sweep.run import ERROR, NUMBER, TABLE, run_sweep
from soft_gripper.scenario.scenario_file import read_override

NAME, FIGURE = "sweep", "sweep"
EXAMPLE = "such as pressure.maximum=1e5,2e5 or models.gripper.fingers.all.youngs_modulus=-20..20 %%:5"


def add_parser(subparsers: Subparsers) -> None:
    """Declares the command."""
    parser = add_command(
        subparsers,
        NAME,
        "run a scenario with many values of its fields: one table",
        "box_grasp --vary sensor.sections=1,2,4 --vary 'believed.youngs_modulus=-20..20 %:5' --out results/belief",
        "tip_distance_steps --vary control.gains.ki=1e5..1e6 --sample 64 --seed 1 --out results/gains",
        "box_grasp --vary sensor.sections=1,2,4 --out results/sections --resume    what an interrupted one left",
    )
    add_console_options(parser)
    add_scenario_options(parser)
    vary = f"values or a range of a field, {EXAMPLE}; whole numbers stay whole; may be repeated"
    parser.add_argument("--vary", metavar="KEY=VALUES", action="append", required=True, help=vary)
    parser.add_argument("--method", choices=METHODS, help="default: grid; latin with --sample")
    parser.add_argument("--sample", metavar="N", help="points drawn from the values and ranges")
    parser.add_argument("--seed", metavar="S", default="1", help="of these (default: %(default)s)")
    own = "a measure of your own, a function of station and recording: one more column; may be repeated"
    parser.add_argument("--measure", metavar="MODULE:FUNCTION", action="append", default=[], help=own)
    parser.add_argument("--out", metavar="DIR", type=path, required=True, help="folder of the table")
    parser.add_argument("--resume", action="store_true", help="run only what an interrupted sweep left")
    add_executor_options(parser)
    parser.set_defaults(command=_run)


def _run(options: argparse.Namespace) -> int:
    variations = _variations(options, [read_axis(text) for text in options.vary])
    fixed = dict(map(read_override, options.set))
    if options.sections is not None:
        fixed["sensor.sections"] = whole_number(NAME, "--sections", options.sections, 1)
    executor, kept = chosen_executor(NAME, options), f"they are in {options.out / TABLE}, --resume runs the others"
    with options.console.jobs(len(variations), "runs", kept) as report, executor as opened:
        rows = run_sweep(
            options.scenario,
            variations,
            options.out,
            opened,
            fixed=fixed,
            own=options.measure,
            resume=options.resume,
            report=report,
        )
    files = [TABLE, *_draw(rows, variations, options)]
    print(f"{len(rows)} runs, {sum(row[ERROR] != '' for row in rows)} failed")
    options.console.document["runs"] = rows
    options.console.wrote(*(options.out / file for file in files))
    return 0


def _variations(options: argparse.Namespace, axes: list[Axis]) -> list[Variation]:
    method = options.method or ("grid" if options.sample is None else "latin")
    if (method == "grid") != (options.sample is None):
        expected = "give --sample N" if options.sample is None else "leave --sample out: a grid has all combinations"
        raise InputError(NAME, "--method", method, expected)
    number = 0 if options.sample is None else whole_number(NAME, "--sample", options.sample, 1)
    return points(axes, method, number, whole_number(NAME, "--seed", options.seed, 0, MOST_SEED))


def _draw(rows: list[dict[str, str]], variations: list[Variation], options: argparse.Namespace) -> list[str]:
    """Draws the figure, if the sweep has one; returns its files."""
    keys, columns = list(variations[0]), {name: [row[name] for row in rows] for name in rows[0]}
    measured = {name: cells for name, cells in columns.items() if name not in (NUMBER, ERROR, *keys)}
    title = f"{Path(options.scenario).stem}: {len(variations)} runs"
    figure = sweep_figure({key: columns[key] for key in keys}, measured, title)
    if figure is None:
        return []
    save_figure(figure, options.out / FIGURE)
    return [f"{FIGURE}.png", f"{FIGURE}.svg"]
