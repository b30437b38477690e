"""Load: shape and driving torque -> external torque, contact and object width."""

from .opening import Gripper as Gripper
from .opening import GripperOpening as GripperOpening
