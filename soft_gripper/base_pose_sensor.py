"""BasePoseSensor: where the base of a finger is while an arm moves it."""

import numpy as np
from pydrake.common.value import AbstractValue
from pydrake.math import RigidTransform, RotationMatrix
from pydrake.multibody.tree import BodyIndex
from pydrake.systems.framework import Context, DiscreteValues, LeafSystem


class BasePoseSensor(LeafSystem):
    """Samples the pose of one body, as the encoders of an arm tell it.

                   +----------------+
    body_poses --> | BasePoseSensor | --> X_WB
                   +----------------+

    `body_poses` are those of a MultibodyPlant, a list of RigidTransforms; `X_WB` is one of them, a RigidTransform
    that holds its value between samples.
    """

    def __init__(self, body: BodyIndex, period: float):
        """Follows a body of the plant; samples every `period` s, beginning at initialization."""
        super().__init__()
        self._body = body
        self._poses = self.DeclareAbstractInputPort("body_poses", AbstractValue.Make([RigidTransform()]))
        state = self.DeclareDiscreteState(np.eye(3, 4).ravel())  # the matrix [R | p], row after row
        self.DeclareInitializationDiscreteUpdateEvent(self._sample)
        self.DeclarePeriodicDiscreteUpdateEvent(period, 0.0, self._sample)
        self.DeclareAbstractOutputPort(
            "X_WB",
            lambda: AbstractValue.Make(RigidTransform()),
            self._calc_pose,
            {self.discrete_state_ticket(state)},
        )

    def _sample(self, context: Context, values: DiscreteValues) -> None:
        X_WB = self._poses.Eval(context)[self._body]
        values.set_value(X_WB.GetAsMatrix34().ravel())

    def _calc_pose(self, context: Context, value: AbstractValue) -> None:
        matrix = context.get_discrete_state_vector().value().reshape(3, 4)
        value.set_value(RigidTransform(RotationMatrix(matrix[:, :3]), matrix[:, 3]))
