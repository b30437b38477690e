"""soft-gripper show: prints a scenario with all its fields, and draws its block diagram."""

import argparse

from soft_gripper.commands.chosen_station import chosen_station
from soft_gripper.diagrams.view.block_diagram import save_block_diagram
from soft_gripper.scenario.scenario_file import dump_scenario


def run(options: argparse.Namespace) -> None:
    """Runs the command."""
    station = chosen_station(options)
    if options.graphviz is not None:
        save_block_diagram(station.diagram, options.graphviz)
    print(dump_scenario(station.scenario), end="")
