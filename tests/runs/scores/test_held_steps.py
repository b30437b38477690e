"""Held steps: just the samples at the end of each step, for any sensor period."""

import numpy as np
import pytest
import xarray as xr

from soft_gripper.diagrams.recording import Recording
from soft_gripper.runs.scores.poses import held_samples
from soft_gripper.scenario.schema import PressureConfig, Scenario, SensorConfig

STEPS = 5


@pytest.fixture(params=[(0.01, 1.0, 100), (0.003, 0.1, 7), (1 / 30, 0.2, 1), (0.01, 0.0, 20)], ids=str)
def scenario(request: pytest.FixtureRequest) -> Scenario:
    """Steps of (sensor period, settling time, held samples), of which none is exact in binary."""
    period, settle, hold_samples = request.param
    pressure = PressureConfig(steps={"all": [0.0] * STEPS}, settle=settle, hold_samples=hold_samples)
    return Scenario(pressure=pressure, sensor=SensorConfig(period=period))


@pytest.fixture
def recording(scenario: Scenario) -> Recording:
    """A signal `sampled_at` that says when it was sampled: a log at t still finds the sample before t."""
    period = scenario.sensor.period
    time = np.arange(round(scenario.duration / period) + 1) * period
    return Recording(xr.Dataset({"sampled_at": ("time", time - period)}, {"time": time}))


def test_samples_were_taken_in_their_step_after_it_settled(scenario: Scenario, recording: Recording) -> None:
    """To the nearest sample, where settling is no whole number of periods."""
    period, rounding = scenario.sensor.period, 1e-9
    nearest = period / 2 + rounding
    for step, held in enumerate(held_samples(scenario, recording, "sampled_at")):
        begin, end = step * scenario.step_duration, (step + 1) * scenario.step_duration
        assert held[0] >= begin + scenario.pressure.settle - nearest
        assert begin - rounding <= held[0]
        assert end - period - nearest <= held[-1] < end - rounding
