"""Declares the commands of this extra; each calls `run(options)` in the module of its name."""

import argparse
from collections import Counter
from pathlib import Path

from soft_gripper.commands.options import (
    CONSOLE,
    ENGINE,
    SEED,
    Command,
    Group,
    amount,
    count,
    folder_option,
    option,
    scenario,
    scenario_name,
    whole,
)
from soft_gripper.errors import InputError
from soft_gripper.extras.sweeps.commands import CHECK, EXECUTOR, RESUME


def _check_trials(options: argparse.Namespace) -> None:
    """Checks that the names of scenarios differ, since tables distinguish them by name."""
    names = Counter(Path(file).stem for file in options.scenario or ())
    for file in options.scenario or ():
        if names[Path(file).stem] > 1:
            raise InputError("study grasp-trials", "--scenario", file, "give scenarios with different names")


COMMANDS = (
    Command(
        "grasp-strength",
        "load a held object in twelve directions until it is lost",
        (
            "bottle_grasp                                   six forces and six torques: strength.csv, strength.png",
            "pick_and_place_box --out results/box_strength  until the end of the first phase that holds the object",
            "bottle_grasp --set pressure.steps.all.0=80e3 --slid 2",
        ),
        (
            *CONSOLE,
            *scenario(),
            option("--object", "model that is loaded (default: that of the task, or the first free one)", "NAME"),
            amount("--slid", "mm along the fingers by which it may slide", "MM", 1e3, 5.0),
            amount("--turned", "degrees in the fingers by which it may turn", "DEG", 180.0, 20.0),
            amount("--seconds", "in which a force grows to the sum of the normal forces", "S", 1e3, 2.0),
            *(*EXECUTOR, folder_option("results/grasp_strength")),
        ),
        package=__name__,
        group=Group.STUDY,
    ),
    Command(
        "study grasp-trials",
        "pick and place with random poses, masses, frictions and sizes",
        (
            "--trials 200 --seed 1                                        200 trials of every scenario",
            "--scenario pick_and_place_delicate --trials 20 --json",
            "--scenario pick_and_place_box --seed 1 --trial 7             rerun one, with its recording",
            "--trials 1000 --engine mujoco --check 100                    in MuJoCo, a hundred repeated in Drake",
        ),
        (
            *CONSOLE,
            count("--trials", "number of trials of each scenario", 20),
            SEED,
            option(
                "--scenario",
                "scenario; may be repeated (default: the shipped pick_and_place scenarios)",
                "NAME",
                scenario_name,
                action="append",
            ),
            option("--trial", "run this trial only; keep its scenario and recording", "K", whole(0)),
            *(ENGINE, CHECK, RESUME, *EXECUTOR, folder_option("results/grasp_trials")),
        ),
        _check_trials,
        package=__name__,
        group=Group.STUDY,
    ),
)
