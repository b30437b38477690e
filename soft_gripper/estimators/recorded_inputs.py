"""Inputs of an estimator from a recording: the readings, and what follows from all samples before each."""

from typing import Any

import numpy as np

from soft_gripper.arrays import Array
from soft_gripper.estimators.free_motion import recorded_lag
from soft_gripper.estimators.zeroing import recorded_zeros


def recorded_inputs(
    function: object, readings: Array, driving: Array, gravity: Array, apparent_gravity: Array | None = None
) -> tuple[Any, ...]:
    """The arguments of an estimator at all samples of a recording, as `ShapeEstimator` gives them one by one.

    Args:
        function: the estimator.
        readings: of its sensors, (T, ..., R).
        driving: torque, (T, ..., D) N m.
        gravity: in B, (T, ..., 3) m/s^2.
        apparent_gravity: gravity less the acceleration of the base, likewise; None: the base is at rest.
    """
    gravity = np.broadcast_to(gravity, (*driving.shape[:-1], 3))
    lag = recorded_lag(function, driving, gravity, gravity if apparent_gravity is None else apparent_gravity)
    zeroed, std = recorded_zeros(function, readings, driving, gravity)
    return zeroed, driving, gravity, *lag, *std
