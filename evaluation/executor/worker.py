"""What a worker process does: it makes calls, one after the other, and ends when its parent has gone."""

import logging
import os
import resource
import shutil
import sys
import tempfile
from collections.abc import Callable
from multiprocessing.connection import Connection
from threading import Thread
from typing import Any, NamedTuple

from soft_gripper.diagrams.notes import notes

_UNIT = 1 if sys.platform == "darwin" else 1024  # bytes, of what the system reports


class Made(NamedTuple):
    """A call that was made."""

    result: Any
    memory: int  # bytes that the process has had resident at most


def begin(line: Connection, folder: str) -> None:
    """Readies a worker process.

    Args:
        line: from the parent, on which nothing ever comes; when the parent closes it, or has died, the process ends.
        folder: for temporary files.
    """
    tempfile.tempdir = folder
    logging.getLogger("drake").setLevel(logging.WARNING)  # nobody is to open these Meshcats
    Thread(target=_end_with, args=(line, folder), daemon=True).start()


def _end_with(line: Connection, folder: str) -> None:
    line.poll(None)  # until the other end is closed
    shutil.rmtree(folder, ignore_errors=True)
    os._exit(1)


def make(work: Callable[..., Any], arguments: tuple[Any, ...]) -> Made:
    """Makes a call; what libraries complain of in it are notes, as they are in the parent."""
    with notes():
        result = work(*arguments)
    return Made(result, _UNIT * resource.getrusage(resource.RUSAGE_SELF).ru_maxrss)
