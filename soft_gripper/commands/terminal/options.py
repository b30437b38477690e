"""Options that several commands share."""

import argparse
import os
import sys
from concurrent.futures import Executor
from contextlib import AbstractContextManager, suppress
from pathlib import Path
from typing import TypeAlias

from pydrake.geometry import Meshcat

from soft_gripper.diagrams.station import make_station
from soft_gripper.diagrams.station_parts import Station
from soft_gripper.errors import InputError
from soft_gripper.runs.executor import open_executor
from soft_gripper.scenario.scenario import Scenario
from soft_gripper.scenario.scenario_file import load_scenario

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


MOST_SEED = 2**32 - 1
_MOST_JOBS = 256
_DIGITS = 10


def whole_number(command: str, option: str, text: str, least: int, most: int = 10_000) -> int:
    """The number that an option gives.

    Raises:
        InputError: unless it is a whole number from `least` to `most`, by default the most that anybody waits for.
    """
    number = int(text) if text.isascii() and text.isdecimal() and len(text) <= _DIGITS else None
    if number is None or not least <= number <= most:
        raise InputError(command, option, text, f"give a whole number of at least {least}, {most} at most")
    return number


def number_from_zero(command: str, option: str, text: str, most: float) -> float:
    """The number that an option gives.

    Raises:
        InputError: unless it is a number from 0 to `most`.
    """
    with suppress(ValueError):
        if 0 <= (number := float(text)) <= most:
            return number
    raise InputError(command, option, text, f"give a number from 0 to {most:g}")


def number_of_jobs(command: str, text: str | None) -> int:
    """The processes that --jobs gives; without it, one a core.

    Raises:
        InputError: unless it is a whole number that a machine may bear.
    """
    return os.cpu_count() or 1 if text is None else whole_number(command, "--jobs", text, 1, _MOST_JOBS)


def path(text: str) -> Path:
    """The path that an option gives, ~ being the user's home even where no shell has put it in.

    Raises:
        ArgumentTypeError: if it is empty, or of no user.
    """
    if not text or "\0" in text:
        raise argparse.ArgumentTypeError("give a path")
    try:
        return Path(text).expanduser()
    except RuntimeError as error:
        raise argparse.ArgumentTypeError(str(error)) from None


def add_out_folder(parser: argparse.ArgumentParser, default: Path) -> None:
    """Declares where a command writes its results."""
    parser.add_argument("--out", metavar="DIR", type=path, default=default, help="default: %(default)s")


def add_executor_options(parser: argparse.ArgumentParser) -> None:
    """Where simulations run that are many."""
    parser.add_argument("--jobs", metavar="N", help="processes (default: one a core)")
    add_scheduler_option(parser)


def add_scheduler_option(parser: argparse.ArgumentParser) -> None:
    """A cluster, in the place of processes."""
    address = "Dask scheduler, such as tcp://127.0.0.1:8786, whose workers are used instead; see docs/cluster.md"
    parser.add_argument("--scheduler", metavar="URL", help=address)


def chosen_executor(command: str, options: argparse.Namespace) -> AbstractContextManager[Executor]:
    """The executor that the options of `add_executor_options` name."""
    return open_executor(number_of_jobs(command, options.jobs), options.scheduler)


Subparsers: TypeAlias = "argparse._SubParsersAction[argparse.ArgumentParser]"
PROGRAM = "soft-gripper"


def add_command(subparsers: Subparsers, name: str, does: str, *examples: str) -> argparse.ArgumentParser:
    """Declares a command.

    Args:
        subparsers: where.
        name: of the command.
        does: what, in half a sentence.
        examples: command lines, and behind two spaces or more what they are for.
    """
    return subparsers.add_parser(
        name,
        help=does,
        description=does[0].upper() + does[1:] + ".",
        epilog="\n".join(["examples:", *(f"  {PROGRAM} {name} {example}".rstrip() for example in examples)]),
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
