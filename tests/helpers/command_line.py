"""The command line, called in process as a user calls it."""

import io
import sys
from collections.abc import Callable
from contextlib import redirect_stderr, redirect_stdout
from dataclasses import dataclass

import pytest

from soft_gripper.commands import main
from soft_gripper.commands.options import Program
from soft_gripper.commands.parser import SOFT_GRIPPER, command_parser, parse_options

# The command line in a process of its own, which hears Ctrl-C and the end of a terminal even where the tests do not: in
# the background of a shell, and under nohup.
LISTENING = [
    sys.executable,
    "-c",
    "import signal, sys; signal.signal(signal.SIGINT, signal.default_int_handler);"
    "signal.signal(signal.SIGHUP, signal.SIG_DFL);"
    "from soft_gripper.commands import main; sys.exit(main())",
]
SHORT = ("pressure.steps.all=[0, 60e3]", "pressure.settle=0.2", "pressure.hold_samples=5")


@dataclass(frozen=True)
class Outcome:
    """What a command leaves in the terminal."""

    code: int
    out: str
    err: str


class Terminal(io.StringIO):
    """Text that says that somebody is looking."""

    def isatty(self) -> bool:
        return True


def soft_gripper(*arguments: object, terminal: bool = False, program: Program = SOFT_GRIPPER) -> Outcome:
    """Runs `soft-gripper ARGUMENTS`, its complaints and its progress going to a file or to a terminal."""
    out, err = io.StringIO(), Terminal() if terminal else io.StringIO()
    with redirect_stdout(out), redirect_stderr(err):
        code = main([str(argument) for argument in arguments], program)
    return Outcome(code, out.getvalue(), err.getvalue())


def help_of(command: str) -> str:
    """What `soft-gripper COMMAND --help` prints."""
    return _ended([*command.split(), "--help"], command_parser().parse_args)[1]


def complaint(line: str) -> str:
    """The one line by which a mistake that argparse finds is answered."""
    code, said = _ended(line.split(), parse_options)
    assert code == 2
    assert said.startswith("soft-gripper: ")
    assert said.count("\n") == 1
    return said


def _ended(arguments: list[str], parse: Callable[[list[str]], object]) -> tuple[object, str]:
    """The exit code and the words with which reading a command line ends a process."""
    words = io.StringIO()
    with redirect_stdout(words), redirect_stderr(words), pytest.raises(SystemExit) as caught:
        parse(arguments)
    return caught.value.code, words.getvalue()


def short(*overrides: str) -> list[str]:
    """Options that shorten a scenario to two steps of a quarter of a second, and override what else is given."""
    return [option for override in (*SHORT, *overrides) for option in ("--set", override)]
