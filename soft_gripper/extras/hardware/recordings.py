"""Reads and checks the files of a described experiment: a file and its description -> `HardwareRecording` of T samples.

Headings have no sign: motion capture sometimes reports a body with symmetric markers rotated by 180 degrees.
"""

import os
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from itertools import combinations
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from soft_gripper.arrays import Array
from soft_gripper.errors import InputError
from soft_gripper.extras.hardware.ambient import seems_absolute
from soft_gripper.extras.hardware.clipping import stuck_readings
from soft_gripper.extras.hardware.measured import Measured, read_instruments
from soft_gripper.extras.hardware.recording_schema import (
    LENGTH,
    PRESSURE,
    TIME,
    LoadNameConfig,
    PressureNameConfig,
    RecordingConfig,
    load_description,
)
from soft_gripper.extras.hardware.table import Columns, Table, drop_zero_stamps, split_runs
from soft_gripper.extras.hardware.table_files import is_bag_folder, read_table
from soft_gripper.extras.hardware.text_pattern import find, plain_number_pattern
from soft_gripper.files.document import require, require_value
from soft_gripper.files.notes import LEFT_OUT, READ, Note, collect_notes, note

_MAX_SIZE_RATIO = 5.0  # lengths of the finger, largest distance of bodies
_MIN_SIZE_RATIO = 0.1  # lengths of the finger; markers that are closer have a wrong unit
_MAX_DISTANCE_CHANGE = 0.05  # lengths of the finger: change of the distance of two markers on one body
_MAX_BASE_MOTION = 0.02  # lengths of the finger, that of the base over that of the tip
_MAX_LOST_TIME = 0.1  # s; a marker that is seen again later is not compared with its last position


def check_size(path: Path, field: str, points: dict[str, Array], length: float) -> None:
    """Checks that the largest distance of points, each (T, 3) m, fits a finger of `length`.

    Raises:
        InputError: if it is so large or small that the unit must be wrong.
    """
    finite_points = [point[~np.isnan(point).any(axis=1)] for point in points.values()]
    medians = np.array([np.median(point, axis=0) for point in finite_points if len(point)])
    if len(medians) < 2:
        return
    size = float(np.linalg.norm(np.ptp(medians, axis=0)))
    if not _MIN_SIZE_RATIO * length < size < _MAX_SIZE_RATIO * length:
        expected = f"they spread over {size:.3g} m, and the finger is {length:g} m long: is the unit right?"
        raise InputError(path, f"{field}.unit", f"{len(medians)} bodies or markers", expected)


def check_swapped(path: Path, time: Array, markers: dict[str, Array]) -> None:
    """Checks that no two markers, each (T, 3) m, swap names: each would jump to the other.

    Raises:
        InputError: naming both markers, and the times.
    """
    for a, b in combinations(markers, 2):
        rows = np.flatnonzero(~np.isnan(markers[a] + markers[b]).any(axis=1))
        p, q, t = markers[a][rows], markers[b][rows], time[rows]
        step_distance = _distance(p[1:], p[:-1]) + _distance(q[1:], q[:-1])
        swapped_distance = _distance(p[1:], q[:-1]) + _distance(q[1:], p[:-1])
        jumps = np.flatnonzero((2 * swapped_distance < step_distance) & (np.diff(t) < _MAX_LOST_TIME))
        if len(jumps):
            times = ", ".join(f"{t[i + 1]:.2f}" for i in jumps[:6]) + (" ..." if len(jumps) > 6 else "")
            raise InputError(path, "markers", f"{a}, {b}", f"swap names at {times} s: exchange their columns there")


