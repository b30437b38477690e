"""One process at a time writes the results in a folder."""

import fcntl
import os
from pathlib import Path

from soft_gripper.errors import InputError
from soft_gripper.files import writable_folder

_claims: dict[str, int] = {}  # folders of this process, and the open files that hold their locks


def claim_folder(path: Path) -> Path:
    """Makes a folder, and keeps other processes from writing to it until `release_folders` or the end of this process.

    Raises:
        InputError: if it cannot be written to, or another process has claimed it.
    """
    folder = writable_folder(path)
    name = os.path.realpath(folder)
    if name not in _claims:
        lock = os.open(name, os.O_RDONLY)
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            os.close(lock)
            expected = "another soft-gripper writes there; wait for it, or give another folder"
            raise InputError("output", "folder", str(folder), expected) from None
        except OSError:
            pass  # a file system without locks
        _claims[name] = lock
    return folder


def release_folders() -> None:
    """Lets others write to what this process has claimed."""
    while _claims:
        os.close(_claims.popitem()[1])
