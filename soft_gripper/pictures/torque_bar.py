"""Limits of the torque colour bar."""

from collections.abc import Iterable

import numpy as np

from soft_gripper.arrays import Array
from soft_gripper.diagrams.recording import Recording

MIN_LIMIT = 5e-3  # N m; smaller torques are noise, and should not fill the bar


def torque_limit(torques: Iterable[Array]) -> float:
    """The limit of a bar that covers all torques, N m; NaN (unknown) torques are ignored."""
    return max([MIN_LIMIT, *(float(np.nanmax(np.abs(torque), initial=0.0)) for torque in torques)])


def recorded_limit(*recordings: Recording) -> float:
    """The limit of a bar that covers the true external torques of all fingers in `recordings`, N m."""
    signals = [item for recording in recordings for item in recording.data.items()]
    return torque_limit(signal.values for name, signal in signals if str(name).endswith(".true_external_torque"))
