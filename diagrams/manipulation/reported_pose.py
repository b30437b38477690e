"""Where the object of a task is reported to be, which is all that is known of it."""

from collections.abc import Sequence

import numpy as np
from pydrake.math import RigidTransform, RotationMatrix

from soft_gripper.diagrams.schema.scenario import ModelConfig, TaskConfig


def reported_pose(task: TaskConfig, models: Sequence[ModelConfig]) -> RigidTransform:
    """Reported pose of the first link of the task's object in the world: the true one and `pose_error`."""
    (X_WO,) = (model.X_PC.GetDeterministicValue() for model in models if model.name == task.object)
    error = task.pose_error
    shift = np.array([error.x, error.y, 0.0])
    turned = RotationMatrix.MakeZRotation(error.yaw) @ X_WO.rotation()
    return RigidTransform(turned, X_WO.translation() + shift)
