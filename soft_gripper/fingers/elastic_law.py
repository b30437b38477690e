"""What an elastic law of the user's adds to the linear springs of the chain."""

from soft_gripper.fingers.finger import Finger
from soft_gripper.piecewise_linear import PiecewiseLinear
from soft_gripper.piecewise_linear_block import PiecewiseLinearBlock


def elastic_law_block(finger: Finger) -> PiecewiseLinearBlock:
    """Joint angles (N) rad -> torque (N) N m that turns the springs into the law: stiffness * q - law(q)."""
    law = finger.joint_law
    return PiecewiseLinearBlock(PiecewiseLinear(law.x, finger.stiffness[:, None] * law.x - law.y))