def check_rigid(
    path: Path, time: Array, markers: dict[str, Array], bodies: dict[str, list[str]], length: float
) -> None:
    """Checks that markers on one body, each (T, 3) m, keep their distances.

    Raises:
        InputError: naming the body, the markers, and the time.
    """
    for body, names in bodies.items():
        for a, b in combinations(names, 2):
            distance = _distance(markers[a], markers[b])
            change = np.abs(distance - np.nanmedian(distance)) if np.isfinite(distance).any() else np.zeros(1)
            if np.nanmax(change) > _MAX_DISTANCE_CHANGE * length:
                worst = int(np.nanargmax(change))
                change_text = f"their distance changes by {change[worst] * 1e3:.1f} mm at {time[worst]:.2f} s"
                expected = f"{change_text}: are they on one rigid body? Markers along a finger need a body each"
                raise InputError(path, f"markers.bodies.{body}", f"{a}, {b}", expected)


def check_base_rests(path: Path, markers: dict[str, Array], bodies: dict[str, list[str]], length: float) -> None:
    """Checks that the markers on the body "base" hardly move, or move less than those on "tip".

    Raises:
        InputError: if they move more: the names of the bodies are exchanged.
    """
    if "tip" not in bodies or "base" not in bodies:
        return
    moved = {body: max(_motion(markers[name]) for name in bodies[body]) for body in ("tip", "base")}
    if moved["base"] > moved["tip"] + _MAX_BASE_MOTION * length:
        expected = f"the base moves by {moved['base'] * 1e3:.1f} mm and the tip by {moved['tip'] * 1e3:.1f} mm"
        raise InputError(path, "markers.bodies", "base, tip", f"{expected}: are their markers exchanged?")


def _distance(p: Array, q: Array) -> Array:
    distance: Array = np.linalg.norm(p - q, axis=-1)
    return distance


def _motion(p: Array) -> float:
    """Distance of a marker from its median position, 90th percentile, which ignores single outliers."""
    points = p[~np.isnan(p).any(axis=1)]
    return float(np.percentile(_distance(points, np.median(points, axis=0)), 90)) if len(points) else 0.0


def read_markers(table: Table, config: RecordingConfig, time: Array) -> dict[str, Array]:
    """Markers (T, 3) m by name, in the axes of the recording; NaN where one is not seen.

    Raises:
        InputError: if one is missing, or their positions are impossible.
    """
    if config.markers is None:
        return {}
    described, unit = config.markers, LENGTH[config.markers.unit]
    markers: dict[str, Array] = {}
    for name in (name for body in described.bodies.values() for name in body):
        p = table.columns(described.column_names(name)) * unit
        p[np.isnan(p).any(axis=1) | (p == 0).all(axis=1)] = (
            np.nan
        )  # some systems write zeros for markers that are not seen
        markers[name] = p
    for body, names in described.bodies.items():
        is_seen = any(np.isfinite(markers[name]).any() for name in names)
        require(is_seen, table.path, f"markers.bodies.{body}", names, "none of them is ever seen")
    check_size(table.path, "markers", markers, config.length)
    check_swapped(table.path, time, markers)
    check_rigid(table.path, time, markers, described.bodies, config.length)
    check_base_rests(table.path, markers, described.bodies, config.length)
    return markers


_NORM_TOLERANCE = 0.01  # allowed deviation of a quaternion's norm from 1


@dataclass(frozen=True)
class BodyPose:
    """The pose of a rigid body over time."""

    p: Array  # (T, 3) m
    R: Array  # (T, 3, 3), its axes


def read_poses(table: Table, config: RecordingConfig) -> dict[str, BodyPose]:
    """Poses by body, in the axes of the recording; NaN where a quaternion is missing or has not unit norm.

    Raises:
        InputError: if a column is missing, no quaternion has unit norm, or the unit cannot be right.
    """
    poses: dict[str, BodyPose] = {}
    for name, pose in config.poses.items():
        p = table.columns(pose.position) * LENGTH[pose.unit]
        wxyz = table.columns(pose.quaternion)
        good = np.abs(np.linalg.norm(wxyz, axis=1) - 1) < _NORM_TOLERANCE
        if not good.any():
            raise InputError(table.path, f"poses.{name}.quaternion", pose.quaternion, "none of them has unit norm")
        R = np.full((len(p), 3, 3), np.nan)
        R[good] = Rotation.from_quat(np.roll(wxyz[good], -1, axis=1)).as_matrix()
        poses[name] = BodyPose(p, R)
    fields = ", ".join(f"poses.{name}" for name in poses)
    check_size(table.path, fields, {name: pose.p for name, pose in poses.items()}, config.length)
    return poses


