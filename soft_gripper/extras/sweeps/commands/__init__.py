"""Declares the commands of this extra, and options of others that make many runs.

Each command calls `run(options)` in the module of its name.
"""

import argparse
import os

from soft_gripper.commands.options import (
    CONSOLE,
    ENGINE,
    SEED,
    Command,
    Group,
    assignment,
    count,
    flag,
    option,
    path,
    scenario,
    whole,
)
from soft_gripper.errors import InputError

RESUME = flag("--resume", "run only what an interrupted run left unfinished")
CHECK = option(
    "--check", "repeat N of the runs in Drake, at random, and print how they agree", "N", whole(1), default=0
)
SCHEDULER = option(
    "--scheduler",
    "Dask scheduler whose workers to use instead, such as tcp://127.0.0.1:8786; see docs/cluster.md",
    "URL",
)
JOBS = option("--jobs", "number of processes (default: one per core)", "N", whole(1, 256), default=os.cpu_count() or 1)
EXECUTOR = (JOBS, SCHEDULER)


def _check_sweep(options: argparse.Namespace) -> None:
    options.method = options.method or ("grid" if options.sample is None else "latin")
    if (options.method == "grid") != (options.sample is None):
        expected = "give --sample N" if options.sample is None else "omit --sample: a grid has all combinations"
        raise InputError("sweep", "--method", options.method, expected)


COMMANDS = (
    Command(
        "sweep",
        "run a scenario with many values of its fields, and write one table",
        (
            "box_grasp --vary sensor.sections=1,2,4 --vary 'nominal.finger.length=-5..5 %:5' --out results/nominal",
            "tip_distance_steps --vary control.gains.ki=1e5..1e6 --sample 64 --seed 1 --out results/gains",
            "box_grasp --vary sensor.sections=1,2,4 --out results/sections --resume    finish an interrupted sweep",
        ),
        (
            *CONSOLE,
            *scenario(),
            ENGINE,
            CHECK,
            option(
                "--vary",
                "values or a range of a field, like pressure.maximum=1e5,2e5 or nominal.finger.length=-20..20 %%:5;"
                " whole numbers stay whole; may be repeated",
                "KEY=VALUES",
                assignment,
                action="append",
                required=True,
            ),
            option("--method", "default: grid; latin with --sample", choices=("grid", "latin", "sobol")),
            option("--sample", "number of points drawn from the values and ranges", "N", whole(1)),
            SEED,
            option(
                "--measure",
                "your own measure, a function of station and recording, as one more column; may be repeated",
                "MODULE:FUNCTION",
                action="append",
                default=[],
            ),
            flag("--check-step", "repeat each run with half the time step, and name the measures that depend on it"),
            option("--out", "folder for the table", "DIR", path, required=True),
            RESUME,
            *EXECUTOR,
        ),
        _check_sweep,
        package=__name__,
        group=Group.STUDY,
    ),
    Command(
        "tune",
        "find gains for the grip control of a gripper",
        ("                              tune the shipped gripper", "my_steps.yaml --evaluations 80"),
        (
            *CONSOLE,
            *scenario("tip_distance_steps"),
            count("--evaluations", "maximum number of simulations", 50, least=5),
            SCHEDULER,
        ),
        package=__name__,
        group=Group.DESIGN,
    ),
)
