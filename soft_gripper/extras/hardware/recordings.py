"""Reads and checks the files of a described experiment: a file and its description -> `HardwareRecording` of T samples.

Checks yield what is wrong as field, value and expectation; `_read` raises the first of it, with the path.

Headings have no sign: motion capture sometimes reports a body with symmetric markers rotated by 180 degrees.
"""

import os
from collections.abc import Iterable, Iterator, Sequence
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
from soft_gripper.extras.hardware.measured import Measured, instrument_violations, read_instruments
from soft_gripper.extras.hardware.recording_schema import (
    LENGTH,
    PRESSURE,
    TIME,
    LengthsConfig,
    MarkersConfig,
    PressuresConfig,
    RecordingConfig,
    load_description,
)
from soft_gripper.extras.hardware.table import Columns, Table, drop_zero_stamps, split_runs
from soft_gripper.extras.hardware.table_files import is_bag_folder, read_table
from soft_gripper.extras.hardware.text_pattern import find, plain_number_pattern
from soft_gripper.files.notes import LEFT_OUT, READ, Note, collect_notes, note
from soft_gripper.quantity import Violation

_MAX_SIZE_RATIO = 5.0  # lengths of the finger, largest distance of bodies
_MIN_SIZE_RATIO = 0.1  # lengths of the finger; markers that are closer have a wrong unit
_MAX_DISTANCE_CHANGE = 0.05  # lengths of the finger: change of the distance of two markers on one body
_MAX_BASE_MOTION = 0.02  # lengths of the finger, that of the base over that of the tip
_MAX_LOST_TIME = 0.1  # s; a marker that is seen again later is not compared with its last position
_NORM_TOLERANCE = 0.01  # allowed deviation of a quaternion's norm from 1
_MAX_PRESSURE, _MIN_PRESSURE = 1e7, 10.0  # Pa, highest and lowest plausible driving pressure in a soft body
_PLAUSIBLE_INTERVALS = 5e-4, 5.0  # s, plausible between samples of a soft finger
_STATED_INTERVALS = 1e-6, np.inf  # s, if the unit of time is stated
_MIN_SAMPLES = 2  # samples, minimum for a recording
_MAX_GAP = 60.0  # s, between two rows of one recording
_KG_PER_GRAM = 1e-3  # kg
DATA_FOLDER = "SOFT_GRIPPER_DATA"  # environment variable


@dataclass(frozen=True)
class BodyPose:
    """The pose of a rigid body over time."""

    p: Array  # (T, 3) m
    R: Array  # (T, 3, 3), its axes


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


def read_recordings(path: Path, config: RecordingConfig) -> list[HardwareRecording]:
    """Reads the runs in a file according to its description; several are named after the file, and numbered.

    Raises:
        InputError: naming file, column or marker, and row or time, if it contradicts the description.
    """
    with collect_notes() as file_notes:
        table = read_table(path, _described_columns(config))
        if config.event != "settled":
            table = drop_zero_stamps(table, config.time, config.time_scale)
    runs = [table] if config.pause is None else split_runs(table, config.time, config.pause / config.time_scale)
    names = [path.stem] if len(runs) == 1 else [f"{path.stem}_{i}" for i in range(1, len(runs) + 1)]
    recordings = []
    for name, run in zip(names, runs, strict=True):
        with collect_notes() as notes:
            recording = _read(name, run, config)
        recordings.append(replace(recording, notes=(*file_notes, *notes)))
    return recordings


def read_recording(path: Path, config: RecordingConfig) -> HardwareRecording:
    """Reads a file with one run; raises errors like `read_recordings`, and if there are several runs."""
    recording, *others = read_recordings(path, config)
    if others:
        raise InputError(path, "pause", config.pause, f"the file has {1 + len(others)} runs, and one is expected here")
    return recording


def _described_columns(config: RecordingConfig) -> Columns:
    markers = config.markers
    return Columns(
        names=config.columns,
        time=config.time,
        time_unit=config.time_scale,
        header=config.header,
        text=config.text,
        label=config.labels.column if config.labels else None,
        points="" if markers is None else markers.columns,
        point_unit=1.0 if markers is None else LENGTH[markers.unit],
        hold=config.hold,
    )


