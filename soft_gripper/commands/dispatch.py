"""soft-gripper: the commands, and what becomes of a mistake."""

import argparse
import io
import os
import sys
import traceback
from collections.abc import Sequence
from contextlib import suppress
from importlib.metadata import version
from typing import NoReturn

from soft_gripper.commands import (
    contact_trials,
    evaluate,
    grasp_trials,
    place_sensors,
    play,
    recognition,
    run,
    sweep,
    tune,
)
from soft_gripper.commands.hardware import calibrate, hardware, identify, replay
from soft_gripper.commands.inspect import doctor, expand, list_scenarios, show
from soft_gripper.commands.terminal.completion import add_completion
from soft_gripper.commands.terminal.console import Console
from soft_gripper.commands.terminal.exit_codes import ExitCode
from soft_gripper.commands.terminal.options import PROGRAM
from soft_gripper.diagrams.notes import notes
from soft_gripper.errors import (
    InputError,
    SimulationDivergedError,
    WorkerDiedError,
    first_line,
    in_one_line,
    shortened,
)
from soft_gripper.files.output import release_folders

COMMANDS = (
    run,
    play,
    evaluate,
    sweep,
    grasp_trials,
    recognition,
    contact_trials,
    place_sensors,
    tune,
    calibrate,
    identify,
    replay,
    hardware,
    list_scenarios,
    show,
    expand,
    doctor,
)


def command_parser() -> argparse.ArgumentParser:
    """All commands with their options."""
    codes = ", ".join(f"{code.value} {code.name.lower().replace('_', ' ')}" for code in ExitCode)
    parser = _Parser(
        prog=PROGRAM,
        description="Soft, sensing grippers simulated in Drake.",
        epilog=f"`{PROGRAM} COMMAND --help` has examples. Exit codes: {codes}.",
    )
    parser.add_argument("--version", action="version", version=f"{PROGRAM} {version(PROGRAM)}")
    subparsers = parser.add_subparsers(required=True, metavar="COMMAND", parser_class=_Parser)
    for command in COMMANDS:
        command.add_parser(subparsers)
    add_completion(parser, subparsers.choices)
    return parser


def dispatch(arguments: Sequence[str] | None = None) -> ExitCode:
    """Runs one command."""
    if isinstance(sys.stdout, io.TextIOWrapper):
        sys.stdout.reconfigure(errors="backslashreplace")  # what a terminal cannot show
    try:
        options = _parsed(arguments)
        options.console = Console(getattr(options, "quiet", False), getattr(options, "json", False))
        with notes():
            with options.console.speaking():
                code = ExitCode(options.command(options) or ExitCode.DONE)
            sys.stdout.flush()
        return code
    except (InputError, SimulationDivergedError, WorkerDiedError) as error:
        return _complain(f"{error}{_traceback(error, options)}")
    except BrokenPipeError:
        _leave_output()
        return ExitCode.READER_GONE
    except OSError as error:
        _leave_output()
        return _complain(f"{error.filename or 'output'}: {error.strerror or error}")
    except MemoryError:
        return _complain("out of memory")
    except SystemExit as error:  # one of Drake's conditions that failed, or the way out of a library
        if not isinstance(error.code, str):
            raise
        return _complain(f"Drake cannot go on: {first_line(error)}")
    finally:
        release_folders()


def _parsed(arguments: Sequence[str] | None) -> argparse.Namespace:
    try:
        return command_parser().parse_args(arguments)
    except SystemExit:  # after --help, whose text may be more than its reader takes
        sys.stdout.flush()
        raise


class _Parser(argparse.ArgumentParser):
    """Its complaints repeat no more of what was written than others do."""

    def error(self, message: str) -> NoReturn:
        super().error(in_one_line(shortened(message)))


def _traceback(error: Exception, options: argparse.Namespace) -> str:
    """Prints where a user's own code failed, or says how to see it."""
    if not isinstance(error, InputError) or error.__cause__ is None or not hasattr(options, "traceback"):
        return ""
    if not options.traceback:
        return " (--traceback shows where)"
    traceback.print_exception(error.__cause__)
    return ""


def _complain(text: str) -> ExitCode:
    with suppress(OSError):  # the code says it too
        print(f"{PROGRAM}: {in_one_line(text)}", file=sys.stderr)
    return ExitCode.REFUSED


def _leave_output() -> None:
    """Lets Python end without another try to write what nobody can take."""
    with suppress(OSError, ValueError, AttributeError):
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
