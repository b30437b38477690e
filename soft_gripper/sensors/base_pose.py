"""BasePoseSensor: the pose of a finger base that an arm moves.

A pose is a vector of 12 numbers, not an abstract RigidTransform, so that it is sampled, logged and replayed like any
other signal.
"""

import numpy as np
from pydrake.common.value import AbstractValue
from pydrake.math import RigidTransform
from pydrake.multibody.tree import BodyIndex

from soft_gripper.array_block import ArrayBlock
from soft_gripper.signals import XYZ

AXES = {"row": XYZ, "column": ("x_axis", "y_axis", "z_axis", "origin")}
UNITS = ("1", "1", "1", "m")


class BasePoseSensor(ArrayBlock):
    """Samples the pose of one body, as the encoders of an arm report it.

    ::

        body_poses ---> BasePoseSensor ---> X_WB  (12) the matrix [R | p], row after row

    `body_poses` are those of a MultibodyPlant, a list of RigidTransforms; `X_WB` is one of them and holds its value
    between samples.
    """

    def __init__(self, body: BodyIndex, period: float):
        """Follows a body of the plant; samples every `period` s, beginning at initialization."""
        super().__init__(period)
        self.body = body
        self.take_value("body_poses", AbstractValue.Make([RigidTransform()]))
        self.derive("pose", lambda poses: poses[body].GetAsMatrix34().ravel(), "body_poses")
        self.sample("sampled", "pose", np.eye(3, 4).ravel())
        self.put_out("X_WB", lambda pose: pose, "sampled", unit=UNITS, **AXES)


class FixedBasePose(ArrayBlock):
    """Outputs a constant pose.

    ::

        FixedBasePose ---> X_WB  (12) the matrix [R | p], row after row
    """

    def __init__(self, X_WB: RigidTransform):
        super().__init__()
        self.constant("pose", X_WB.GetAsMatrix34().ravel())
        self.put_out("X_WB", lambda pose: pose, "pose", unit=UNITS, **AXES)
