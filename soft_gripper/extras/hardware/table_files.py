"""Reads files of numbers as tables of named columns.

| file | columns |
|---|---|
| text | numbers between commas; names are in the first row, or given |
| text of JSON objects | one object a line; the entries of a list are `name[0]`, `name[1]` ... |
| `.c3d`, motion capture | of each point, in a pattern, and analog channels, by their labels |
| `.nc`, netCDF 3 or 4 | variables over the dimension of the time, `name` or `name[0]`, `name[0,1]` ... |
| `.bag`, `.db3`, `.mcap`, folder of a ROS 2 bag | fields of messages, see `bag_messages` |
"""

import importlib.util
from pathlib import Path

import numpy as np

from soft_gripper.arrays import Array
from soft_gripper.diagrams.recording import Recording
from soft_gripper.errors import InputError
from soft_gripper.extras.hardware.bag_messages import bag_columns
from soft_gripper.extras.hardware.isolated_reading import c3d_points, read_isolated
from soft_gripper.extras.hardware.recording_schema import LENGTH
from soft_gripper.extras.hardware.table import DEFAULT_HOLD, Columns, Table, hold_values, leave_out_start, note_missing
from soft_gripper.extras.hardware.text_pattern import fill_pattern
from soft_gripper.extras.hardware.text_table import read_text_table
from soft_gripper.files.text import check_regular

BAGS = (".bag", ".db3", ".mcap")
OTHER_THAN_TEXT = (*BAGS, ".nc", ".c3d")


def read_table(path: Path, columns: Columns) -> Table:
    """Reads a file of the kind that its name shows."""
    for part in path.iterdir() if is_bag_folder(path) else (path,):
        check_regular(part)
    is_text = not is_bag_folder(path) and path.suffix.lower() not in OTHER_THAN_TEXT
    if columns.label is not None and not is_text:
        raise InputError(path, "labels.column", columns.label, "is read of files of text alone")
    hold = columns.hold
    if is_text:
        table = hold_values(read_text_table(path, columns), columns)
    elif path.suffix.lower() in BAGS or is_bag_folder(path):
        hold = DEFAULT_HOLD if hold is None else hold
        _require_extra(path, "ros", "rosbags", "mcap")
        names = tuple(columns.fields)
        values = read_isolated(bag_columns, path, names[0], names[1:], hold, columns.time_unit)
        table = Table(path, names, values, np.arange(len(values)) + 1)
    elif path.suffix.lower() == ".c3d":
        table = _read_c3d(path, columns)
    else:
        table = hold_values(_read_netcdf(path, columns), columns)
    if hold is not None:
        table = leave_out_start(table, columns, hold)
    note_missing(table, columns, hold)
    return table


def is_bag_folder(path: Path) -> bool:
    """Whether a path leads to a ROS 2 bag that is a folder."""
    return (path / "metadata.yaml").is_file()


def _read_netcdf(path: Path, columns: Columns) -> Table:
    data, time = Recording.load(path).data, columns.time
    if time not in data.variables or data[time].ndim != 1:
        candidates = ", ".join(str(name) for name in data.variables if data[name].ndim == 1)
        raise InputError(path, "time", time, f"is not a variable with one dimension; these are: {candidates}")
    (time_axis,) = data[time].dims
    sample_count = data.sizes[time_axis]
    if not sample_count:
        raise InputError(path, "file", path.name, "is empty: it has no samples")
    names, values = list[str](), list[Array]()
    for name in data.variables:
        variable = data[name]
        if time_axis in variable.dims and variable.dtype.kind in "biufmM" and variable.size:
            matrix = variable.transpose(time_axis, ...).values.reshape(sample_count, -1)
            if matrix.dtype.kind in "mM":
                matrix = (matrix - matrix[:1]) / np.timedelta64(1, "s") / columns.time_unit
            sizes = [size for dim, size in variable.sizes.items() if dim != time_axis]
            indices = [",".join(map(str, index)) for index in np.ndindex(*sizes)]
            names += [f"{name}[{index}]" if index else str(name) for index in indices]
            values.append(matrix)
    needed_values = np.concatenate(values, axis=1)[:, columns.places(path, names)].astype(float)
    return Table(path, tuple(columns.fields), needed_values, np.arange(sample_count) + 1)


_MAX_RATE = 1e6  # Hz


def _read_c3d(path: Path, columns: Columns) -> Table:
    """Table of points, NaN where not seen, and analog channels, at times from 0 on."""
    _require_extra(path, "c3d", "ezc3d")
    data = read_isolated(c3d_points, path)
    points, rate = data["points"], float(data["RATE"][0]) if len(data["RATE"]) else 0.0
    labels = [str(label).strip() for label in data["LABELS"]][: points.shape[1]] if columns.points else []
    channels = [str(label).strip() for label in data["CHANNELS"]][: len(data["analogs"])]
    unit = str((data["UNITS"] or ["mm"])[0]).strip() or "mm"
    for fits, name, value, expected in (
        (points.shape[2] > 0, "file", path.name, "is empty: it has no points"),
        (labels or channels, "markers", None, "it has no analog channels: describe its markers"),
        (0 < rate <= _MAX_RATE, "POINT:RATE", rate, f"must be above 0, and at most {_MAX_RATE:g} Hz"),
        (unit in LENGTH, "POINT:UNITS", unit, f"one of {', '.join(LENGTH)}"),
    ):
        if not fits:
            raise InputError(path, name, value, expected)
    frames = np.arange(points.shape[2])
    scale = LENGTH[unit] / columns.point_unit
    matrix = points[:, : len(labels)].transpose(2, 1, 0).reshape(len(frames), -1) * scale
    analogs = data["analogs"][: len(channels)].T
    analog_stride = max(len(analogs) // len(frames), 1) if channels else 1
    synchronous = analogs[::analog_stride][: len(frames)] if channels else np.empty((len(frames), 0))
    names = [fill_pattern(columns.points, {"marker": label, "axis": axis}) for label in labels for axis in "xyz"]
    names += channels
    values = np.column_stack((matrix, synchronous))
    # A label has its subject in front, and may be given without.
    indices = [i for i, name in enumerate(names) if ":" in name]
    names, values = names + [names[i].rpartition(":")[2] for i in indices], values[:, [*range(len(names)), *indices]]
    time = frames / rate / columns.time_unit
    places = columns.places(path, [columns.time, *names])
    return Table(path, tuple(columns.fields), np.column_stack((time, values))[:, places], frames + 1)


def _require_extra(path: Path, extra: str, *libraries: str) -> None:
    if any(importlib.util.find_spec(library) is None for library in libraries):
        advice = f"such files require {' and '.join(libraries)}: pip install 'soft-gripper[{extra}]'"
        raise InputError(path, "file", path.name, advice)
