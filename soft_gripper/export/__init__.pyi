"""Scenarios as files of other simulators."""

from .folder import export_mjcf as export_mjcf
from .mjcf import Mjcf as Mjcf
from .mjcf import to_mjcf as to_mjcf
