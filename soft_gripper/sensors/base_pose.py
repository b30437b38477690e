"""BasePoseSensor: the pose of a finger base that an arm moves.

A pose is a vector of 12 numbers, not an abstract RigidTransform, so that it is sampled, logged and replayed like any
other signal. It is a discrete state: Drake makes unrestricted updates before discrete ones, and a pose held in an
abstract ZeroOrderHold would be one sample ahead of the strain.
"""

import numpy as np
from pydrake.common.value import AbstractValue
from pydrake.math import RigidTransform
from pydrake.multibody.tree import BodyIndex
from pydrake.systems.framework import Context, DiscreteValues, LeafSystem

from soft_gripper.signals import XYZ, describe

AXES = {"row": XYZ, "column": ("x_axis", "y_axis", "z_axis", "origin")}
UNITS = ("1", "1", "1", "m")


class BasePoseSensor(LeafSystem):
    """Samples the pose of one body, as the encoders of an arm report it.

    ::

        body_poses ---> BasePoseSensor ---> X_WB  (12) the matrix [R | p], row after row

    `body_poses` are those of a MultibodyPlant, a list of RigidTransforms; `X_WB` is one of them and holds its value
    between samples.
    """

    def __init__(self, body: BodyIndex, period: float):
        """Follows a body of the plant; samples every `period` s, beginning at initialization."""
        super().__init__()
        self._body = body
        self._poses = self.DeclareAbstractInputPort("body_poses", AbstractValue.Make([RigidTransform()]))
        state = self.DeclareDiscreteState(np.eye(3, 4).ravel())
        self.DeclareInitializationDiscreteUpdateEvent(self._sample)
        self.DeclarePeriodicDiscreteUpdateEvent(period, 0.0, self._sample)
        describe(self.DeclareStateOutputPort("X_WB", state), UNITS, **AXES)

    def _sample(self, context: Context, values: DiscreteValues) -> None:
        X_WB = self._poses.Eval(context)[self._body]
        values.set_value(X_WB.GetAsMatrix34().ravel())


class FixedBasePose(LeafSystem):
    """Outputs a constant pose.

    ::

        FixedBasePose ---> X_WB  (12) the matrix [R | p], row after row

    Held in state, which never changes, so that what follows from it is computed once: Drake takes the output of a
    ConstantVectorSource to change with time.
    """

    def __init__(self, X_WB: RigidTransform):
        super().__init__()
        state = self.DeclareDiscreteState(X_WB.GetAsMatrix34().ravel())
        describe(self.DeclareStateOutputPort("X_WB", state), UNITS, **AXES)