@dataclass(frozen=True)
class HardwareRecording:
    """Contents of one file, in SI units, with vectors in the finger's frame B. NaN: not seen."""

    name: str  # of the file, without its suffix
    config: RecordingConfig  # how the file is described: bodies, wires, event and what is unknown
    time: Array  # (T,) s, increasing
    markers: dict[str, Array] = field(default_factory=dict)  # (T, 3) m, by name
    reference: dict[str, Array] = field(default_factory=dict)  # (3,) m, mean of every marker over the reference span
    poses: dict[str, BodyPose] = field(default_factory=dict)  # by rigid body
    pressures: Array | None = None  # (T, C) Pa, measured, in the order of the description
    readings: Array | None = None  # (T, R) of strain sensors, in the order of the description
    lengths: dict[str, Array] = field(default_factory=dict)  # (T,) m, by wire
    pulled: dict[str, Array] = field(default_factory=dict)  # (T,) m, by tendon
    measured: dict[str, Measured] = field(default_factory=dict)  # by instruments: "force", "torque", "angle"
    labels: tuple[str, ...] = ()  # (T) of what was moved; empty if none are described
    commanded_pressure: float | None = None  # Pa, from the file's name
    load_mass: float = 0.0  # kg, hung on the tip, from the file's name
    load_place: tuple[float, float] | None = None  # m, x and z of the load from the tip; None: unknown
    gravity: Array | None = None  # (3,) m/s^2; None: unknown
    notes: tuple[Note, ...] = ()  # what is missing, was mended or left out


_MAX_PRESSURE = 1e7  # Pa, highest plausible pressure in a soft body
_MIN_PRESSURE = 10.0  # Pa, lowest plausible driving pressure


def check_relative(path: Path, field: str, pressure: Array, reference: NDArray[np.bool_], remedy: str) -> None:
    """Checks that a pressure, (T,) Pa, is relative to the surroundings; `how` says what to do if it is not.

    Raises:
        InputError: if it rests near the pressure of the air in the reference span, and is never near zero.
    """
    values = pressure[reference & np.isfinite(pressure)]
    level = float(np.median(values)) if len(values) else 0.0
    if seems_absolute(level, pressure):
        raise InputError(path, field, f"{level / 1e3:.4g} kPa at rest", f"is it measured against vacuum? {remedy}")


def read_pressures(table: Table, config: RecordingConfig, reference: NDArray[np.bool_]) -> Array | None:
    """Measured pressures, relative to the surroundings, Pa, (T, C); None if none are described.

    `reference` is true in the reference span, (T,).

    Raises:
        InputError: if the unit cannot be right, or they look absolute and nothing is said of it.
    """
    if config.pressures is None:
        return None
    described = config.pressures
    unit = described.scale or PRESSURE[described.unit]
    pressures = table.columns(described.columns) * unit
    highest = float(np.nanmax(np.abs(pressures), initial=0.0))
    fits = highest == 0 or _MIN_PRESSURE < highest < _MAX_PRESSURE
    require(fits, table.path, "pressures.unit", described.unit, f"the highest is then {highest:.3g} Pa: is it right?")
    if described.zeroed:
        open_ = pressures[reference & np.isfinite(pressures).all(axis=1)]
        require(len(open_) > 0, table.path, "pressures.zeroed", True, "no pressure is known in the reference span")
        return pressures - open_.mean(axis=0)
    if described.ambient is None:
        remedy = "give `pressures.ambient`, what it has in open air, or `zeroed: true`; if not, `ambient: 0`"
        for column, pressure in zip(described.columns, pressures.T, strict=True):
            check_relative(table.path, f"pressure in {column}", pressure, reference, remedy)
    return pressures - (described.ambient or 0.0) * unit


