"""Reads files in a separate process, since a damaged file can crash some libraries or keep them busy without end.

`read_isolated` sends the process a reader and a path, and returns the result or raises the error, within a limit of
time, s, and of memory, bytes.
"""

import pickle
import resource
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar

from soft_gripper.errors import InputError
from soft_gripper.files.notes import note

_Result = TypeVar("_Result")
_TIMEOUT = 120.0  # s
_MAX_MEMORY = 8 << 30  # bytes
_MIN_MEMORY = 3 << 30  # bytes; the libraries themselves may not fit into less
_READER_SCRIPT = """
import os, pickle, resource, sys
os.chdir("/")  # matplotlib, which some readers import, would obey a matplotlibrc of the current folder
most = int(sys.argv[1])
resource.setrlimit(resource.RLIMIT_AS, (most, most))
try:
    read, arguments = pickle.load(sys.stdin.buffer)
    from soft_gripper.files.notes import collect_notes
    with collect_notes() as notes:
        result = read(*arguments)
    answer = result, None, notes
except MemoryError:
    answer = None, "it does not fit into memory", []
except Exception as error:  # those of libraries need not survive pickling
    of_input = type(error).__name__ == "InputError"
    answer = None, error if of_input else " ".join(str(error).split()) or type(error).__name__, []
sys.stdout.buffer.write(pickle.dumps(answer))
"""


def read_isolated(read: Callable[..., _Result], path: Path, *arguments: Any) -> _Result:
    """Calls `read`, a module-level function, with a path and further arguments in a separate process."""
    memory = _memory()
    # Without -P, modules of the current folder would be imported in the place of Python's own.
    command = [sys.executable, "-P", "-c", _READER_SCRIPT, str(memory)]
    request = pickle.dumps((read, (path.resolve(), *arguments)))
    try:
        process = subprocess.run(command, input=request, capture_output=True, timeout=_TIMEOUT)
    except subprocess.TimeoutExpired:
        expected = f"is damaged or too large: it could not be read within {_TIMEOUT:g} s"
        raise InputError(path, "file", path.name, expected) from None
    if process.returncode == 0:
        result, error, notes = pickle.loads(process.stdout)
    else:
        result, error, notes = None, f"it is damaged: its reader ended with code {process.returncode}", []
    if isinstance(error, InputError):
        raise error
    if error is not None:
        if memory < _MIN_MEMORY:
            error = f"the limit here is {memory / 2**30:.1f} GiB of addresses, see `ulimit -v`"
        raise InputError(path, "file", path.name, f"cannot be read: {error}")
    for outcome, _, *texts in notes:
        note(outcome, path, *texts)
    return result


def _memory() -> int:
    """Address space of a reader, bytes: no more than this process may take."""
    limits = [limit for limit in resource.getrlimit(resource.RLIMIT_AS) if limit != resource.RLIM_INFINITY]
    return min([_MAX_MEMORY, *limits])


def c3d_points(path: Path) -> dict[str, Any]:
    """Points (3, markers, frames), analog channels (channels, samples), and attributes of both, of a C3D file.

    It calls ezc3d for the format of https://www.c3d.org, in a separate process.
    """
    import ezc3d

    file = ezc3d.c3d(str(path))
    points, analogs = file["data"]["points"][:3], file["data"]["analogs"][0]
    attributes = {name: file["parameters"]["POINT"][name]["value"] for name in ("RATE", "LABELS", "UNITS")}
    channels = file["parameters"]["ANALOG"].get("LABELS", {"value": []})["value"]
    return {**attributes, "points": points, "analogs": analogs, "CHANNELS": channels}
