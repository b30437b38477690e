"""Declares the commands of this extra; each calls `run(options)` in the module of its name."""

from soft_gripper.commands.options import CONSOLE, Command, Group, folder_option
from soft_gripper.extras.sweeps.commands import EXECUTOR, RESUME

COMMANDS = (
    Command(
        "evaluate",
        "run the paper's evaluation with 1 to 4 sensors per side",
        (
            "                    write report.html, tables and figures, and check each claim",
            "--resume            finish an interrupted evaluation",
        ),
        (*CONSOLE, folder_option("results/evaluation"), *EXECUTOR, RESUME),
        package=__name__,
        group=Group.STUDY,
    ),
)