def read_lengths(table: Table, config: RecordingConfig) -> dict[str, Array]:
    """Measured lengths, m, (T,), by wire.

    Raises:
        InputError: if a column is missing, or the unit cannot be right.
    """
    if config.lengths is None:
        return {}
    described = config.lengths
    unit = described.scale or LENGTH[described.unit]
    columns = [wire.column for wire in described.wires.values()]
    lengths = table.columns(columns) * unit
    longest = float(np.nanmax(np.abs(lengths), initial=0.0))
    expected = f"the longest is then {longest:.3g} m, and the finger {config.length:g} m: is it right?"
    require(longest < 10 * config.length, table.path, "lengths.unit or scale", described.unit, expected)
    change = float(np.nanmax(np.ptp(lengths, axis=0), initial=0.0))
    expected = f"no wire then changes by more than {change:.3g} m, and the finger is {config.length:g} m: is it right?"
    fits = change == 0 or change > 1e-3 * config.length
    require(fits, table.path, "lengths.unit or scale", described.unit, expected)
    return dict(zip(described.wires, lengths.T, strict=True))


def read_pulled_lengths(table: Table, config: RecordingConfig) -> dict[str, Array]:
    """Pulled-in lengths of tendons, m, (T,), by tendon.

    Raises:
        InputError: if a column is missing, or the unit cannot be right.
    """
    if config.tendons is None:
        return {}
    described = config.tendons
    columns, let_out = list(described.columns.values()), list(described.antagonists.values())
    wound = table.columns(columns), -table.columns(let_out)
    pulled = np.concatenate(wound, axis=1) * described.scale
    motion = float(np.nanmax(np.ptp(pulled, axis=0), initial=0.0))
    expected = f"the most that a tendon moves is then {motion:.3g} m, and the finger is {config.length:g} m long"
    fits = 1e-4 * config.length < motion < config.length
    require(fits, table.path, "tendons.unit", described.unit, f"{expected}: is it right?")
    return dict(zip([*described.columns, *described.antagonists], pulled.T, strict=True))


_PLAUSIBLE_INTERVALS = 5e-4, 5.0  # s, plausible between samples of a soft finger
_STATED_INTERVALS = 1e-6, np.inf  # s, if the unit of time is stated
_MIN_SAMPLES = 2  # samples, minimum for a recording


def check_interval(path: Path, field: str, time: Array, min_interval: float, max_interval: float, remedy: str) -> None:
    """Checks that the median interval of times, (T,) s, is plausible; `how` says what to do if it is not.

    Raises:
        InputError: if it is not between `least` and `most`, s.
    """
    interval = float(np.median(np.diff(time)))
    if not min_interval <= interval <= max_interval:
        expected = f"samples are {duration(interval)} apart: {remedy}"
        raise InputError(path, field, float(time[1]), expected)


def duration(seconds: float) -> str:
    """Text of a time in the largest unit that fits into it."""
    unit = max((unit for unit in TIME if TIME[unit] <= max(seconds, TIME["ns"]) and unit != "cs"), key=TIME.__getitem__)
    return f"{seconds / TIME[unit]:.3g} {unit}"


_MAX_GAP = 60.0  # s, between two rows of one recording


