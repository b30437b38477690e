"""Declares the commands of this extra; each calls `run(options)` in the module of its name."""

from soft_gripper.commands.options import CONSOLE, ENGINE, Command, Group, folder_option, option, path
from soft_gripper.extras.sweeps.commands import CHECK, EXECUTOR, RESUME

COMMANDS = (
    Command(
        "design",
        "search the best design of a gripper for a set of objects, and test it",
        (
            "examples/design/bottle.yaml --out results/bottle    tables, Pareto front, gripper, drawings, mould",
            "my_study.yaml --out results/mine --resume           go on after an interruption",
            "my_study.yaml --engine mujoco --check 100           in MuJoCo; a hundred runs of the test again in Drake",
        ),
        (
            *CONSOLE,
            option(
                "study",
                "YAML file: what varies, what must be held, and to which ends; see docs/extras/design/design.md",
                read=path,
            ),
            *(ENGINE, CHECK, RESUME, *EXECUTOR, folder_option("results/design")),
        ),
        package=__name__,
        group=Group.DESIGN,
    ),
)
