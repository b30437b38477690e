"""soft-gripper: the commands, and what becomes of a mistake."""

import argparse
import io
import os
import sys
from collections.abc import Sequence
from contextlib import suppress
from importlib.metadata import version
from typing import NoReturn

from soft_gripper.commands import (
    contact_trials,
    evaluate,
    expand,
    grasp_trials,
    list_scenarios,
    place_sensors,
    play,
    recognition,
    run,
    show,
    sweep,
    tune,
)
from soft_gripper.commands.hardware import calibrate, hardware, identify, replay
from soft_gripper.diagrams.notes import notes
from soft_gripper.errors import (
    InputError,
    SimulationDivergedError,
    WorkerDiedError,
    first_line,
    in_one_line,
    shortened,
)
from soft_gripper.folder_claims import release_folders

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
)


def dispatch(arguments: Sequence[str] | None = None) -> int:
    """Runs one command.

    Returns:
        the exit code: 0; 1 if a task or a claim failed; 2 for a mistake in the input, or a file that cannot be
        written; 141, as a shell has it, if who read the output is gone. (130 is for Ctrl-C, see `main`.)
    """
    if isinstance(sys.stdout, io.TextIOWrapper):
        sys.stdout.reconfigure(errors="backslashreplace")  # what a terminal cannot show
    parser = _Parser(prog="soft-gripper", description="Soft, sensing grippers simulated in Drake.")
    parser.add_argument("--version", action="version", version=f"soft-gripper {version('soft-gripper')}")
    subparsers = parser.add_subparsers(required=True, metavar="COMMAND")
    for command in COMMANDS:
        command.add_parser(subparsers)
    options = parser.parse_args(arguments)
    try:
        with notes():
            code = int(options.command(options) or 0)
            sys.stdout.flush()
            return code
    except (InputError, SimulationDivergedError, WorkerDiedError) as error:
        return _complain(str(error))
    except BrokenPipeError:
        _leave_output()
        return 141
    except OSError as error:
        _leave_output()
        return _complain(f"{error.filename or 'output'}: {error.strerror or error}")
    except MemoryError:
        return _complain("the memory is not enough for what is asked")
    except SystemExit as error:  # one of Drake's conditions that failed, or the way out of a library
        if not isinstance(error.code, str):
            raise
        return _complain(f"Drake cannot go on: {first_line(error)}")
    finally:
        release_folders()


class _Parser(argparse.ArgumentParser):
    """Its complaints repeat no more of what was written than others do."""

    def error(self, message: str) -> NoReturn:
        super().error(in_one_line(shortened(message)))


def _complain(text: str) -> int:
    print(f"soft-gripper: {in_one_line(text)}", file=sys.stderr)
    return 2


def _leave_output() -> None:
    """Lets Python end without another try to write what nobody can take."""
    with suppress(OSError, ValueError, AttributeError):
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
