"""soft-gripper list: the shipped scenarios."""

import argparse

from soft_gripper.commands.terminal.console import add_console_options
from soft_gripper.commands.terminal.options import Subparsers, add_command
from soft_gripper.scenario.scenario_file import load_scenario, scenario_names


def add_parser(subparsers: Subparsers) -> None:
    """Declares the command."""
    parser = add_command(subparsers, "list", "list the shipped scenarios", "--json")
    add_console_options(parser)
    parser.set_defaults(command=_run)


def _run(options: argparse.Namespace) -> None:
    descriptions = {name: load_scenario(name).description for name in scenario_names()}
    width = max(map(len, descriptions))
    for name, description in descriptions.items():
        print(f"{name:<{width}}  {description}")
    options.console.document["scenarios"] = descriptions
