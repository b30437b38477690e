"""Fingers and arms on hardware: recordings read, replayed, identified and calibrated."""

from .free_bending import FreeBending as FreeBending
from .free_bending import calibrate as calibrate
from .identification.identified_finger import identify as identify
from .identification.identified_finger import identify_figure as identify_figure
from .identification.identified_finger import read_finger as read_finger
from .identification.simulated_motion import MeasuredMotion as MeasuredMotion
from .identification.simulated_motion import Setup as Setup
from .identification.simulated_motion import measured_motion as measured_motion
from .identification.simulated_motion import simulated_markers as simulated_markers
from .recordings import find_recordings as find_recordings
