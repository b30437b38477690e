"""Commands of this extra, as the command line lists them."""

from soft_gripper.commands.options import (
    CONSOLE,
    Command,
    Group,
    number,
    option,
    path,
    scenario,
)

COMMANDS = (
    Command(
        "export",
        "write a scenario for another simulator, with a loader that runs it there",
        (
            "box_grasp --out results/box_mujoco    scenario.xml (MJCF), meshes, commands.csv, run_mjcf.py",
            "my_scenario.yaml --to sdf --out there    SDFormat, for Gazebo and others; without the pressures",
        ),
        (
            *CONSOLE,
            *scenario(),
            option("--to", "format (default: %(default)s)", choices=("mjcf", "sdf"), default="mjcf"),
            option("--time-step", "time step of the MJCF (default: that of the scenario)", "S", number(0.1)),
            option("--out", "folder for the files", "DIR", path, required=True),
        ),
        package=__name__,
        group=Group.DESIGN,
    ),
)
