"""FingertipDistance: the poses of two fingertips -> the distance between them."""

import numpy as np
from pydrake.math import RigidTransform
from pydrake.systems.framework import BasicVector, Context, LeafSystem

from soft_gripper.arrays import Array


def fingertip_distance(first_tip: Array, second_tip: Array, X_B1B2: RigidTransform) -> Array:
    """Distance between fingertips given as (..., 3) planar poses x, z, heading, each in its own B; m, (...).

    It is negative when the tips have passed each other, seen along the line between the bases.
    """
    R, p = X_B1B2.rotation().matrix(), X_B1B2.translation()
    first = first_tip[..., :1] * [1.0, 0.0, 0.0] + first_tip[..., 1:2] * [0.0, 0.0, 1.0]
    second = second_tip[..., :1] * R[:, 0] + second_tip[..., 1:2] * R[:, 2] + p
    between = second - first
    return np.copysign(np.linalg.norm(between, axis=-1), between @ p)


class FingertipDistance(LeafSystem):
    """Measures how far the tips of two fingers on one palm are apart.

    first_tip_pose (3) x, z, heading ----> +-------------------+
                                           | FingertipDistance | ---> distance  (1) m
    second_tip_pose (3) x, z, heading ---> +-------------------+

    Tips are points on the axes of the fingers. Each pose is planar in the base frame of its finger; where the
    bases stand to each other is part of the gripper and does not change.
    """

    def __init__(self, X_B1B2: RigidTransform):
        """`X_B1B2` is the pose of the second finger's base in the first's."""
        super().__init__()
        self._X_B1B2 = X_B1B2
        self._first = self.DeclareVectorInputPort("first_tip_pose", 3)
        self._second = self.DeclareVectorInputPort("second_tip_pose", 3)
        self.DeclareVectorOutputPort("distance", 1, self._calc_distance, {self.all_input_ports_ticket()})

    def _calc_distance(self, context: Context, output: BasicVector) -> None:
        tips = self._first.Eval(context), self._second.Eval(context)
        output.SetFromVector([fingertip_distance(*tips, self._X_B1B2)])
