"""Meshcat for a viewer who watches a run, and then its animation; and cleanup after one has failed."""

import os
import socket
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from stat import S_ISSOCK
from urllib.parse import urlsplit

from pydrake.geometry import Meshcat

from soft_gripper.extras.page.page_server import page_server

_MAX_DESCRIPTORS = 4096
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


def has_failed(meshcat: Meshcat) -> bool:
    """Whether the thread that serves a Meshcat has ended."""
    try:
        meshcat.web_url()  # unlike other calls, this does not wait for the thread
    except RuntimeError:
        return True
    return False


def cut_off(address: str) -> None:
    """Closes the connections of a failed Meshcat at an address, so that its destructor does not wait for clients."""
    port = urlsplit(address).port
    for descriptor in range(3, _MAX_DESCRIPTORS):
        with suppress(OSError):
            if not S_ISSOCK(os.fstat(descriptor).st_mode):
                continue  # a copy of it could not become a socket, and would stay open
            with socket.socket(fileno=os.dup(descriptor)) as copy:
                if copy.getsockname()[1:2] == (port,):
                    copy.shutdown(socket.SHUT_RDWR)
