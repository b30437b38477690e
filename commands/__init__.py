"""The command line: `soft-gripper COMMAND`, one file a command."""

import signal
import sys
from collections.abc import Sequence

from soft_gripper.commands.terminal.exit_codes import ExitCode


def main(arguments: Sequence[str] | None = None) -> int:
    """Runs one command, see `dispatch`; while everything is imported, Ctrl-C waits."""
    signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        from soft_gripper.commands.dispatch import dispatch

        signal.pthread_sigmask(signal.SIG_UNBLOCK, {signal.SIGINT})
        signal.signal(signal.SIGTERM, _end)
        return dispatch(arguments)
    except KeyboardInterrupt:
        print("soft-gripper: interrupted; what has been written is whole", file=sys.stderr)
        return ExitCode.INTERRUPTED


def _end(number: int, frame: object) -> None:
    """Ends the process as one that was killed, but not before it has removed what it is halfway through writing."""
    raise SystemExit(128 + number)
