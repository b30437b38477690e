"""Reads files with libraries that a damaged file can crash, or keep busy without end: in a separate process."""

import pickle
import resource
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar

from soft_gripper.errors import InputError
from soft_gripper.files.notes import note

_Found = TypeVar("_Found")
_PATIENCE = 120.0  # s
_MOST_MEMORY = 8 << 30  # bytes
_LEAST_MEMORY = 3 << 30  # bytes, below which the libraries themselves may not fit
_READS = """
import os, pickle, resource, sys
os.chdir("/")  # matplotlib, which some readers import, would obey a matplotlibrc of the current folder
most = int(sys.argv[1])
resource.setrlimit(resource.RLIMIT_AS, (most, most))
try:
    read, arguments = pickle.load(sys.stdin.buffer)
    from soft_gripper.files.notes import collect_notes
    with collect_notes() as notes:
        found = read(*arguments)
    answer = found, None, notes
except MemoryError:
    answer = None, "it does not fit into memory", []
except Exception as error:  # those of libraries need not survive pickling
    of_input = type(error).__name__ == "InputError"
    answer = None, error if of_input else " ".join(str(error).split()) or type(error).__name__, []
sys.stdout.buffer.write(pickle.dumps(answer))
"""


def read_apart(read: Callable[..., _Found], path: Path, *arguments: Any) -> _Found:
    """Result of `read`, a function of a module, for a path and further arguments.

    Raises:
        InputError: if it raises one, or ends with any other error, a crash, or not in time.
    """
    memory = _memory()
    # Without -P, modules of the current folder would be imported in the place of Python's own.
    command = [sys.executable, "-P", "-c", _READS, str(memory)]
    request = pickle.dumps((read, (path.resolve(), *arguments)))
    try:
        ended = subprocess.run(command, input=request, capture_output=True, timeout=_PATIENCE)
    except subprocess.TimeoutExpired:
        expected = f"is damaged or too large: it could not be read within {_PATIENCE:g} s"
        raise InputError(path, "file", path.name, expected) from None
    if ended.returncode == 0:
        found, mistake, notes = pickle.loads(ended.stdout)
    else:
        found, mistake, notes = None, f"it is damaged: its reader ended with code {ended.returncode}", []
    if isinstance(mistake, InputError):
        raise mistake
    if mistake is not None:
        if memory < _LEAST_MEMORY:
            mistake = f"the limit here is {memory / 2**30:.1f} GiB of addresses, see `ulimit -v`"
        raise InputError(path, "file", path.name, f"cannot be read: {mistake}")
    for outcome, _, *rest in notes:
        note(outcome, path, *rest)
    return found


def _memory() -> int:
    """The addresses that a reader may take, bytes: no more than this process may."""
    limits = [limit for limit in resource.getrlimit(resource.RLIMIT_AS) if limit != resource.RLIM_INFINITY]
    return min([_MOST_MEMORY, *limits])
