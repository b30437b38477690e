"""A Meshcat of this machine's own, and what is left to do where one has failed.

A Meshcat takes commands and junk from whoever can connect: it checks neither Host nor Origin, and one message that is
not MessagePack ends its thread. Every later call then raises a RuntimeError, and its destructor waits until the last
client has gone of itself.
"""

import os
import secrets
import socket
from contextlib import suppress
from ipaddress import IPv4Address
from urllib.parse import urlsplit

from pydrake.geometry import Meshcat, MeshcatParams

from soft_gripper.errors import InputError, first_line

LOOPBACK = "127.0.0.1"
_MOST_DESCRIPTORS = 4096


def open_meshcat() -> Meshcat:
    """A Meshcat at the first of its ports that is free, for this machine alone.

    Raises:
        InputError: if there is none.
    """
    try:
        return Meshcat(MeshcatParams(host=LOOPBACK))
    except RuntimeError as error:
        expected = f"none is free at {LOOPBACK}; end other viewers ({first_line(error)})"
        raise InputError("Meshcat", "port", "7000 to 7099", expected) from None


def hidden_meshcat() -> Meshcat:
    """A Meshcat where no other program expects it: at an arbitrary address of the loopback, and an arbitrary port.

    No page of a browser can guess both, of some 2^38. Where the loopback has a single address, as on macOS, the port
    alone is arbitrary.

    Raises:
        InputError: if none is free.
    """
    address = IPv4Address("127.0.0.2") + secrets.randbelow(2**24 - 4)
    for host in (str(address), LOOPBACK):
        with suppress(RuntimeError):
            return Meshcat(MeshcatParams(host=host, port=0, show_stats_plot=False))
    raise InputError("Meshcat", "port", "any", f"none is free at {LOOPBACK}")


def has_failed(meshcat: Meshcat) -> bool:
    """Whether the thread that serves a Meshcat has ended."""
    try:
        meshcat.web_url()  # which, unlike others, does not wait for the thread
    except RuntimeError:
        return True
    return False


def cut_off(address: str) -> None:
    """Ends the connections of the Meshcat at an address, which has failed, lest its destructor wait for its clients."""
    port = urlsplit(address).port
    for descriptor in range(3, _MOST_DESCRIPTORS):
        with suppress(OSError), socket.socket(fileno=os.dup(descriptor)) as copy:
            if copy.getsockname()[1:2] == (port,):
                copy.shutdown(socket.SHUT_RDWR)
