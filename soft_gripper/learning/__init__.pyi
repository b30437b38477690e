"""Gymnasium environments of soft grippers; to import this registers SoftReach-v0, SoftGrasp-v0 and SoftPickPlace-v0."""

from .environment import SoftGripperEnv as SoftGripperEnv
from .schema.environment_file import environment_names as environment_names
from .schema.environment_file import load_environment as load_environment
