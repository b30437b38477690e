"""What follows a set point."""

from .arm_kinematics import movable_joints as movable_joints
from .arm_motion import ArmLimits as ArmLimits
from .pid_controller import PidGains as PidGains
from .pid_controller import SampledPidController as SampledPidController
from .task_phases import QUIET_TIME as QUIET_TIME
from .task_phases import Outcome as Outcome