def _read(name: str, run: Table, config: RecordingConfig) -> HardwareRecording:
    def check(violations: Iterable[Violation]) -> None:
        for violation in violations:
            raise InputError(run.path, *violation)

    timed_rows = run.select(np.isfinite(run.columns([config.time])[:, 0]))
    check(_time_violations(timed_rows.columns([config.time])[:, 0], timed_rows.rows, config))
    table = _drop_repeats(run, timed_rows, config.time)
    time = table.columns([config.time])[:, 0] * config.time_scale
    if config.event != "settled":
        limits = _PLAUSIBLE_INTERVALS if config.time_unit is None else _STATED_INTERVALS
        remedy = f"is `time_unit` right? one of {', '.join(TIME)}; state it, even if it is s"
        check(interval_violations(config.time, time, *limits, remedy))
    reference = time <= time[0] + config.reference
    markers, poses = _read_markers(table, config.markers), _read_poses(table, config)
    if config.markers is not None:
        check(_marker_violations(time, markers, config.markers, config.length))
    check(_pose_violations(poses, config))
    check(_frame_violations(config))
    B = _recording_frame(config, markers, poses, reference)
    markers = {marker: B.to_frame(p) for marker, p in markers.items()}
    _note_defects(run.path, time, markers, reference)
    pressures = None
    if config.pressures is not None:
        measured_pressures = table.columns(config.pressures.columns) * _pressure_unit(config.pressures)
        check(_pressure_violations(measured_pressures, config.pressures, reference))
        pressures = measured_pressures - _ambient_pressures(measured_pressures, config.pressures, reference)
    lengths, pulled_lengths = _read_lengths(table, config.lengths), _read_pulled_lengths(table, config)
    if config.lengths is not None:
        check(_length_violations(lengths, config.lengths, config.length))
    readings = {f"reading {i}": column for i, column in enumerate(table.columns(config.readings).T)}
    driving = {} if pressures is None else {f"pressure {i}": column for i, column in enumerate(pressures.T)}
    note_stuck(run.path, readings | {f"length {wire}": length for wire, length in lengths.items()}, driving)
    check(_tendon_violations(pulled_lengths, config))
    instruments = read_instruments(table, config)
    check(instrument_violations(instruments, config, config.length))
    return HardwareRecording(
        name=name,
        config=config,
        time=time,
        markers=markers,
        reference={marker: _finite_mean(p[reference]) for marker, p in markers.items()},
        poses={body: BodyPose(B.to_frame(pose.p), B.R.T @ pose.R) for body, pose in poses.items()},
        pressures=pressures,
        readings=table.columns(config.readings) if config.readings else None,
        lengths=lengths,
        pulled=pulled_lengths,
        measured=instruments,
        labels=table.labels,
        commanded_pressure=_named_pressure(run.path, config),
        load_mass=_named_load(run.path, config),
        load_place=None if config.load_place is None else (config.load_place[0], config.load_place[1]),
        gravity=None if config.gravity is None else np.array(config.gravity) @ B.R,
    )


def _time_violations(t: Array, rows: NDArray[np.int_], config: RecordingConfig) -> Iterator[Violation]:
    """Yields violations of the times of one recording, (T,) in their unit, by the rows of the file."""
    name, unit, step = config.time, config.time_scale, np.diff(t)
    max_gap = np.inf if config.event == "settled" else config.pause or _MAX_GAP  # at rest, time does not matter
    if len(t) < _MIN_SAMPLES:
        yield name, len(t), f"needs at least {_MIN_SAMPLES} samples with a time"
        return
    for i in np.flatnonzero(step < 0):
        expected = f"time runs backwards in row {rows[i + 1]}, after {t[i]:g}: split the file there, or sort it"
        yield name, float(t[i + 1]), expected
    far = np.flatnonzero(step * unit > max_gap)
    for i in far:
        expected = f"a gap of more than {max_gap:g} s before row {rows[i + 1]}, after {t[i]:g}: split the file there"
        if 2 * len(far) > len(t):
            expected = f"most rows are more than {max_gap:g} s apart: is `time_unit` right? one of {', '.join(TIME)}"
        yield name, float(t[i + 1]), expected
    is_new = np.append(True, step > 0)
    if is_new.mean() <= 0.5:
        row = int(np.argmin(is_new))
        expected = f"most rows repeat a time, the first of them row {rows[row]}: does the clock count seconds alone?"
        yield name, float(t[row]), expected


