"""Fingers and arms on hardware: recordings read, replayed, identified and calibrated."""

from .calibration import calibrate_recordings as calibrate_recordings
from .identification.figure import identify_figure as identify_figure
from .identification.finger_file import read_finger as read_finger
from .identification.finger_file import with_finger as with_finger
from .identification.identification import Identified as Identified
from .identification.identification import identify as identify
from .identification.measured_motion import MeasuredMotion as MeasuredMotion
from .identification.measured_motion import measured_motion as measured_motion
from .identification.simulated_motion import Setup as Setup
from .identification.simulated_motion import simulated_markers as simulated_markers
from .recordings.find_recordings import find_recordings as find_recordings
from .recordings.hardware_recording import HardwareRecording as HardwareRecording
