"""The command line, called in process as a user calls it."""

import io
import sys
from contextlib import redirect_stderr, redirect_stdout
from dataclasses import dataclass

from soft_gripper.commands import main

# The command line in a process of its own, which hears Ctrl-C even where the tests run in the background and do not.
LISTENING = [
    sys.executable,
    "-c",
    "import signal, sys; signal.signal(signal.SIGINT, signal.default_int_handler);"
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


def soft_gripper(*arguments: object, terminal: bool = False) -> Outcome:
    """Runs `soft-gripper ARGUMENTS`, its complaints and its progress going to a file or to a terminal."""
    out, err = io.StringIO(), Terminal() if terminal else io.StringIO()
    with redirect_stdout(out), redirect_stderr(err):
        code = main([str(argument) for argument in arguments])
    return Outcome(code, out.getvalue(), err.getvalue())


def short(*overrides: str) -> list[str]:
    """Options that shorten a scenario to two steps of a quarter of a second, and override what else is given."""
    return [option for override in (*SHORT, *overrides) for option in ("--set", override)]
