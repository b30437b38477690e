"""Options that several commands share."""

import argparse
from concurrent.futures import Executor
from contextlib import AbstractContextManager

from soft_gripper.commands.terminal.numbers import whole_number
from soft_gripper.diagrams.schema.scenario import Scenario
from soft_gripper.diagrams.schema.scenario_file import load_scenario
from soft_gripper.diagrams.station import make_station
from soft_gripper.diagrams.station_parts import Station
from soft_gripper.errors import InputError
from soft_gripper.evaluation.executor.executor import open_executor


def add_scenario_options(parser: argparse.ArgumentParser) -> None:
    """The scenario, and what of it is changed on the command line."""
    parser.add_argument("scenario", help="a shipped scenario (see `soft-gripper list`) or a YAML file")
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
    """The station of that scenario; mistakes that show when it is built name the scenario too."""
    scenario = chosen_scenario(options)
    try:
        station = make_station(scenario)
    except InputError as error:
        raise error.inside(options.scenario) from None
    if not station.fingers:
        raise InputError(options.scenario, "models", [m.file for m in scenario.models], "there is no <finger> in them")
    return station


def add_executor_options(parser: argparse.ArgumentParser) -> None:
    """Where simulations run that are many."""
    parser.add_argument("--jobs", metavar="N", help="processes (default: one a core)")
    address = "Dask scheduler, such as tcp://127.0.0.1:8786, whose workers are used instead; see docs/cluster.md"
    parser.add_argument("--scheduler", metavar="URL", help=address)


def chosen_executor(command: str, options: argparse.Namespace) -> AbstractContextManager[Executor]:
    """The executor that the options of `add_executor_options` name."""
    jobs = whole_number(command, "--jobs", options.jobs, 1) if options.jobs is not None else None
    return open_executor(jobs, options.scheduler)
