"""C3D files, written from columns of markers."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest

from soft_gripper.arrays import Array


def write_c3d(path: Path, columns: dict[str, Array], unit: str = "mm", labels: Sequence[str] = ()) -> Path:
    """Writes markers, mm, in another unit and with other labels if these are given; 100 Hz."""
    ezc3d = pytest.importorskip("ezc3d", reason="C3D files take ezc3d: pip install 'soft-gripper[c3d]'")
    names, file = [name.removesuffix("_x_mm") for name in columns if name.endswith("_x_mm")], ezc3d.c3d()
    point = file["parameters"]["POINT"]
    point["RATE"]["value"], point["UNITS"]["value"], point["LABELS"]["value"] = [100.0], [unit], [*(labels or names)]
    size = {"mm": 1.0, "m": 1e-3}[unit]
    points = [[columns[f"{name}_{axis}_mm"] * size for name in names] for axis in "xyz"]
    file["data"]["points"] = np.array([*points, np.ones_like(points[0])])
    file.write(str(path))
    return path
