"""Shape and driving torque -> load, contact and width."""

from .contact_detector import ContactDetector as ContactDetector
from .force_estimator import ForceEstimator as ForceEstimator
from .gripper_opening import Gripper as Gripper
from .gripper_opening import GripperOpening as GripperOpening
from .object_width import ObjectWidth as ObjectWidth
from .torque_balance import Motion as Motion
from .torque_balance import TorqueBalance as TorqueBalance
