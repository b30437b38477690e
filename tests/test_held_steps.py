"""Held steps: just the samples at the end of each step, for any sensor period."""

import numpy as np
import pytest
import xarray as xr

from soft_gripper.diagrams.scenario import PressureConfig, Scenario, SensorConfig
from soft_gripper.evaluation.held_steps import held_samples

STEPS = 5


@pytest.fixture(params=[(0.01, 1.0, 100), (0.003, 0.1, 7), (1 / 30, 0.2, 1), (0.01, 0.0, 20)], ids=str)
def scenario(request: pytest.FixtureRequest) -> Scenario:
    """Steps of (sensor period, settling time, held samples), of which none is exact in binary."""
    period, settle, hold_samples = request.param
    pressure = PressureConfig(steps={"all": [0.0] * STEPS}, settle=settle, hold_samples=hold_samples)
    return Scenario(pressure=pressure, sensor=SensorConfig(period=period))


@pytest.fixture
def clock(scenario: Scenario) -> xr.DataArray:
    """A sampled signal that tells when it was sampled: a log at t still finds the sample before t."""
    period = scenario.sensor.period
    time = np.arange(round(scenario.duration / period) + 1) * period
    return xr.DataArray(time - period, {"time": time}, ["time"])


def test_holds_as_many_samples_as_asked_for(scenario: Scenario, clock: xr.DataArray) -> None:
    assert held_samples(scenario, clock).shape == (STEPS, scenario.pressure.hold_samples)


def test_samples_are_one_period_apart(scenario: Scenario, clock: xr.DataArray) -> None:
    held = held_samples(scenario, clock)
    np.testing.assert_allclose(np.diff(held, axis=1), scenario.sensor.period)


def test_samples_were_taken_in_their_step_after_it_settled(scenario: Scenario, clock: xr.DataArray) -> None:
    """To the nearest sample, where settling is no whole number of periods."""
    period, rounding = scenario.sensor.period, 1e-9
    nearest = period / 2 + rounding
    for step, held in enumerate(held_samples(scenario, clock)):
        begin, end = step * scenario.step_duration, (step + 1) * scenario.step_duration
        assert held[0] >= begin + scenario.pressure.settle - nearest
        assert begin - rounding <= held[0]
        assert end - period - nearest <= held[-1] < end - rounding


def test_keeps_the_axes_of_a_signal(scenario: Scenario, clock: xr.DataArray) -> None:
    factors = xr.DataArray(np.arange(6.0).reshape(2, 3), dims=["path", "section"])
    held = held_samples(scenario, clock * factors)
    np.testing.assert_array_equal(held, held_samples(scenario, clock)[..., None, None] * factors.values)
