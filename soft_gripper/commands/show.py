"""soft-gripper show: prints a scenario with all its fields, and draws its block diagram."""

import argparse

from soft_gripper.commands.chosen_station import station_of
from soft_gripper.diagrams.view.block_diagram import save_block_diagram
from soft_gripper.scenario.scenario_file import dump_scenario


def run(options: argparse.Namespace) -> None:
    """Runs the command."""
    scenario = options.chosen_scenario
    station = station_of(options.scenario, scenario)
    if options.graphviz is not None:
        save_block_diagram(station.diagram, options.graphviz)
    print(dump_scenario(scenario), end="")
