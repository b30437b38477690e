"""C3D files of motion capture (https://www.c3d.org), read with ezc3d.

A damaged file can crash ezc3d or keep it busy without end, so that it reads in a process of its own.
"""

import importlib.util
import pickle
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np

from soft_gripper.diagrams.hardware.table import Table
from soft_gripper.diagrams.hardware.units import LENGTH
from soft_gripper.diagrams.schema.ranges import require
from soft_gripper.errors import InputError, first_line
from soft_gripper.reading import check_regular

_PATIENCE = 120.0  # s
_MOST_RATE = 1e6  # Hz
_READS = """
import pickle, resource, sys
import ezc3d
resource.setrlimit(resource.RLIMIT_AS, (8 << 30, 8 << 30))
try:
    data = ezc3d.c3d(sys.argv[1])
    found = {"points": data["data"]["points"][:3]}
    found |= {name: data["parameters"]["POINT"][name]["value"] for name in ("RATE", "LABELS", "UNITS")}
except Exception as error:
    found = " ".join(str(error).split()) or type(error).__name__
sys.stdout.buffer.write(pickle.dumps(found))
"""


def read_c3d(path: Path, time: str, columns: str, unit: float) -> Table:
    """The points of a C3D file as a table; NaN where a point is not seen.

    Args:
        path: of the file.
        time: what its column of time, s, is to be called; it begins at 0.
        columns: what those of a point are to be called, with {marker} for its label and {axis} for x, y, z.
        unit: m, of what those columns are to hold.

    Raises:
        InputError: if ezc3d is missing, or the file cannot be read or holds no points.
    """
    data = _read(path)
    points, rate = data["points"], float(data["RATE"][0]) if len(data["RATE"]) else 0.0
    labels = [str(label).strip().rpartition(":")[2] for label in data["LABELS"]][: points.shape[1]]
    require(points.size > 0 and len(labels) > 0, path, "file", path.name, "is empty: it holds no points")
    require(0 < rate <= _MOST_RATE, path, "POINT:RATE", rate, f"must be above 0, and {_MOST_RATE:g} Hz at most")
    own = str((data["UNITS"] or ["mm"])[0]).strip() or "mm"
    require(own in LENGTH, path, "POINT:UNITS", own, f"one of {', '.join(LENGTH)}")
    frames = np.arange(points.shape[2])
    names = [columns.format(marker=label, axis=axis) for label in labels for axis in "xyz"]
    flat = points[:, : len(labels)].transpose(2, 1, 0).reshape(len(frames), -1) * (LENGTH[own] / unit)
    return Table(path, (time, *names), np.column_stack((frames / rate, flat)), frames + 1)


def _read(path: Path) -> dict[str, Any]:
    """The points, (3, markers, frames), and what is said of them."""
    check_regular(path)
    if importlib.util.find_spec("ezc3d") is None:  # an optional extra: needed for these files alone
        raise InputError(path, "file", path.name, "C3D takes ezc3d: pip install 'soft-gripper[c3d]'")
    command = [sys.executable, "-c", _READS, str(path.resolve())]
    try:
        ended = subprocess.run(command, stdin=subprocess.DEVNULL, capture_output=True, timeout=_PATIENCE, check=True)
    except subprocess.TimeoutExpired:
        raise InputError(path, "file", path.name, f"is damaged: it is not read within {_PATIENCE:g} s") from None
    except subprocess.CalledProcessError as error:
        expected = f"is damaged: ezc3d ended with code {error.returncode}"
        raise InputError(path, "file", path.name, expected) from None
    found = pickle.loads(ended.stdout)
    if isinstance(found, str):
        raise InputError(path, "file", path.name, f"cannot be read: {first_line(ValueError(found))}")
    return dict(found)
