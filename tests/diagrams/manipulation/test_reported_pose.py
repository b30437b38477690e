"""The reported pose of an object: the true one, shifted along the table and turned about the vertical."""

import numpy as np
import pytest
from pydrake.common.schema import Transform
from pydrake.math import RigidTransform, RollPitchYaw

from soft_gripper.diagrams.task_plan import reported_pose
from soft_gripper.scenario.schema import ModelConfig, PoseErrorConfig, TaskConfig

X_WO = RigidTransform(RollPitchYaw(0.3, -0.2, 0.5), [0.4, -0.1, 0.03])
MODELS = [ModelConfig("table"), ModelConfig("box", X_PC=Transform(X_WO), free=True)]


def test_an_error_shifts_and_turns_it_on_the_table():
    found = reported_pose(TaskConfig("box", pose_error=PoseErrorConfig(0.003, -0.002, 0.1)), MODELS)
    np.testing.assert_allclose(found.translation(), [0.403, -0.102, 0.03], atol=1e-12)
    turn = (found.rotation() @ X_WO.rotation().inverse()).ToAngleAxis()
    assert turn.angle() * turn.axis()[2] == pytest.approx(0.1)
    np.testing.assert_allclose(turn.axis()[:2], 0, atol=1e-9)
