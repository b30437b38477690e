"""Waiting for somebody at the terminal."""

import sys
from contextlib import suppress

_ASKS = "The replay is in Meshcat. Press Enter to end. "
_ENDS = "There is no terminal to wait at, and Meshcat closes now; --html FILE keeps the replay."


def wait_for_viewer() -> None:
    """Keeps Meshcat's replay open for as long as someone at a terminal wants."""
    if sys.stdin is None or sys.stdin.closed or not sys.stdin.isatty():
        print(_ENDS)
        return
    with suppress(EOFError):
        input(_ASKS)
