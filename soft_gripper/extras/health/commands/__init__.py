"""Declares the commands of this extra; each calls `run(options)` in the module of its name."""

from soft_gripper.commands.options import CONSOLE, SEED, Command, Group, count, folder_option
from soft_gripper.extras.sweeps.commands import EXECUTOR

COMMANDS = (
    Command(
        "study health",
        "count how many faults of sensors and fingers are found and named, how soon",
        ("                         the runs of the documentation", "--runs 16 --out results/some"),
        (
            *CONSOLE,
            count("--runs", "number of runs with a fault, and of runs without", 200),
            SEED,
            *EXECUTOR,
            folder_option("results/health"),
        ),
        package=__name__,
        group=Group.STUDY,
    ),
)
