"""The finger's frame B in the axes of a recording."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from soft_gripper.arrays import Array
from soft_gripper.diagrams.hardware.body_poses import BodyPose
from soft_gripper.diagrams.hardware.recording_schema import RecordingConfig
from soft_gripper.diagrams.schema.ranges import require


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
