"""soft-gripper show: a scenario with all its fields, and its block diagram."""

import argparse

from soft_gripper.commands.terminal.options import Subparsers, add_command, add_scenario_options, chosen_station, path
from soft_gripper.diagrams.view.block_diagram import save_block_diagram
from soft_gripper.scenario.scenario_file import dump_scenario


def add_parser(subparsers: Subparsers) -> None:
    """Declares the command."""
    parser = add_command(
        subparsers,
        "show",
        "print a resolved scenario, draw its block diagram",
        "box_grasp                            every field with its value, as YAML",
        "box_grasp --graphviz blocks.svg",
    )
    add_scenario_options(parser)
    parser.add_argument(
        "--graphviz", metavar="FILE", type=path, help="write the block diagram (.dot, .svg, .png or .pdf)"
    )
    parser.set_defaults(command=_run)


def _run(options: argparse.Namespace) -> None:
    station = chosen_station(options)
    if options.graphviz is not None:
        save_block_diagram(station.diagram, options.graphviz)
    print(dump_scenario(station.scenario), end="")
