"""Load: shape and driving torque -> external torque, contact and object width."""

from .contact_detector import ContactDetector as ContactDetector
from .force_estimator import Motion as Motion
from .force_estimator import TorqueBalance as TorqueBalance
from .opening import Gripper as Gripper
from .opening import GripperOpening as GripperOpening
from .opening import ObjectWidth as ObjectWidth
