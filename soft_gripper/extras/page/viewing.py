"""Meshcat for a viewer who watches a run, and then its animation."""

import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress

from pydrake.geometry import Meshcat

from soft_gripper.extras.page.page_server import page_server

_END_PROMPT = "The animation is in Meshcat. Press Enter to end. "
_NO_TERMINAL_NOTE = "There is no terminal to wait at, so Meshcat closes now; use --html FILE to keep the animation."


@contextmanager
def show_meshcat(meshcat: Meshcat, host: str) -> Iterator[None]:
    """Shows a Meshcat while the block runs, and then until Enter is pressed at the terminal.

    Raises:
        InputError: if the host is not an address of this machine.
    """
    address = meshcat.web_url()
    with page_server(host, lambda: address) as page:
        print(f"Open {page} in a browser.", file=sys.stderr, flush=True)
        yield
        wait_for_viewer()


def wait_for_viewer() -> None:
    """Waits for Enter if there is a terminal."""
    if sys.stdin is None or sys.stdin.closed or not sys.stdin.isatty():
        print(_NO_TERMINAL_NOTE)
        return
    with suppress(EOFError):
        input(_END_PROMPT)
