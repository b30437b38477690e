"""Scenarios as files of MuJoCo."""

from .folder import export_mjcf as export_mjcf
from .mjcf import to_mjcf as to_mjcf
from .sensed import sensed_fingers as sensed_fingers
