"""FixedBasePose: where the base of a finger stands that nothing moves."""

from pydrake.math import RigidTransform
from pydrake.systems.framework import LeafSystem

from soft_gripper.sensors.base_pose_sensor import AXES, UNITS
from soft_gripper.signals import describe


class FixedBasePose(LeafSystem):
    """Puts out a pose that stays.

    ::

        FixedBasePose ---> X_WB  (12) the matrix [R | p], row after row

    Held in state, which never changes, so that what follows from it is computed once: Drake takes the output of a
    ConstantVectorSource to change with time.
    """

    def __init__(self, X_WB: RigidTransform):
        super().__init__()
        state = self.DeclareDiscreteState(X_WB.GetAsMatrix34().ravel())
        describe(self.DeclareStateOutputPort("X_WB", state), UNITS, **AXES)
