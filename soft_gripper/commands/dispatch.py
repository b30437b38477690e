"""Runs a command: parses its options, imports its module, and turns an error into one line and an exit code."""

import argparse
import io
import os
import sys
import traceback
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from importlib import import_module
from types import ModuleType

from soft_gripper.commands.console import Console
from soft_gripper.commands.options import Command, ExitCode, Program
from soft_gripper.commands.parser import SOFT_GRIPPER, parse_options
from soft_gripper.errors import InputError, SimulationDivergedError, WorkerDiedError, first_line, single_line
from soft_gripper.files.output import release_folders
from soft_gripper.interrupts import waiting
from soft_gripper.library_messages import printed_as_notes


def dispatch(arguments: Sequence[str] | None = None, program: Program = SOFT_GRIPPER) -> ExitCode:
    """Runs one command."""
    if isinstance(sys.stdout, io.TextIOWrapper):
        sys.stdout.reconfigure(errors="backslashreplace")  # for characters that the terminal cannot show
    options = argparse.Namespace()
    try:
        with waiting():
            options = _parse_arguments(arguments, program)
        options.console = Console(getattr(options, "quiet", False), getattr(options, "json", False))
        with printed_as_notes():
            with options.console.speaking():
                code = ExitCode(_run(options) or ExitCode.DONE)
            sys.stdout.flush()
        return code
    except (InputError, SimulationDivergedError, WorkerDiedError) as error:
        return _complain(program, f"{error}{_traceback(error, options)}")
    except BrokenPipeError:
        _leave_output()
        return ExitCode.BROKEN_PIPE
    except OSError as error:
        _leave_output()
        return _complain(program, f"{error.filename or 'output'}: {error.strerror or error}")
    except MemoryError:
        return _complain(program, "out of memory")
    except SystemExit as error:  # a failed condition in Drake, the end of --help, or an exit by a library
        if not isinstance(error.code, str):
            raise
        return _complain(program, f"Drake cannot go on: {first_line(error)}")
    finally:
        release_folders()


def _parse_arguments(arguments: Sequence[str] | None, program: Program) -> argparse.Namespace:
    for word in sys.argv[1:] if arguments is None else arguments:
        if not _is_text(word):
            raise InputError("command line", "argument", word, "is not UTF-8: give files names that are")
    try:
        return parse_options(arguments, program)
    except SystemExit:  # after --help, whose reader may have closed the pipe early
        sys.stdout.flush()
        raise


def _is_text(word: str) -> bool:
    """Whether tables and messages can hold a word of the command line: names of files may be any bytes."""
    try:
        word.encode()
    except UnicodeEncodeError:
        return False
    return True


@contextmanager
def _leave_current_folder() -> Iterator[None]:
    """Leaves the current folder within the block: matplotlib would obey a `matplotlibrc` there when it is imported."""
    try:
        descriptor = os.open(".", getattr(os, "O_PATH", os.O_RDONLY))  # the path may be gone
    except OSError:  # the folder may not be searched, so nothing in it is read
        yield
        return
    os.chdir("/")
    try:
        yield
    finally:
        os.fchdir(descriptor)
        os.close(descriptor)


def _run(options: argparse.Namespace) -> int | None:
    """Runs a command; its module is imported after its scenario is checked, so that a mistake is answered at once."""
    takes_scenario = vars(options).keys() >= {"scenario", "sections", "set"}
    if takes_scenario and not hasattr(options, "vary"):  # a sweep checks scenarios with what it varies
        scenario_module = _load_module(options.command, "soft_gripper.commands.chosen_scenario")
        options.chosen_scenario = scenario_module.chosen_scenario(options)
    return _load_module(options.command, options.command.module).run(options)


def _load_module(command: Command, module: str) -> ModuleType:
    """Imports a module that a command needs."""
    try:
        with waiting(), _leave_current_folder():
            return import_module(module)
    except ImportError as error:
        expected = f"cannot be loaded (out of memory?): {first_line(error)}"
        raise InputError(command.name, "module", module, expected) from None


def _traceback(error: Exception, options: argparse.Namespace) -> str:
    """Traceback of user code that failed, or a hint on how to show it."""
    if not isinstance(error, InputError) or error.__cause__ is None or not hasattr(options, "traceback"):
        return ""
    if not options.traceback:
        return " (--traceback shows where)"
    traceback.print_exception(error.__cause__)
    return ""


def _complain(program: Program, text: str) -> ExitCode:
    with suppress(OSError):  # the exit code reports it too
        print(f"{program.name}: {single_line(text)}", file=sys.stderr)
    return ExitCode.REFUSED


def _leave_output() -> None:
    """Lets Python exit without another attempt to write to a closed pipe."""
    with suppress(OSError, ValueError, AttributeError):
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
