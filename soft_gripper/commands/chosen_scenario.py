"""The scenario given by the options of a command, loaded before what runs it is imported."""

import argparse

from soft_gripper.scenario.scenario_file import load_scenario
from soft_gripper.scenario.schema import Scenario


def chosen_scenario(options: argparse.Namespace) -> Scenario:
    """Loads the scenario with all overrides applied."""
    values = {"sensor.sections": options.sections, "engine": getattr(options, "engine", None)}
    overrides = [f"{key}={value}" for key, value in values.items() if value is not None]
    return load_scenario(options.scenario, [*options.set, *overrides])
