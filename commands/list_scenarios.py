"""soft-gripper list: the shipped scenarios."""

import argparse

from soft_gripper.commands.terminal.subparsers import Subparsers
from soft_gripper.diagrams.schema.scenario_file import load_scenario, scenario_names


def add_parser(subparsers: Subparsers) -> None:
    """Declares the command."""
    parser = subparsers.add_parser("list", help="list the shipped scenarios")
    parser.set_defaults(command=_run)


def _run(options: argparse.Namespace) -> None:
    names = scenario_names()
    width = max(map(len, names))
    for name in names:
        print(f"{name:<{width}}  {load_scenario(name).description}")
