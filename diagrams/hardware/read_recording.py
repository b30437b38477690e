"""Files of a described experiment -> recordings as arrays."""

from pathlib import Path

import numpy as np

from soft_gripper.diagrams.hardware.body_poses import poses_of
from soft_gripper.diagrams.hardware.c3d_table import read_c3d
from soft_gripper.diagrams.hardware.channels import lengths_of, pressures_of
from soft_gripper.diagrams.hardware.file_name import load_in_name, pressure_in_name
from soft_gripper.diagrams.hardware.gaps import gaps_of, without_repeats
from soft_gripper.diagrams.hardware.hardware_recording import HardwareRecording
from soft_gripper.diagrams.hardware.marker_points import markers_of
from soft_gripper.diagrams.hardware.recording_frame import frame_of, seen_mean
from soft_gripper.diagrams.hardware.recording_schema import RecordingConfig
from soft_gripper.diagrams.hardware.table import Table, read_text
from soft_gripper.diagrams.hardware.units import LENGTH, TIME
from soft_gripper.diagrams.schema.ranges import require


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
    require(config.markers is not None, path, "markers", None, "a C3D file holds markers: describe them")
    assert config.markers is not None
    return read_c3d(path, config.time, config.markers.columns, LENGTH[config.markers.unit])
