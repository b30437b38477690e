"""Files of hardware recordings: made up, and the published ones where they are."""

import os
from pathlib import Path

import numpy as np
import pytest

from soft_gripper.arrays import Array
from soft_gripper.extras.hardware.recordings import HardwareRecording

MARKERS = {"tip_1": (10, 20, 100), "tip_2": (-15, 5, 100), "tip_3": (12, -22, 95), "base_1": (20, 0, 0)}  # mm
OF_TIP = """
time: time_s
length: 0.1
markers:
  columns: "{marker}_{axis}_mm"
  unit: mm
  bodies: {tip: [tip_1, tip_2, tip_3]}
frame: {origin: [0, 0, 0]}
"""
DESCRIPTION = OF_TIP.replace("tip_3]", "tip_3], base: [base_1]")


def swinging(samples: int = 200) -> dict[str, Array]:
    """Columns of a recording in which the tip's markers swing along x by 10 mm, at 100 Hz, mm and s."""
    time = np.arange(samples) / 100
    columns = {"time_s": time}
    for name, place in MARKERS.items():
        for axis, value in zip("xyz", place, strict=True):
            moves = axis == "x" and name.startswith("tip")
            columns[f"{name}_{axis}_mm"] = value + (10 * np.sin(5 * time) if moves else 0 * time)
    return columns


def write_csv(path: Path, columns: dict[str, Array]) -> Path:
    """Writes columns with their names in the first row; an empty cell for NaN."""
    rows = [
        ",".join(columns),
        *(",".join("" if np.isnan(v) else repr(float(v)) for v in row) for row in _rows(columns)),
    ]
    path.write_text("\n".join(rows) + "\n", encoding="utf-8")
    return path


def whys(recording: HardwareRecording) -> list[str]:
    """The notes on a recording, without its name."""
    return [f"{note.subject}: {note.why}" for note in recording.notes]


def _rows(columns: dict[str, Array]) -> Array:
    return np.column_stack(list(columns.values()))


def published(name: str) -> Path:
    """The folder of a published data set; skips the test where it is not."""
    root = Path(__file__).parents[3]
    folders = [Path(os.environ["SOFT_GRIPPER_DATA"])] if os.environ.get("SOFT_GRIPPER_DATA") else []
    for folder in [*folders, root.parent / "shared/data"]:
        if (folder / name).is_dir():
            return folder / name
    pytest.skip(f"the published recordings {name} are neither below SOFT_GRIPPER_DATA nor in ../shared/data")
