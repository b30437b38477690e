"""soft-gripper: the commands, and what becomes of a mistake."""

import argparse
import sys
from collections.abc import Sequence
from importlib.metadata import version

from soft_gripper.commands import (
    contact_trials,
    evaluate,
    expand,
    grasp_trials,
    list_scenarios,
    place_sensors,
    recognition,
    run,
    show,
    sweep,
    tune,
)
from soft_gripper.commands.hardware import calibrate, hardware, identify, replay
from soft_gripper.errors import InputError, SimulationDivergedError, WorkerDiedError

COMMANDS = (
    run,
    evaluate,
    sweep,
    grasp_trials,
    recognition,
    contact_trials,
    place_sensors,
    tune,
    calibrate,
    identify,
    replay,
    hardware,
    list_scenarios,
    show,
    expand,
)


def dispatch(arguments: Sequence[str] | None = None) -> int:
    """Runs one command; the exit code is 0, 1 if a task or a claim failed, or 2 for a mistake in the input."""
    parser = argparse.ArgumentParser(prog="soft-gripper", description="Soft, sensing grippers simulated in Drake.")
    parser.add_argument("--version", action="version", version=f"soft-gripper {version('soft-gripper')}")
    subparsers = parser.add_subparsers(required=True, metavar="COMMAND")
    for command in COMMANDS:
        command.add_parser(subparsers)
    options = parser.parse_args(arguments)
    try:
        return int(options.command(options) or 0)
    except (InputError, SimulationDivergedError, WorkerDiedError) as error:
        print(f"soft-gripper: {error}", file=sys.stderr)
        return 2