def _drop_repeats(run: Table, timed: Table, time: str) -> Table:
    """Samples with a time that differs from the one before."""
    is_new = np.append(True, np.diff(timed.columns([time])[:, 0]) > 0)
    if not is_new.all():
        reason = f"they repeat a time, the first of them row {timed.rows[np.argmin(is_new)]}"
        note(LEFT_OUT, run.path, f"{len(is_new) - is_new.sum()} of {len(is_new)} rows", "", reason)
    if len(timed.values) < len(run.values):
        note(LEFT_OUT, run.path, f"{len(run.values) - len(timed.values)} rows", "", "they have no time")
    return timed.select(is_new)


def interval_violations(
    name: str, time: Array, min_interval: float, max_interval: float, remedy: str
) -> Iterator[Violation]:
    """Yields an implausible median interval of times, (T,) s, with its remedy."""
    interval = float(np.median(np.diff(time)))
    if not min_interval <= interval <= max_interval:
        fitting_units = [unit for unit in TIME if TIME[unit] <= max(interval, TIME["ns"]) and unit != "cs"]
        unit = max(fitting_units, key=TIME.__getitem__)
        yield name, float(time[1]), f"samples are {interval / TIME[unit]:.3g} {unit} apart: {remedy}"


def _read_markers(table: Table, described: MarkersConfig | None) -> dict[str, Array]:
    """Markers (T, 3) m by name, in the axes of the recording; NaN where one is not seen."""
    markers: dict[str, Array] = {}
    if described is None:
        return markers
    for name in (name for body in described.bodies.values() for name in body):
        p = table.columns(described.column_names(name)) * LENGTH[described.unit]
        p[np.isnan(p).any(axis=1) | (p == 0).all(axis=1)] = np.nan  # some systems write zeros for unseen markers
        markers[name] = p
    return markers


def _marker_violations(
    time: Array, markers: dict[str, Array], described: MarkersConfig, length: float
) -> Iterator[Violation]:
    """Yields impossible positions of markers, each (T, 3) m, on a finger of a length, m."""
    bodies = described.bodies
    for body, names in bodies.items():
        if not any(np.isfinite(markers[name]).any() for name in names):
            yield f"markers.bodies.{body}", names, "none of them is ever seen"
    yield from _size_violations("markers", markers, length)
    yield from _swap_violations(time, markers)
    for body, names in bodies.items():
        for a, b in combinations(names, 2):
            distance = _distance(markers[a], markers[b])
            change_m = np.abs(distance - np.nanmedian(distance)) if np.isfinite(distance).any() else np.zeros(1)
            if np.nanmax(change_m) > _MAX_DISTANCE_CHANGE * length:
                worst_row = int(np.nanargmax(change_m))
                change_text = f"their distance changes by {change_m[worst_row] * 1e3:.1f} mm at {time[worst_row]:.2f} s"
                expected = f"{change_text}: are they on one rigid body? Markers along a finger need a body each"
                yield f"markers.bodies.{body}", f"{a}, {b}", expected
    if "tip" in bodies and "base" in bodies:
        base, tip = (max(_marker_motion(markers[name]) for name in bodies[body]) for body in ("base", "tip"))
        if base > tip + _MAX_BASE_MOTION * length:
            expected = f"the base moves by {base * 1e3:.1f} mm and the tip by {tip * 1e3:.1f} mm"
            yield "markers.bodies", "base, tip", f"{expected}: are their markers exchanged?"


