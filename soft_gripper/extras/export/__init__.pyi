"""Scenarios as files of other simulators."""

from .folder import export_mjcf as export_mjcf
from .folder import export_sdf as export_sdf
from .mjcf import Mjcf as Mjcf
from .mjcf import to_mjcf as to_mjcf
from .sdf import Sdf as Sdf
from .sdf import to_sdf as to_sdf
from .sensed import SensedFinger as SensedFinger
from .sensed import sensed_fingers as sensed_fingers
