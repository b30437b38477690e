"""Held steps: which samples of a recording belong to the hold at the end of each step of pressure."""

import numpy as np
import xarray as xr

from soft_gripper.arrays import Array
from soft_gripper.diagrams.scenario import Scenario


def held_samples(scenario: Scenario, signal: xr.DataArray) -> Array:
    """The averaged samples of every step, (steps, hold_samples, ...)."""
    period, hold = scenario.sensor.period, scenario.pressure.hold_samples
    ends = (np.arange(scenario.steps) + 1) * scenario.step_duration
    last = np.searchsorted(signal["time"].values, ends + period / 2) - 1
    rows = last[:, None] + np.arange(-hold + 1, 1)
    held: Array = signal.values[rows]
    return held
