"""Declarations of commands and their options; this module imports neither Drake nor numpy."""

import argparse
import os
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass
from enum import IntEnum, StrEnum
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from soft_gripper.files.number import number as decimal
from soft_gripper.registry import registered
from soft_gripper.scenario.shipped import scenario_path

PROGRAM = "soft-gripper"
LOOPBACK = "127.0.0.1"


class ExitCode(IntEnum):
    """The exit codes of all commands."""

    DONE = 0
    FAILED = 1  # a task or a claim failed
    REFUSED = 2  # invalid input, or a file that cannot be written
    INTERRUPTED = 130  # Ctrl-C
    BROKEN_PIPE = 141  # the reader of the output has exited; the code that shells report


Read = Callable[[str], Any]  # text -> value; raises a ValueError that says what is expected


@dataclass(frozen=True)
class Option:
    """An option, with all its names, or a positional argument.

    settings: keyword arguments of `argparse.ArgumentParser.add_argument`.
    """

    names: list[str]
    read: Read | None
    settings: dict[str, Any]


def option(names: str, help_: str, metavar: str | None = None, read: Read | None = None, **settings: Any) -> Option:
    """An option with a value, or a positional argument."""
    return Option(names.split(), read, {"help": help_, "metavar": metavar, **settings})


def flag(names: str, help_: str, **settings: Any) -> Option:
    """Option without a value."""
    return Option(names.split(), None, {"help": help_, "action": "store_true", **settings})


def whole(least: int, most: int = 10_000) -> Callable[[str], int]:
    """Reads a whole number within limits; the default upper limit is the most that anyone would wait for."""

    def read_number(text: str) -> int:
        number = int(text) if text.isascii() and text.isdecimal() and len(text) <= 10 else None
        if number is None or not least <= number <= most:
            raise ValueError(f"give a whole number from {least} to {most}")
        return number

    return read_number


def number(most: float, is_most_allowed: bool = True) -> Callable[[str], float]:
    """Reads a number from 0 to `most`."""

    def read_number(text: str) -> float:
        with suppress(ValueError):
            if 0 <= (value := decimal(text)) < most or (is_most_allowed and value == most):
                return value
        raise ValueError(f"give a number from 0 to {'' if is_most_allowed else 'below '}{most:g}")

    return read_number


def path(text: str) -> Path:
    """Reads a path; ~ is the user's home folder, even if no shell has expanded it."""
    if not text or "\0" in text:
        raise ValueError("give a path")
    try:
        return Path(text).expanduser()
    except RuntimeError as error:
        raise ValueError(str(error)) from None


def mcap_path(text: str) -> Path:
    """Reads a path that ends in .mcap."""
    if not text.endswith(".mcap"):
        raise ValueError("give a name that ends in .mcap")
    if ".mcap" not in registered("RECORDINGS"):
        raise ValueError("nothing here writes MCAP files; a recording is recording.nc")
    if find_spec("mcap") is None:  # found out before a run, not after it
        raise ValueError("MCAP files require mcap: pip install 'soft-gripper[ros]'")
    return path(text)


def scenario_name(text: str) -> str:
    """Reads the name of a shipped scenario, or the path of a file."""
    if not os.path.exists(scenario_path(text)):
        raise ValueError("there is no such file")
    return text


def assignment(text: str) -> str:
    """Checks that text has the form KEY=VALUE."""
    if not text.partition("=")[0] or "=" not in text:
        raise ValueError("write key=value, such as sensor.sections=3")
    return text


def urdf(text: str) -> Path:
    """Reads the path of a URDF to write."""
    if not text.endswith(".urdf"):
        raise ValueError("name a .urdf; the table and the figure are named after it")
    return path(text)


CONSOLE = (
    flag("-q --quiet", "print errors only"),
    flag("--json", "print tables and file names as one JSON document instead of text"),
    flag("--traceback", "print the traceback if your own sensor or estimator fails"),
)
SEED = option("--seed", "random seed (default: %(default)s)", "N", whole(0, 2**32 - 1), default=1)
HTML = option("--html", "write a 3-D animation that opens offline", "FILE", path)
HOST = option(
    "--host",
    "address at which the page is served (default: %(default)s, for this machine only; 0.0.0.0: for the network)",
    "ADDRESS",
    default=LOOPBACK,
)
MCAP = option("--mcap", "write an MCAP file, and a layout for Foxglove beside it", "FILE.mcap", mcap_path)


ENGINE = option(
    "--engine", "what simulates: drake, or another engine that is installed (default: that of the scenario)", "NAME"
)
_CHANGES_HELP = "change a field, such as pressure.settle=2 or models.box.mass=0.1; may be repeated"
SET = option("--set", _CHANGES_HELP, "KEY=VALUE", assignment, action="append", default=[])


def scenario(default: str | None = None) -> tuple[Option, ...]:
    """A scenario, with an optional default, and overrides."""
    described = "a shipped scenario (see `soft-gripper list`) or a YAML file"
    optional = {"nargs": "?", "default": default} if default else {}
    return (
        option(
            "scenario", f"{described}; default: {default}" if default else described, None, scenario_name, **optional
        ),
        option("--sections", "sensor sections along each side of a finger", "N", whole(1)),
        SET,
    )


def folder_option(default: str) -> Option:
    """Option of the folder for the results."""
    return option("--out", "folder for the results (default: %(default)s)", "DIR", path, default=Path(default))


def count(name: str, help_: str, default: int, least: int = 1) -> Option:
    """Option of a count with a default."""
    return option(name, f"{help_} (default: %(default)s)", "N", whole(least), default=default)


def amount(name: str, help_: str, metavar: str, most: float, default: float) -> Option:
    """Option of a number from 0 to `most` with a default."""
    return option(name, f"{help_} (default: %(default)s)", metavar, number(most), default=default)


class Group(StrEnum):
    """Tasks under which `--help` lists commands, in this order."""

    START = "simulate and look"
    HARDWARE = "estimate on hardware and from recordings"
    STUDY = "vary, compare and judge"
    DESIGN = "design, tune and export"
    OTHER = "other"


@dataclass(frozen=True)
class Command:
    """A command; the module of the last word of its name has a function `run`, which takes the options.

    name: a word, or "study" and a word: studies are the commands of the command `study`.
    does: what it does, as a phrase for `--help`.
    examples: command lines without the name, each with an optional explanation after two or more spaces.
    check: checks options that depend on each other.
    package: where its module is; or that module itself.
    group: of `--help`.
    """

    name: str
    does: str
    examples: tuple[str, ...]
    options: tuple[Option, ...]
    check: Callable[[argparse.Namespace], None] = lambda options: None
    package: str = "soft_gripper.commands"
    group: str = Group.OTHER

    @property
    def module(self) -> str:
        name = f".{self.name.split()[-1].replace('-', '_')}"
        return self.package if self.package.endswith(name) else f"{self.package}{name}"


@dataclass(frozen=True)
class Program:
    """A program with commands.

    name: as it is called, in usage lines and errors.
    does: what it is, as a sentence for `--help`.
    groups: of its commands, in the order of `--help`.
    commands: gives its commands.
    """

    name: str
    does: str
    groups: tuple[str, ...]
    commands: Callable[[], Sequence[Command]]