def _size_violations(name: str, points: dict[str, Array], length: float) -> Iterator[Violation]:
    """Yields a distance of points, each (T, 3) m, that is so large or small that the unit must be wrong."""
    finite_points = [point[~np.isnan(point).any(axis=1)] for point in points.values()]
    medians = np.array([np.median(point, axis=0) for point in finite_points if len(point)])
    if len(medians) < 2:
        return
    size = float(np.linalg.norm(np.ptp(medians, axis=0)))
    if not _MIN_SIZE_RATIO * length < size < _MAX_SIZE_RATIO * length:
        expected = f"they spread over {size:.3g} m, and the finger is {length:g} m long: is the unit right?"
        yield f"{name}.unit", f"{len(medians)} bodies or markers", expected


def _swap_violations(time: Array, markers: dict[str, Array]) -> Iterator[Violation]:
    """Yields pairs of markers that swap names, and the times: each would jump to the other."""
    for a, b in combinations(markers, 2):
        rows = np.flatnonzero(~np.isnan(markers[a] + markers[b]).any(axis=1))
        p, q, t = markers[a][rows], markers[b][rows], time[rows]
        step_distance = _distance(p[1:], p[:-1]) + _distance(q[1:], q[:-1])
        swapped_distance = _distance(p[1:], q[:-1]) + _distance(q[1:], p[:-1])
        jumps = np.flatnonzero((2 * swapped_distance < step_distance) & (np.diff(t) < _MAX_LOST_TIME))
        if len(jumps):
            times = ", ".join(f"{t[i + 1]:.2f}" for i in jumps[:6]) + (" ..." if len(jumps) > 6 else "")
            yield "markers", f"{a}, {b}", f"swap names at {times} s: exchange their columns there"


def _distance(p: Array, q: Array) -> Array:
    return np.linalg.norm(p - q, axis=-1)


def _marker_motion(p: Array) -> float:
    """Distance of a marker from its median position, 90th percentile, which ignores single outliers."""
    points = p[~np.isnan(p).any(axis=1)]
    return float(np.percentile(_distance(points, np.median(points, axis=0)), 90)) if len(points) else 0.0


def _read_poses(table: Table, config: RecordingConfig) -> dict[str, BodyPose]:
    """Poses by body, in the axes of the recording; NaN where a quaternion is missing or has not unit norm."""
    poses: dict[str, BodyPose] = {}
    for name, pose in config.poses.items():
        p, wxyz = table.columns(pose.position) * LENGTH[pose.unit], table.columns(pose.quaternion)
        is_unit = np.abs(np.linalg.norm(wxyz, axis=1) - 1) < _NORM_TOLERANCE
        R = np.full((len(p), 3, 3), np.nan)
        if is_unit.any():
            R[is_unit] = Rotation.from_quat(np.roll(wxyz[is_unit], -1, axis=1)).as_matrix()
        poses[name] = BodyPose(p, R)
    return poses


def _pose_violations(poses: dict[str, BodyPose], config: RecordingConfig) -> Iterator[Violation]:
    for name, pose in poses.items():
        if np.isnan(pose.R).all():
            yield f"poses.{name}.quaternion", config.poses[name].quaternion, "none of them has unit norm"
    fields = ", ".join(f"poses.{name}" for name in poses)
    yield from _size_violations(fields, {name: pose.p for name, pose in poses.items()}, config.length)


def _note_defects(path: Path, time: Array, markers: dict[str, Array], reference: NDArray[np.bool_]) -> None:
    """Notes markers that are not always seen; `reference` is true in the reference span, (T,)."""
    for name, p in markers.items():
        is_lost = np.any(np.isnan(p), axis=1)
        if is_lost.any():
            first_lost_time = time[np.argmax(is_lost)]
            gap = float(np.diff(np.concatenate((time[:1], time[~is_lost], time[-1:]))).max())  # between seen ones
            reason = f"they are missing, the first at {first_lost_time:.2f} s; the longest gap is {gap:.2f} s"
            note(LEFT_OUT, path, f"{is_lost.sum()} of {len(is_lost)} samples of {name}", "", reason)
        if is_lost[reference].all():
            note(LEFT_OUT, path, f"the reference of {name}", "", "it is not seen in the reference span")


