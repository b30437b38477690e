"""Poses of rigid bodies in a recording.

Headings have no sign: motion capture now and then takes a body with symmetric markers to be turned by half a turn.
"""

from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from soft_gripper.arrays import Array
from soft_gripper.errors import InputError
from soft_gripper.hardware.recordings.markers import check_size
from soft_gripper.hardware.recordings.schema import LENGTH, RecordingConfig
from soft_gripper.hardware.recordings.table import Table

_NORM = 0.01  # by which that of a quaternion may differ from 1


@dataclass(frozen=True)
class BodyPose:
    """The pose of a rigid body over time."""

    p: Array  # (T, 3) m
    R: Array  # (T, 3, 3), its axes


def poses_of(table: Table, config: RecordingConfig) -> dict[str, BodyPose]:
    """Poses by body, in the axes of the recording; NaN where a quaternion is missing or has not unit norm.

    Raises:
        InputError: if a column is missing, no quaternion is one, or the unit cannot be right.
    """
    poses: dict[str, BodyPose] = {}
    for name, pose in config.poses.items():
        p = table.columns(f"poses.{name}.position", pose.position) * LENGTH[pose.unit]
        wxyz = table.columns(f"poses.{name}.quaternion", pose.quaternion)
        good = np.abs(np.linalg.norm(wxyz, axis=1) - 1) < _NORM
        if not good.any():
            raise InputError(table.path, f"poses.{name}.quaternion", pose.quaternion, "none of them has unit norm")
        R = np.full((len(p), 3, 3), np.nan)
        R[good] = Rotation.from_quat(np.roll(wxyz[good], -1, axis=1)).as_matrix()
        poses[name] = BodyPose(p, R)
    fields = ", ".join(f"poses.{name}" for name in poses)
    check_size(table.path, fields, {name: pose.p for name, pose in poses.items()}, config.length)
    return poses
