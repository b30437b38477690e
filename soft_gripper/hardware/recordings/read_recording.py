"""Files of a described experiment -> recordings as arrays."""

import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from soft_gripper.arrays import Array
from soft_gripper.errors import InputError
from soft_gripper.files.document import given, require
from soft_gripper.hardware.recordings.body_poses import BodyPose, poses_of
from soft_gripper.hardware.recordings.hardware_recording import HardwareRecording
from soft_gripper.hardware.recordings.markers import markers_of
from soft_gripper.hardware.recordings.schema import (
    LENGTH,
    PRESSURE,
    TIME,
    LoadNameConfig,
    PressureNameConfig,
    RecordingConfig,
)
from soft_gripper.hardware.recordings.table import Table, read_c3d, read_text

_MOST_PRESSURE = 1e7  # Pa, that a soft body bears
_LEAST_PRESSURE = 10.0  # Pa, that anything is driven with


def pressures_of(table: Table, config: RecordingConfig) -> Array | None:
    """Measured pressures, Pa, (T, C); None if none are described.

    Raises:
        InputError: if a column is missing, or the unit cannot be right.
    """
    if config.pressures is None:
        return None
    described = config.pressures
    unit = described.scale or PRESSURE[described.unit]
    pressures = table.columns("pressures.columns", described.columns) * unit
    most = float(np.nanmax(np.abs(pressures), initial=0.0))
    fine = most == 0 or _LEAST_PRESSURE < most < _MOST_PRESSURE
    require(fine, table.path, "pressures.unit", described.unit, f"the highest is then {most:.3g} Pa: is it right?")
    return pressures


def lengths_of(table: Table, config: RecordingConfig) -> dict[str, Array]:
    """Measured lengths, m, (T,), by wire.

    Raises:
        InputError: if a column is missing, or the unit cannot be right.
    """
    if config.lengths is None:
        return {}
    described = config.lengths
    unit = described.scale or LENGTH[described.unit]
    columns = [wire.column for wire in described.wires.values()]
    lengths = table.columns("lengths.wires", columns) * unit
    most = float(np.nanmax(np.abs(lengths), initial=0.0))
    expected = f"the longest is then {most:.3g} m, and the finger {config.length:g} m: is it right?"
    require(most < 10 * config.length, table.path, "lengths.unit or scale", described.unit, expected)
    change = float(np.nanmax(np.ptp(lengths, axis=0), initial=0.0))
    expected = f"no wire then changes by more than {change:.3g} m, and the finger is {config.length:g} m: is it right?"
    fine = change == 0 or change > 1e-3 * config.length
    require(fine, table.path, "lengths.unit or scale", described.unit, expected)
    return dict(zip(described.wires, lengths.T, strict=True))


_FEWEST = 2  # samples, of which anything can be said
_LONGEST_GAP = 60.0  # s, between two rows of one recording


def without_repeats(table: Table, time: str, unit: float) -> tuple[Table, int]:
    """The samples that have a time of their own, and how many were left out; `unit` of the times, s.

    Raises:
        InputError: if time runs backwards, most of it stands still, or rows are so far apart that they are of several
            recordings.
    """
    t = table.columns("time", [time])[:, 0]
    timed = table.kept(np.isfinite(t))
    t = t[np.isfinite(t)]
    require(len(t) >= _FEWEST, table.path, time, len(t), f"needs at least {_FEWEST} samples that have a time")
    back = np.flatnonzero(np.diff(t) < 0)
    if len(back):
        row, value = int(timed.rows[back[0] + 1]), float(t[back[0] + 1])
        expected = f"time runs backwards in row {row}, after {t[back[0]]:g}: split the file there, or sort it"
        raise InputError(table.path, time, value, expected)
    far = np.flatnonzero(np.diff(t) * unit > _LONGEST_GAP)
    if len(far):
        row, value = int(timed.rows[far[0] + 1]), float(t[far[0] + 1])
        expected = f"a gap of more than {_LONGEST_GAP:g} s before row {row}, after {t[far[0]]:g}: split the file there"
        raise InputError(table.path, time, value, expected)
    own = np.concatenate(([True], np.diff(t) > 0))
    row = int(timed.rows[np.argmin(own)])
    expected = f"most rows repeat a time, the first of them row {row}: does the clock count seconds alone?"
    require(own.mean() > 0.5, table.path, time, float(t[np.argmin(own)]), expected)
    return timed.kept(own), len(table.values) - int(own.sum())


def gaps_of(
    table: Table, repeated: int, time: Array, markers: dict[str, Array], reference: NDArray[np.bool_]
) -> tuple[str, ...]:
    """What is missing, in words; `reference` is true in the reference span, (T,)."""
    found = []
    if table.dropped:
        found.append(f"{len(table.dropped)} rows do not parse, the first of them row {table.dropped[0]}")
    if repeated:
        found.append(f"{repeated} rows have no time of their own")
    for name, p in markers.items():
        lost = np.any(np.isnan(p), axis=1)
        if lost.any():
            first, longest = time[np.argmax(lost)], _longest(time, lost)
            text = f"{name}: {lost.sum()} of {len(lost)} samples are missing, the first at {first:.2f} s"
            found.append(f"{text}; the longest gap is {longest:.2f} s")
        if lost[reference].all():
            found.append(f"{name}: not seen in the reference span")
    return tuple(found)