def drop_repeats(table: Table, time: str, unit: float, max_gap: float = _MAX_GAP) -> Table:
    """Drops samples that repeat a time; `unit` of the times, and `max_gap`, s.

    Raises:
        InputError: if time runs backwards, most of it stands still, or rows are so far apart that they are of several
            recordings.
    """
    t = table.columns([time])[:, 0]
    timed = table.select(np.isfinite(t))
    t = t[np.isfinite(t)]
    require(len(t) >= _MIN_SAMPLES, table.path, time, len(t), f"needs at least {_MIN_SAMPLES} samples with a time")
    back = np.flatnonzero(np.diff(t) < 0)
    if len(back):
        row, value = int(timed.rows[back[0] + 1]), float(t[back[0] + 1])
        expected = f"time runs backwards in row {row}, after {t[back[0]]:g}: split the file there, or sort it"
        raise InputError(table.path, time, value, expected)
    far = np.flatnonzero(np.diff(t) * unit > max_gap)
    if len(far):
        row, value = int(timed.rows[far[0] + 1]), float(t[far[0] + 1])
        expected = f"a gap of more than {max_gap:g} s before row {row}, after {t[far[0]]:g}: split the file there"
        if 2 * len(far) > len(t):
            expected = f"most rows are more than {max_gap:g} s apart: is `time_unit` right? one of {', '.join(TIME)}"
        raise InputError(table.path, time, value, expected)
    is_new = np.concatenate(([True], np.diff(t) > 0))
    row = int(timed.rows[np.argmin(is_new)])
    expected = f"most rows repeat a time, the first of them row {row}: does the clock count seconds alone?"
    require(bool(is_new.mean() > 0.5), table.path, time, float(t[np.argmin(is_new)]), expected)
    if not is_new.all():
        why = f"they repeat a time, the first of them row {row}"
        note(LEFT_OUT, table.path, f"{len(is_new) - is_new.sum()} of {len(is_new)} rows", "", why)
    if len(timed.values) < len(table.values):
        note(LEFT_OUT, table.path, f"{len(table.values) - len(timed.values)} rows", "", "they have no time")
    return timed.select(is_new)


def note_defects(path: Path, time: Array, markers: dict[str, Array], reference: NDArray[np.bool_]) -> None:
    """Notes markers that are not always seen; `reference` is true in the reference span, (T,)."""
    for name, p in markers.items():
        lost = np.any(np.isnan(p), axis=1)
        if lost.any():
            first = time[np.argmax(lost)]
            longest = float(np.diff(np.concatenate((time[:1], time[~lost], time[-1:]))).max())  # between seen ones
            why = f"they are missing, the first at {first:.2f} s; the longest gap is {longest:.2f} s"
            note(LEFT_OUT, path, f"{lost.sum()} of {len(lost)} samples of {name}", "", why)
        if lost[reference].all():
            note(LEFT_OUT, path, f"the reference of {name}", "", "it is not seen in the reference span")


def note_stuck(path: Path, readings: dict[str, Array], others: dict[str, Array]) -> None:
    """Notes readings that seem to be clipped or dead, see `stuck_readings`."""
    for stuck in stuck_readings(readings, others):
        note(READ, path, stuck.name, f"{stuck.value:g}", stuck.question)


_KG_PER_GRAM = 1e-3  # kg


def named_pressure(path: Path, patterns: list[PressureNameConfig]) -> float | None:
    """Commanded pressure in a file's name, Pa; None if there is none."""
    for pattern in patterns:
        if match := find(plain_number_pattern(pattern.pattern), path.stem):
            return float(match[1]) * PRESSURE[pattern.unit]
    return None


def named_load(path: Path, load: LoadNameConfig | None) -> float:
    """Mass at the tip according to a file name, kg; 0 if it gives none."""
    match = find(plain_number_pattern(load.pattern), path.stem) if load else None
    if load is None or match is None:
        return 0.0
    return load.masses.get(match[1], float(match[1]) * _KG_PER_GRAM)


@dataclass(frozen=True)
class RecordingFrame:
    """Frame B: its origin (3,) m and, as columns, its axes (3, 3), in the axes of the recording."""

    origin: Array
    R: Array

    def to_frame(self, p: Array) -> Array:
        """Points (..., 3) m in B."""
        return (p - self.origin) @ self.R


