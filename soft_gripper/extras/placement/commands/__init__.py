"""Commands of this extra, as the command line lists them."""

import argparse

from soft_gripper.commands.options import (
    CONSOLE,
    SEED,
    Command,
    Group,
    number,
    option,
    out,
    path,
    preset,
    scenario_list,
    whole,
)
from soft_gripper.errors import InputError


def _check_place_sensors(options: argparse.Namespace) -> None:
    if options.recordings and options.scenarios:
        expected = "omit it: sensors are placed either for scenarios or for recordings"
        raise InputError("place-sensors", "--scenarios", ",".join(options.scenarios), expected)


COMMANDS = (
    Command(
        "place-sensors",
        "find the best sensors of a finger, and boundaries between its sections",
        (
            "--count 3",
            "--count 2 --recordings results/a/recording.nc results/b/recording.nc",
            "--count 8 --scenarios turned_box_grasp    fingers that leave their plane: kinds, numbers and paths",
        ),
        (
            *CONSOLE,
            option(
                "--count",
                "sections along each side of a finger, at most; in space, its sensors, at most",
                "N",
                whole(1),
                required=True,
            ),
            option(
                "--estimator",
                "whose errors are reported: built-in, or your own as MODULE:FUNCTION (default: %(default)s)",
                "NAME",
                default="contact",
            ),
            option(
                "--scenarios", "scenarios to place sensors for (default: those of `evaluate`)", "A,B", scenario_list
            ),
            option(
                "--recordings",
                "recording.nc of runs to place sensors for, instead of scenarios",
                "FILE",
                path,
                nargs="+",
            ),
            option(
                "--sensors",
                "preset of sensor errors, or ideal (default: %(default)s)",
                "PRESET",
                preset,
                default="realistic",
            ),
            option(
                "--nominal-error",
                "by how much the nominal model is too stiff or too soft (default: %(default)g)",
                "PERCENT",
                number(100.0, is_most_allowed=False),
                default=10.0,
            ),
            option(
                "--contacts",
                "contacts.nc of `study contact-trials`: place sensors for these as well",
                "FILE",
                path,
            ),
            SEED,
            out("results/place_sensors"),
        ),
        _check_place_sensors,
        package=__name__,
        group=Group.DESIGN,
    ),
)
