"""Declares the commands of this extra; each calls `run(options)` in the module of its name."""

from soft_gripper.commands.options import HOST, Command, Group, option, path, scenario

COMMANDS = (
    Command(
        "play",
        "move the gripper yourself, live in a browser",
        (
            "box_grasp                        command pressures with sliders and keys",
            "tip_distance_steps               command the gripper opening, held by its controller",
            "pick_and_place_box --grip pressure --set sensor.sections=2",
        ),
        (
            *scenario("box_grasp"),
            option(
                "--grip",
                "what the sliders command (default: the opening if the scenario controls it)",
                choices=("pressure", "opening"),
            ),
            option("--out", "folder for recordings (default: results/play/SCENARIO)", "DIR", path),
            HOST,
        ),
        package=__name__,
        group=Group.START,
    ),
)