def frame_axes(config: RecordingConfig) -> Array:
    """Axes of B in those of the recording, (3, 3), each a column."""
    z = np.array(config.frame.z) / np.linalg.norm(config.frame.z)
    x = np.array(config.frame.x) - np.dot(config.frame.x, z) * z
    x /= np.linalg.norm(x)
    return np.column_stack((x, np.cross(z, x), z))


def recording_frame(
    path: Path,
    config: RecordingConfig,
    markers: dict[str, Array],
    poses: dict[str, BodyPose],
    reference: NDArray[np.bool_],
) -> RecordingFrame:
    """Frame B of a description; `reference` is true in the reference span, (T,).

    Raises:
        InputError: if its origin is neither given nor measured.
    """
    R = frame_axes(config)
    if config.frame.origin is not None:
        return RecordingFrame(np.array(config.frame.origin), R)
    if "base" in poses:
        return RecordingFrame(finite_mean(poses["base"].p[reference]), R)
    base = config.markers.bodies.get("base", []) if config.markers else []
    expected = "without it a pose or markers of the body 'base' are needed"
    require(len(base) > 0, path, "frame.origin", None, expected)
    return RecordingFrame(finite_mean(np.array([finite_mean(markers[name][reference]) for name in base])), R)


def finite_mean(p: Array) -> Array:
    """Mean over the finite rows of (T, 3), NaN if there are none."""
    finite_points = p[~np.isnan(p).any(axis=1)]
    mean: Array = finite_points.mean(axis=0) if len(finite_points) else np.full(3, np.nan)
    return mean


def read_recordings(path: Path, config: RecordingConfig) -> list[HardwareRecording]:
    """Reads the runs in a file according to its description; several are named after the file, and numbered.

    Raises:
        InputError: naming file, column or marker, and row or time, if it contradicts the description.
    """
    with collect_notes() as file_notes:
        table, unit = _table(path, config), config.time_scale
        if config.event != "settled":
            table = drop_zero_stamps(table, config.time, unit)
    runs = [table] if config.pause is None else split_runs(table, config.time, config.pause / unit)
    names = [path.stem] if len(runs) == 1 else [f"{path.stem}_{i}" for i in range(1, len(runs) + 1)]
    recordings = []
    for name, run in zip(names, runs, strict=True):
        with collect_notes() as notes:
            recording = _read(name, run, config)
        recordings.append(replace(recording, notes=(*file_notes, *notes)))
    return recordings


def read_recording(path: Path, config: RecordingConfig) -> HardwareRecording:
    """Reads a file that is one run; errors as of `read_recordings`, and if there are several."""
    runs = read_recordings(path, config)
    require(len(runs) == 1, path, "pause", config.pause, f"the file has {len(runs)} runs, and one is expected here")
    return runs[0]


