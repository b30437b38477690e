"""The command line: `soft-gripper COMMAND`, declared in `parser`; each command runs in a module of its name."""

import os
import signal
import sys
from collections.abc import Sequence

from soft_gripper.commands.dispatch import dispatch
from soft_gripper.commands.parser import ExitCode


def main(arguments: Sequence[str] | None = None) -> int:
    """Runs one command, see `dispatch`."""
    _replace_closed_streams()
    os.environ["MPLBACKEND"] = "agg"  # figures go to files alone, and matplotlib refuses names that it does not know
    for number in (signal.SIGTERM, signal.SIGHUP):
        if signal.getsignal(number) != signal.SIG_IGN:  # as below nohup
            signal.signal(number, _end)
    try:
        return dispatch(arguments)
    except KeyboardInterrupt:
        print("soft-gripper: interrupted; all files already written are complete", file=sys.stderr)
        return ExitCode.INTERRUPTED


def _replace_closed_streams() -> None:
    """Opens standard streams that are closed, or the next file would be one of them and get what is printed.

    What is printed to standard output is then reported as an error; what goes to standard error is lost.
    """
    for number, (name, flags, mode) in enumerate(
        (("stdin", os.O_RDONLY, "r"), ("stdout", os.O_RDONLY, "w"), ("stderr", os.O_WRONLY, "w"))
    ):
        if getattr(sys, name) is None:
            os.dup2(os.open(os.devnull, flags), number)
            os.set_inheritable(number, True)
            setattr(sys, name, os.fdopen(number, mode, closefd=False))


def _end(number: int, frame: object) -> None:
    """Ends the process as one that was killed, but not before it has removed what it is halfway through writing."""
    if number == signal.SIGHUP:  # the kernel and the shell both send one when a terminal is closed
        signal.signal(number, signal.SIG_IGN)
    raise SystemExit(128 + number)
