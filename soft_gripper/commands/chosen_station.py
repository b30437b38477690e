"""The station of the scenario that a command is given."""

import argparse
import sys

from pydrake.geometry import Meshcat

from soft_gripper.diagrams.station import make_private_station, make_station
from soft_gripper.diagrams.station_parts import Station
from soft_gripper.errors import InputError
from soft_gripper.scenario.schema import Scenario

_MANY_MODELS = 30  # models; Drake reads a few per second


def chosen_station(options: argparse.Namespace) -> Station:
    """The station of the scenario in the options, to be run."""
    return station_of(options.scenario, options.chosen_scenario, is_private=True)


def station_of(name: str, scenario: Scenario, meshcat: Meshcat | None = None, *, is_private: bool = False) -> Station:
    """Builds the station of a scenario, or a private one; errors raised while building also name the scenario."""
    if len(scenario.models) > _MANY_MODELS:
        print(f"note: reading {len(scenario.models)} models, which may take minutes", file=sys.stderr, flush=True)
    try:
        station = (make_private_station if is_private else make_station)(scenario, meshcat)
    except InputError as error:
        raise error.inside(name) from error.__cause__
    if not station.fingers:
        raise InputError(name, "models", [m.file for m in scenario.models], "there is no <finger> in them")
    return station
