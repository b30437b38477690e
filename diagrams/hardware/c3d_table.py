"""C3D files of motion capture (https://www.c3d.org), read with ezc3d."""

from pathlib import Path
from typing import Any

import numpy as np

from soft_gripper.diagrams.hardware.table import Table
from soft_gripper.diagrams.hardware.units import LENGTH
from soft_gripper.diagrams.schema.ranges import require
from soft_gripper.errors import InputError


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
    parameters = data["parameters"]["POINT"]
    points, rate = data["data"]["points"][:3], float(parameters["RATE"]["value"][0])
    labels = [label.strip().rpartition(":")[2] for label in parameters["LABELS"]["value"]]
    require(points.size > 0 and len(labels) > 0, path, "file", path.name, "is empty: it holds no points")
    require(rate > 0, path, "POINT:RATE", rate, "must be above 0")
    own = str((parameters["UNITS"]["value"] or ["mm"])[0]).strip() or "mm"
    require(own in LENGTH, path, "POINT:UNITS", own, f"one of {', '.join(LENGTH)}")
    frames = np.arange(points.shape[2])
    names = [columns.format(marker=label, axis=axis) for label in labels for axis in "xyz"]
    flat = points[:, : len(labels)].transpose(2, 1, 0).reshape(len(frames), -1) * (LENGTH[own] / unit)
    return Table(path, (time, *names), np.column_stack((frames / rate, flat)), frames + 1)


def _read(path: Path) -> Any:
    try:
        import ezc3d  # an optional extra: needed for these files alone
    except ImportError:
        raise InputError(path, "file", path.name, "C3D takes ezc3d: pip install 'soft-gripper[c3d]'") from None
    try:
        return ezc3d.c3d(str(path))
    except (OSError, RuntimeError, ValueError) as error:
        raise InputError(path, "file", path.name, f"cannot be read: {' '.join(str(error).split())}") from None
