"""soft-gripper: the commands, and what becomes of a mistake."""

import argparse
import sys
from collections.abc import Sequence

from soft_gripper.commands import evaluate, expand, grasp_trials, list_scenarios, run, show, tune
from soft_gripper.errors import InputError, SimulationDivergedError

COMMANDS = (run, evaluate, grasp_trials, tune, list_scenarios, show, expand)


def main(arguments: Sequence[str] | None = None) -> int:
    """Runs one command; the exit code is 0, 2 for a mistake in the input, or 130 when interrupted."""
    parser = argparse.ArgumentParser(prog="soft-gripper", description="Soft, sensing grippers simulated in Drake.")
    subparsers = parser.add_subparsers(required=True, metavar="COMMAND")
    for command in COMMANDS:
        command.add_parser(subparsers)
    options = parser.parse_args(arguments)
    try:
        options.command(options)
    except (InputError, SimulationDivergedError) as error:
        print(f"soft-gripper: {error}", file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        print("soft-gripper: interrupted; files already written are whole", file=sys.stderr)
        return 130
    return 0
