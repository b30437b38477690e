"""Control of the grip, of the arm, and of tasks."""

from .arm_motion import ArmLimits as ArmLimits
from .arm_motion import movable_joints as movable_joints
from .pid_controller import PidGains as PidGains
from .task import QUIET_TIME as QUIET_TIME
from .task import Outcome as Outcome
