"""Declares the commands of this extra; each calls `run(options)` in the module of its name."""

from soft_gripper.commands.options import CONSOLE, Command, Group, number, option, path, scenario

COMMANDS = (
    Command(
        "export",
        "write a scenario for MuJoCo, with a loader that runs it",
        ("box_grasp --out results/box_mujoco    scenario.xml (MJCF), meshes, commands.csv, run_mjcf.py",),
        (
            *CONSOLE,
            *scenario(),
            option("--time-step", "time step of the MJCF (default: that of the scenario)", "S", number(0.1)),
            option("--out", "folder for the files", "DIR", path, required=True),
        ),
        package=__name__,
        group=Group.DESIGN,
    ),
)
