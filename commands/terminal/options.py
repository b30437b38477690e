"""Options that several commands share."""

import argparse
import sys

from pydrake.geometry import Meshcat

from soft_gripper.diagrams.schema.scenario import Scenario
from soft_gripper.diagrams.schema.scenario_file import load_scenario
from soft_gripper.diagrams.station import make_station
from soft_gripper.diagrams.station_parts import Station
from soft_gripper.errors import InputError

_MANY = 30  # models, of which Drake reads a few a second


def add_scenario_options(parser: argparse.ArgumentParser, default: str | None = None) -> None:
    """The scenario, or one that is the default, and what of it is changed on the command line."""
    described = "a shipped scenario (see `soft-gripper list`) or a YAML file"
    if default is None:
        parser.add_argument("scenario", help=described)
    else:
        parser.add_argument("scenario", nargs="?", default=default, help=f"{described}; default: {default}")
    parser.add_argument("--sections", metavar="N", help="sensors along each path of a finger")
    parser.add_argument(
        "--set",
        metavar="KEY=VALUE",
        action="append",
        default=[],
        help="change a field, such as pressure.settle=2 or models.3.mesh.mass=0.1; may be repeated",
    )


def chosen_scenario(options: argparse.Namespace) -> Scenario:
    """The scenario that the options of `add_scenario_options` name."""
    sections = [f"sensor.sections={options.sections}"] if options.sections is not None else []
    return load_scenario(options.scenario, [*options.set, *sections])


def chosen_station(options: argparse.Namespace) -> Station:
    """The station of that scenario."""
    return station_of(options.scenario, chosen_scenario(options))


def station_of(name: str, scenario: Scenario, meshcat: Meshcat | None = None) -> Station:
    """The station of a scenario; mistakes that show when it is built name the scenario too."""
    if len(scenario.models) > _MANY:
        print(f"note: reading {len(scenario.models)} models, which may take minutes", file=sys.stderr, flush=True)
    try:
        station = make_station(scenario, meshcat)
    except InputError as error:
        raise error.inside(name) from error.__cause__
    if not station.fingers:
        raise InputError(name, "models", [m.file for m in scenario.models], "there is no <finger> in them")
    return station