def note_stuck(path: Path, readings: dict[str, Array], others: dict[str, Array]) -> None:
    """Notes readings that seem to be clipped or dead, see `stuck_readings`."""
    for stuck in stuck_readings(readings, others):
        note(READ, path, stuck.name, f"{stuck.value:g}", stuck.question)


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


def _base_markers(config: RecordingConfig) -> list[str]:
    return config.markers.bodies.get("base", []) if config.markers else []


def _frame_violations(config: RecordingConfig) -> Iterator[Violation]:
    if config.frame.origin is None and "base" not in config.poses and not _base_markers(config):
        yield "frame.origin", None, "without it a pose or markers of the body 'base' are needed"


def _recording_frame(
    config: RecordingConfig, markers: dict[str, Array], poses: dict[str, BodyPose], reference: NDArray[np.bool_]
) -> RecordingFrame:
    """Frame B of a description, in the mean over the reference span, where `reference` is true, (T,)."""
    if config.frame.origin is not None:
        origin: Array = np.array(config.frame.origin)
    elif "base" in poses:
        origin = _finite_mean(poses["base"].p[reference])
    else:
        base = [_finite_mean(markers[name][reference]) for name in _base_markers(config)]
        origin = _finite_mean(np.array(base))
    return RecordingFrame(origin, frame_axes(config))


def _finite_mean(p: Array) -> Array:
    """Mean over the finite rows of (T, 3); NaN without finite rows."""
    finite_points = p[~np.isnan(p).any(axis=1)]
    return finite_points.mean(axis=0) if len(finite_points) else np.full(3, np.nan)


def _pressure_unit(described: PressuresConfig) -> float:
    """Unit of the pressure columns, Pa."""
    return described.scale or PRESSURE[described.unit]


def _pressure_violations(
    pressures: Array, described: PressuresConfig, reference: NDArray[np.bool_]
) -> Iterator[Violation]:
    """Yields implausible measured pressures, (T, C) Pa; `reference` is true in the reference span."""
    highest_pressure = float(np.nanmax(np.abs(pressures), initial=0.0))
    if highest_pressure != 0 and not _MIN_PRESSURE < highest_pressure < _MAX_PRESSURE:
        yield "pressures.unit", described.unit, f"the highest is then {highest_pressure:.3g} Pa: is it right?"
    if described.zeroed and not np.isfinite(pressures[reference]).all(axis=1).any():
        yield "pressures.zeroed", True, "no pressure is known in the reference span"
    if described.ambient is None and not described.zeroed:
        remedy = "give `pressures.ambient`, what it has in open air, or `zeroed: true`; if not, `ambient: 0`"
        for column, pressure in zip(described.columns, pressures.T, strict=True):
            yield from absolute_violations(f"pressure in {column}", pressure, reference, remedy)


def absolute_violations(name: str, pressure: Array, reference: NDArray[np.bool_], remedy: str) -> Iterator[Violation]:
    """Yields a pressure, (T,) Pa, that seems measured against vacuum, by its median in the reference span."""
    values = pressure[reference & np.isfinite(pressure)]
    level = float(np.median(values)) if len(values) else 0.0
    if seems_absolute(level, pressure):
        yield name, f"{level / 1e3:.4g} kPa at rest", f"is it measured against vacuum? {remedy}"


def _ambient_pressures(pressures: Array, described: PressuresConfig, reference: NDArray[np.bool_]) -> Array | float:
    """Ambient pressures, Pa, measured by the pressure sensors."""
    if not described.zeroed:
        return (described.ambient or 0.0) * _pressure_unit(described)
    return pressures[reference & np.isfinite(pressures).all(axis=1)].mean(axis=0)


def _read_lengths(table: Table, described: LengthsConfig | None) -> dict[str, Array]:
    """Measured lengths, m, (T,), by wire."""
    if described is None:
        return {}
    lengths = table.columns([wire.column for wire in described.wires.values()])
    lengths = lengths * (described.scale or LENGTH[described.unit])
    return dict(zip(described.wires, lengths.T, strict=True))


