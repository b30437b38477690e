"""Where the bar of torque colours ends."""

from collections.abc import Iterable

import numpy as np

from soft_gripper.arrays import Array
from soft_gripper.diagrams.recording import Recording

MIN_LIMIT = 5e-3  # N m; smaller torques are noise, and are not to fill the bar


def torque_limit(torques: Iterable[Array]) -> float:
    """The end of a bar that holds all torques, N m; what is NaN, not known, is passed over."""
    return max([MIN_LIMIT, *(float(np.nanmax(np.abs(torque), initial=0.0)) for torque in torques)])


def recorded_limit(*recordings: Recording) -> float:
    """The end of a bar that holds the true external torques of all fingers in `recordings`, N m."""
    signals = [item for recording in recordings for item in recording.data.items()]
    return torque_limit(signal.values for name, signal in signals if str(name).endswith(".true_external_torque"))
