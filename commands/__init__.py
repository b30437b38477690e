"""The command line: `soft-gripper COMMAND`, one file a command."""

import signal
import sys
from collections.abc import Sequence


def main(arguments: Sequence[str] | None = None) -> int:
    """Runs one command, see `dispatch`; while everything is imported, Ctrl-C waits."""
    signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        from soft_gripper.commands.dispatch import dispatch

        signal.pthread_sigmask(signal.SIG_UNBLOCK, {signal.SIGINT})
        return dispatch(arguments)
    except KeyboardInterrupt:
        print("soft-gripper: interrupted; what has been written is whole", file=sys.stderr)
        return 130
