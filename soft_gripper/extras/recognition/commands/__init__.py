"""Commands of this extra, as the command line lists them."""

from soft_gripper.commands.options import (
    CONSOLE,
    EXECUTOR,
    SEED,
    Command,
    count,
    option,
    out,
    scenario_name,
)

COMMANDS = (
    Command(
        "recognition",
        "learn from random grasps to recognize the object held, and test it",
        ("--train 60 --test 50 --seed 1",),
        (
            *CONSOLE,
            option("scenario", "default: %(default)s", read=scenario_name, nargs="?", default="probing_grasp"),
            count("--train", "number of grasps of each shape for learning", 60, least=2),
            count("--test", "number of other grasps of each shape for testing", 50),
            SEED,
            *EXECUTOR,
            out("results/recognition"),
        ),
        package=__name__,
    ),
)