def _read(name: str, run: Table, config: RecordingConfig) -> HardwareRecording:
    max_gap = np.inf if config.event == "settled" else config.pause or _MAX_GAP  # at rest, time does not matter
    path, unit = run.path, config.time_scale
    table = drop_repeats(run, config.time, unit, max_gap)
    time = table.columns([config.time])[:, 0] * unit
    if config.event != "settled":
        min_interval, max_interval = _PLAUSIBLE_INTERVALS if config.time_unit is None else _STATED_INTERVALS
        remedy = f"is `time_unit` right? one of {', '.join(TIME)}; state it, even if it is s"
        check_interval(path, config.time, time, min_interval, max_interval, remedy)
    reference = time <= time[0] + config.reference
    markers, poses = read_markers(table, config, time), read_poses(table, config)
    B = recording_frame(path, config, markers, poses, reference)
    placed = {name: B.to_frame(p) for name, p in markers.items()}
    note_defects(path, time, placed, reference)
    pressures, lengths = read_pressures(table, config, reference), read_lengths(table, config)
    readings = {f"reading {i}": column for i, column in enumerate(table.columns(config.readings).T)}
    driving = {} if pressures is None else {f"pressure {i}": column for i, column in enumerate(pressures.T)}
    note_stuck(path, readings | {f"length {wire}": length for wire, length in lengths.items()}, driving)
    return HardwareRecording(
        name=name,
        config=config,
        time=time,
        markers=placed,
        reference={name: finite_mean(p[reference]) for name, p in placed.items()},
        poses={name: BodyPose(B.to_frame(pose.p), B.R.T @ pose.R) for name, pose in poses.items()},
        pressures=pressures,
        readings=table.columns(config.readings) if config.readings else None,
        lengths=lengths,
        pulled=read_pulled_lengths(table, config),
        measured=read_instruments(table, config, config.length),
        labels=table.labels,
        commanded_pressure=named_pressure(path, config.commanded_pressure),
        load_mass=named_load(path, config.load),
        load_place=None if config.load_place is None else (config.load_place[0], config.load_place[1]),
        gravity=None if config.gravity is None else np.array(config.gravity) @ B.R,
    )


def _table(path: Path, config: RecordingConfig) -> Table:
    markers, label = config.markers, config.labels
    columns = Columns(
        names=config.columns,
        time=config.time,
        time_unit=config.time_scale,
        header=config.header,
        text=config.text,
        label=None if label is None else label.column,
        points="" if markers is None else markers.columns,
        point_unit=1.0 if markers is None else LENGTH[markers.unit],
        hold=config.hold,
    )
    return read_table(path, columns)


DATA_FOLDER = "SOFT_GRIPPER_DATA"  # environment variable


def find_recordings(
    files: Sequence[str], described_as: str | None = None, data: Path | None = None
) -> list[HardwareRecording]:
    """Finds and reads recordings: the files of `recording_paths`, as they are described.

    Raises:
        InputError: if a file or description is not found, or wrong.
    """
    paths = recording_paths(files, described_as, data)
    return [run for path in paths for run in read_recordings(path, _description(path, described_as))]


def recording_paths(files: Sequence[str], described_as: str | None = None, data: Path | None = None) -> list[Path]:
    """Finds recordings.

    Args:
        files: each as given, or below `data`, or in a folder there named after the description.
        described_as: a shipped description's name, or a path; None: the YAML beside a file, with its name or
            recording.yaml.
        data: folder of recordings; None: the environment variable SOFT_GRIPPER_DATA.

    Raises:
        InputError: if a file is not found.
    """
    folder = data or (Path(os.environ[DATA_FOLDER]) if os.environ.get(DATA_FOLDER) else None)
    require(len(files) > 0, "recording", "FILE", [], "give at least one file")
    return [_find(file, described_as, folder) for file in files]


def _find(file: str, described_as: str | None, folder: Path | None) -> Path:
    candidates = [Path(file)]
    if folder is not None:
        candidates += [folder / file, *([folder / Path(described_as).stem / file] if described_as else [])]
    path = next((candidate for candidate in candidates if os.path.isfile(candidate) or is_bag_folder(candidate)), None)
    below = f"nor below {folder}" if folder else f"and neither --data nor {DATA_FOLDER} names a folder"
    if path is None:
        raise InputError("recording", "FILE", file, f"there is no such file here, {below}")
    return path


def _description(path: Path, described_as: str | None) -> RecordingConfig:
    if described_as is not None:
        return load_description(described_as)
    candidates = path.with_suffix(".yaml"), path.with_name("recording.yaml")
    description = next((candidate for candidate in candidates if os.path.isfile(candidate)), None)
    expected = f"no description: give --as NAME, or put {candidates[0].name} or {candidates[1].name} next to it"
    return load_description(require_value(description, path, "description", expected))
