"""The command line: `soft-gripper COMMAND`, declared in `parser`; each command runs in a module of its name."""

import os
import signal
import sys
from collections.abc import Sequence
from typing import TYPE_CHECKING

from soft_gripper.interrupts import waiting

if TYPE_CHECKING:
    from soft_gripper.commands.options import Program


def main(arguments: Sequence[str] | None = None, program: "Program | None" = None) -> int:
    """Runs one command, see `dispatch`, which is imported here, where Ctrl-C ends in one line."""
    try:
        _replace_closed_streams()
        os.environ["MPLBACKEND"] = "agg"  # figures only go to files, and matplotlib rejects unknown backend names
        with waiting():
            from soft_gripper.commands.dispatch import dispatch
        for signal_number in (signal.SIGTERM, signal.SIGHUP):
            if signal.getsignal(signal_number) != signal.SIG_IGN:  # ignored under nohup
                signal.signal(signal_number, _end)
        return dispatch(arguments, *([program] if program else []))
    except KeyboardInterrupt:
        name = program.name if program else "soft-gripper"
        print(f"{name}: interrupted; all files already written are complete", file=sys.stderr)
        return 128 + signal.SIGINT


def _replace_closed_streams() -> None:
    """Reopens closed standard streams; otherwise, the next file opened would take their place and receive the output.

    Printing to standard output is then reported as an error; text for standard error is lost.
    """
    for descriptor, (name, flags, mode) in enumerate(
        (("stdin", os.O_RDONLY, "r"), ("stdout", os.O_RDONLY, "w"), ("stderr", os.O_WRONLY, "w"))
    ):
        if getattr(sys, name) is None:
            os.dup2(os.open(os.devnull, flags), descriptor)
            os.set_inheritable(descriptor, True)
            setattr(sys, name, os.fdopen(descriptor, mode, closefd=False))


def _end(number: int, frame: object) -> None:
    """Exits with the code of a killed process, after removing any half-written files."""
    if number == signal.SIGHUP:  # both the kernel and the shell send one when a terminal closes
        signal.signal(number, signal.SIG_IGN)
    raise SystemExit(128 + number)