def _longest(time: Array, lost: NDArray[np.bool_]) -> float:
    """The longest time between two samples that are seen, with lost ones between them, s."""
    seen = np.concatenate((time[:1], time[~lost], time[-1:]))
    return float(np.diff(seen).max())


_GRAM = 1e-3  # kg


def pressure_in_name(path: Path, ways: list[PressureNameConfig]) -> float | None:
    """The commanded pressure in a file's name, Pa; None if there is none.

    Raises:
        InputError: if what is found is no number.
    """
    for way in ways:
        if found := re.search(way.pattern, path.stem):
            return _number(path, "commanded_pressure", found[1]) * PRESSURE[way.unit]
    return None


def load_in_name(path: Path, load: LoadNameConfig | None) -> float:
    """The mass that hangs on the tip by a file's name, kg; 0 if it names none.

    Raises:
        InputError: if what is found is no number.
    """
    found = re.search(load.pattern, path.stem) if load else None
    if load is None or found is None:
        return 0.0
    return load.masses.get(found[1], _number(path, "load", found[1]) * _GRAM)


def _number(path: Path, field: str, text: str) -> float:
    try:
        return float(text)
    except ValueError:
        raise InputError(path, f"{field}.pattern", text, "is no number; let the group match digits alone") from None


@dataclass(frozen=True)
class RecordingFrame:
    """Frame B: its origin (3,) m and, as columns, its axes (3, 3), in the axes of the recording."""

    origin: Array
    R: Array

    def placed(self, p: Array) -> Array:
        """Points (..., 3) m in B."""
        return (p - self.origin) @ self.R

    def posed(self, pose: BodyPose) -> BodyPose:
        """A pose in B."""
        return BodyPose(self.placed(pose.p), self.R.T @ pose.R)


def frame_of(
    path: Path,
    config: RecordingConfig,
    markers: dict[str, Array],
    poses: dict[str, BodyPose],
    reference: NDArray[np.bool_],
) -> RecordingFrame:
    """Frame B as it is described; `reference` is true in the reference span, (T,).

    Raises:
        InputError: if its origin is neither given nor measured.
    """
    z = np.array(config.frame.z) / np.linalg.norm(config.frame.z)
    x = np.array(config.frame.x) - np.dot(config.frame.x, z) * z
    x /= np.linalg.norm(x)
    R = np.column_stack((x, np.cross(z, x), z))
    if config.frame.origin is not None:
        return RecordingFrame(np.array(config.frame.origin), R)
    if "base" in poses:
        return RecordingFrame(seen_mean(poses["base"].p[reference]), R)
    base = config.markers.bodies.get("base", []) if config.markers else []
    expected = "without it a pose or markers of the body 'base' are needed"
    require(len(base) > 0, path, "frame.origin", None, expected)
    return RecordingFrame(seen_mean(np.array([seen_mean(markers[name][reference]) for name in base])), R)


def seen_mean(p: Array) -> Array:
    """Mean over what is seen of (T, 3), NaN if nothing is."""
    seen = p[~np.isnan(p).any(axis=1)]
    mean: Array = seen.mean(axis=0) if len(seen) else np.full(3, np.nan)
    return mean


def read_recording(path: Path, config: RecordingConfig) -> HardwareRecording:
    """Reads a file as its description says.

    Raises:
        InputError: naming file, column or marker, and row or time, if it cannot be what the description says.
    """
    table, repeated = without_repeats(_table(path, config), config.time, TIME[config.time_unit])
    time = table.columns("time", [config.time])[:, 0] * TIME[config.time_unit]
    reference = time <= time[0] + config.reference
    markers, poses = markers_of(table, config, time), poses_of(table, config)
    B = frame_of(path, config, markers, poses, reference)
    placed = {name: B.placed(p) for name, p in markers.items()}
    return HardwareRecording(
        name=path.stem,
        config=config,
        time=time,
        markers=placed,
        reference={name: seen_mean(p[reference]) for name, p in placed.items()},
        poses={name: B.posed(pose) for name, pose in poses.items()},
        pressures=pressures_of(table, config),
        lengths=lengths_of(table, config),
        commanded_pressure=pressure_in_name(path, config.commanded_pressure),
        load_mass=load_in_name(path, config.load),
        load_place=None if config.load_place is None else (config.load_place[0], config.load_place[1]),
        gravity=None if config.gravity is None else np.array(config.gravity) @ B.R,
        gaps=gaps_of(table, repeated, time, placed, reference),
    )


def _table(path: Path, config: RecordingConfig) -> Table:
    if path.suffix.lower() != ".c3d":
        return read_text(path, config.header)
    markers = given(config.markers, path, "markers", "a C3D file holds markers: describe them")
    return read_c3d(path, config.time, markers.columns, LENGTH[markers.unit])