def _length_violations(lengths: dict[str, Array], described: LengthsConfig, finger: float) -> Iterator[Violation]:
    """Yields implausible lengths on a finger of a length, m."""
    values = np.array([*lengths.values()])
    longest_length = float(np.nanmax(np.abs(values), initial=0.0))
    if not longest_length < 10 * finger:
        expected = f"the longest is then {longest_length:.3g} m, and the finger {finger:g} m: is it right?"
        yield "lengths.unit or scale", described.unit, expected
    max_change = float(np.nanmax([*map(np.ptp, values)], initial=0.0))
    if max_change != 0 and not max_change > 1e-3 * finger:
        expected = f"no wire then changes by more than {max_change:.3g} m, and the finger is {finger:g} m: is it right?"
        yield "lengths.unit or scale", described.unit, expected


def _read_pulled_lengths(table: Table, config: RecordingConfig) -> dict[str, Array]:
    """Pulled-in lengths of tendons, m, (T,), by tendon."""
    if config.tendons is None:
        return {}
    tendons_config = config.tendons
    windings = table.columns([*tendons_config.columns.values()]), -table.columns([*tendons_config.antagonists.values()])
    pulled_lengths = np.concatenate(windings, axis=1) * tendons_config.scale
    return dict(zip([*tendons_config.columns, *tendons_config.antagonists], pulled_lengths.T, strict=True))


def _tendon_violations(pulled: dict[str, Array], config: RecordingConfig) -> Iterator[Violation]:
    if config.tendons is None:
        return
    motion = float(np.nanmax([*map(np.ptp, pulled.values())], initial=0.0))
    if not 1e-4 * config.length < motion < config.length:
        expected = f"the most that a tendon moves is then {motion:.3g} m, and the finger is {config.length:g} m long"
        yield "tendons.unit", config.tendons.unit, f"{expected}: is it right?"


def _number_in_name(path: Path, pattern: str) -> str | None:
    """Number that a pattern finds in a file's name, as text."""
    match = find(plain_number_pattern(pattern), path.stem)
    return None if match is None else match[1]


def _named_pressure(path: Path, config: RecordingConfig) -> float | None:
    """Commanded pressure, Pa, by a file's name; None if the name has no pressure."""
    for named in config.commanded_pressure:
        if number_text := _number_in_name(path, named.pattern):
            return float(number_text) * PRESSURE[named.unit]
    return None


def _named_load(path: Path, config: RecordingConfig) -> float:
    """Mass at the tip according to a file name, kg; 0 if it gives none."""
    number_text = None if config.load is None else _number_in_name(path, config.load.pattern)
    if config.load is None or number_text is None:
        return 0.0
    return config.load.masses.get(number_text, float(number_text) * _KG_PER_GRAM)


def find_recordings(
    files: Sequence[str], described_as: str | None = None, data: Path | None = None
) -> list[HardwareRecording]:
    """Finds and reads recordings: the files of `recording_paths`, by their descriptions.

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
    """
    folder = data or (Path(os.environ[DATA_FOLDER]) if os.environ.get(DATA_FOLDER) else None)
    if not files:
        raise InputError("recording", "FILE", [], "give at least one file")
    return [_find(file, described_as, folder) for file in files]


def _find(file: str, described_as: str | None, folder: Path | None) -> Path:
    candidates = [Path(file)]
    if folder is not None:
        candidates += [folder / file, *([folder / Path(described_as).stem / file] if described_as else [])]
    path = next((candidate for candidate in candidates if os.path.isfile(candidate) or is_bag_folder(candidate)), None)
    place_text = f"nor below {folder}" if folder else f"and neither --data nor {DATA_FOLDER} names a folder"
    if path is None:
        raise InputError("recording", "FILE", file, f"there is no such file here, {place_text}")
    return path


def _description(path: Path, described_as: str | None) -> RecordingConfig:
    candidates = path.with_suffix(".yaml"), path.with_name("recording.yaml")
    neighbour = next((candidate for candidate in candidates if os.path.isfile(candidate)), None)
    description = neighbour if described_as is None else described_as
    if description is None:
        expected = f"no description: give --as NAME, or put {candidates[0].name} or {candidates[1].name} next to it"
        raise InputError(path, "description", None, expected)
    return load_description(description)
