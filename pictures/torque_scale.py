"""Where a scale of torque colours ends."""

import numpy as np
from soft_gripper.diagrams.recording import Recording

from soft_gripper.arrays import Array

LEAST = 5e-3  # N m; smaller torques are noise, and are not to fill a scale


def scale_limit(*torques: Array) -> float:
    """The end of a scale that holds all torques, N m; one that is NaN, not known, is passed over."""
    return max(LEAST, *(float(np.nanmax(np.abs(torque), initial=0.0)) for torque in torques))


def recorded_limit(*recordings: Recording) -> float:
    """The end of a scale that holds the true external torques of all fingers in `recordings`, N m."""
    signals = [item for recording in recordings for item in recording.data.items()]
    return scale_limit(*(signal.values for name, signal in signals if str(name).endswith(".true_external_torque")))
