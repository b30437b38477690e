"""Files of a described experiment -> recordings as arrays."""

from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from soft_gripper.arrays import Array
from soft_gripper.diagrams.hardware.c3d_table import read_c3d
from soft_gripper.diagrams.hardware.file_name import load_in_name, pressure_in_name
from soft_gripper.diagrams.hardware.gaps import gaps_of, without_repeats
from soft_gripper.diagrams.hardware.hardware_recording import BodyPose, HardwareRecording
from soft_gripper.diagrams.hardware.marker_checks import check_base_rests, check_exchanged, check_rigid, check_size
from soft_gripper.diagrams.hardware.recording_schema import RecordingConfig
from soft_gripper.diagrams.hardware.table import Table, read_text
from soft_gripper.diagrams.hardware.units import LENGTH, PRESSURE, TIME, factor
from soft_gripper.diagrams.schema.ranges import require
from soft_gripper.errors import InputError

_MOST_PRESSURE = 1e7  # Pa, that a soft body bears
_LEAST_PRESSURE = 10.0  # Pa, that anything is driven with


def read_recording(path: Path, config: RecordingConfig) -> HardwareRecording:
    """Reads a file as its description says.

    Raises:
        InputError: naming file, column or marker, and row or time, if it cannot be what the description says.
    """
    table, repeated = without_repeats(_table(path, config), config.time)
    time = table.columns("time", [config.time])[:, 0] * TIME[config.time_unit]
    markers, raw_poses = _markers(table, config, time), _poses(table, config)
    reference = time <= time[0] + config.reference
    origin, R = _frame(path, config, markers, raw_poses, reference)
    gravity = None if config.gravity is None else np.array(config.gravity) @ R
    placed = {name: (p - origin) @ R for name, p in markers.items()}
    return HardwareRecording(
        name=path.stem,
        config=config,
        time=time,
        markers=placed,
        reference={name: _mean(p[reference]) for name, p in placed.items()},
        poses={name: BodyPose((pose.p - origin) @ R, R.T @ pose.R) for name, pose in raw_poses.items()},
        pressures=_pressures(table, config),
        lengths=_lengths(table, config),
        commanded_pressure=pressure_in_name(path, config.commanded_pressure),
        load_mass=load_in_name(path, config.load),
        load_place=None if config.load_place is None else (config.load_place[0], config.load_place[1]),
        gravity=gravity,
        gaps=gaps_of(table, repeated, time, placed, reference),
    )


def _table(path: Path, config: RecordingConfig) -> Table:
    if path.suffix.lower() != ".c3d":
        return read_text(path, config.header)
    require(config.markers is not None, path, "markers", None, "a C3D file holds markers: describe them")
    assert config.markers is not None
    return read_c3d(path, config.time, config.markers.columns, LENGTH[config.markers.unit])


def _markers(table: Table, config: RecordingConfig, time: Array) -> dict[str, Array]:
    if config.markers is None:
        return {}
    described, unit = config.markers, LENGTH[config.markers.unit]
    markers = {}
    for name in (name for body in described.bodies.values() for name in body):
        columns = [described.columns.format(marker=name, axis=axis) for axis in "xyz"]
        p = table.columns("markers", columns) * unit
        p[np.isnan(p).any(axis=1) | (p == 0).all(axis=1)] = np.nan  # some systems write zeros for what is not seen
        markers[name] = p
    for body, names in described.bodies.items():
        seen = any(np.isfinite(markers[name]).any() for name in names)
        require(seen, table.path, f"markers.bodies.{body}", names, "none of them is ever seen")
    check_size(table.path, "markers", markers, config.length)
    check_exchanged(table.path, time, markers)
    check_rigid(table.path, time, markers, described.bodies, config.length)
    check_base_rests(table.path, markers, described.bodies)
    return markers


def _poses(table: Table, config: RecordingConfig) -> dict[str, BodyPose]:
    """Poses in the axes of the recording."""
    poses = {}
    for name, pose in config.poses.items():
        p = table.columns(f"poses.{name}.position", pose.position) * LENGTH[pose.unit]
        w, x, y, z = table.columns(f"poses.{name}.quaternion", pose.quaternion).T
        norm = np.sqrt(w**2 + x**2 + y**2 + z**2)
        bad = np.flatnonzero(~(np.abs(norm - 1) < 0.01))
        if len(bad) == len(norm):
            raise InputError(table.path, f"poses.{name}.quaternion", pose.quaternion, "none of them has unit norm")
        R = np.full((len(norm), 3, 3), np.nan)
        good = np.setdiff1d(np.arange(len(norm)), bad)
        R[good] = Rotation.from_quat(np.column_stack((x, y, z, w))[good]).as_matrix()
        poses[name] = BodyPose(p, R)
    units = ", ".join(f"poses.{name}" for name in poses)
    check_size(table.path, units, {name: pose.p for name, pose in poses.items()}, config.length)
    return poses


def _frame(
    path: Path, config: RecordingConfig, markers: dict[str, Array], poses: dict[str, BodyPose], reference: Array
) -> tuple[Array, Array]:
    """Origin (3,) m and axes (3, 3) of frame B in the recording's axes; p @ R turns what is measured into B."""
    z = np.array(config.frame.z) / np.linalg.norm(config.frame.z)
    x = np.array(config.frame.x) - np.dot(config.frame.x, z) * z
    x /= np.linalg.norm(x)
    R = np.column_stack((x, np.cross(z, x), z))
    if config.frame.origin is not None:
        return np.array(config.frame.origin), R
    if "base" in poses:
        return _mean(poses["base"].p[reference]), R
    base = config.markers.bodies.get("base", []) if config.markers else []
    expected = "without it a pose or markers of the body 'base' are needed"
    require(len(base) > 0, path, "frame.origin", None, expected)
    return _mean(np.array([_mean(markers[name][reference]) for name in base])), R


def _pressures(table: Table, config: RecordingConfig) -> Array | None:
    if config.pressures is None:
        return None
    described = config.pressures
    unit = factor(table.path, "pressures", described.unit, PRESSURE, described.scale)
    pressures = table.columns("pressures.columns", described.columns) * unit
    most = float(np.nanmax(np.abs(pressures), initial=0.0))
    fine = most == 0 or _LEAST_PRESSURE < most < _MOST_PRESSURE
    require(fine, table.path, "pressures.unit", described.unit, f"the highest is then {most:.3g} Pa: is it right?")
    return pressures


def _lengths(table: Table, config: RecordingConfig) -> dict[str, Array]:
    if config.lengths is None:
        return {}
    described = config.lengths
    unit = factor(table.path, "lengths", described.unit, LENGTH, described.scale)
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


def _mean(p: Array) -> Array:
    """Mean over what is seen of (T, 3), NaN if nothing is."""
    seen = p[~np.isnan(p).any(axis=1)]
    mean: Array = seen.mean(axis=0) if len(seen) else np.full(3, np.nan)
    return mean
