"""Hides files from a process, and from those that it starts: by Landlock, of Linux 5.13 and later."""

import ctypes
import os
import struct
import sys
from collections.abc import Collection, Iterator
from contextlib import suppress
from pathlib import Path

# As in linux/landlock.h and linux/prctl.h.
_CREATE_RULESET, _ADD_RULE, _RESTRICT_SELF = 444, 445, 446  # system calls
_FILE_ACCESS = 1 << 1 | 1 << 2  # to write and to read
_PATH_BENEATH, _NO_NEW_PRIVILEGES = 1, 38


def hide(paths: Collection[Path]) -> bool:
    """Bars this thread and its children for good from reading or writing files and the contents of folders.

    Nor can these read the memory of processes that were started before. Landlock allows by place: what is beside the
    paths and the folders that lead to them remains open to both, but no new file in these folders is.

    Returns:
        Whether the system does it.
    """
    if sys.platform != "linux":
        return False
    call = ctypes.CDLL(None).syscall
    attributes = struct.pack("=Q", _FILE_ACCESS)
    rules = call(_CREATE_RULESET, attributes, ctypes.c_size_t(len(attributes)), 0)
    if rules < 0:
        return False
    for path in _open_paths({path.resolve() for path in paths}):
        with suppress(OSError):  # gone, or not ours
            descriptor = os.open(path, os.O_PATH | os.O_NOFOLLOW)
            call(_ADD_RULE, rules, _PATH_BENEATH, struct.pack("=Qi", _FILE_ACCESS, descriptor), 0)
            os.close(descriptor)
    ctypes.CDLL(None).prctl(_NO_NEW_PRIVILEGES, 1, 0, 0, 0)
    is_hidden: bool = call(_RESTRICT_SELF, rules, 0) == 0
    os.close(rules)
    return is_hidden


def _open_paths(hidden: Collection[Path]) -> Iterator[str]:
    """Yields the contents of the folders that lead to paths, without the paths, these folders and links."""
    outer_paths = {path for path in hidden if not any(parent in hidden for parent in path.parents)}
    parents = {Path("/"), *(parent for path in outer_paths for parent in path.parents)}
    for folder in parents:
        with suppress(OSError), os.scandir(folder) as entries:
            paths = (entry.path for entry in entries if not entry.is_symlink())
            yield from (path for path in paths if Path(path) not in parents and Path(path) not in outer_paths)
