"""Gymnasium environments of soft grippers; to import this registers SoftReach-v0, SoftGrasp-v0 and SoftPickPlace-v0."""

from .config import load_environment as load_environment
from .environment import SoftGripperEnv as SoftGripperEnv
