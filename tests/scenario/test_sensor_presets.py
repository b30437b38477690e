"""Errors of sensors in a scenario: presets, what overrides them, and what there cannot be."""

from dataclasses import replace

import numpy as np
import pytest

from soft_gripper.errors import InputError
from soft_gripper.estimators.uncertainty import uncertainty_of
from soft_gripper.scenario.schema import (
    DeadSensorConfig,
    EstimatorConfig,
    SensorConfig,
    StrainErrorsConfig,
    UncertaintyConfig,
)
from soft_gripper.scenario.sensor_presets import strain_errors, uncertainty
from soft_gripper.sensors.pressure_errors import PressureErrors
from soft_gripper.sensors.strain_errors import FULL_SCALE, StrainErrors, disturb


def test_what_is_given_overrides_the_preset():
    """A zero too."""
    errors = strain_errors(SensorConfig(errors=StrainErrorsConfig(preset="realistic", noise=0.0, delay=1)))
    assert errors == StrainErrors(hysteresis=0.01, gain_error=0.01, drift=0.001, noise=0.0, delay=1)


def test_textile_sensors_have_the_published_loop_and_wander():
    """A loop of 12 % of the stroke; in an hour a tenth of a stroke of full scale."""
    errors = strain_errors(SensorConfig(errors=StrainErrorsConfig(preset="textile")))
    up = 1 + 0.1 * np.linspace(0, 1, 201)
    ratios = np.concatenate([up, up[-2::-1], up[1:]])[:, None]
    without = replace(errors, gain_error=0.0, drift=0.0, noise=0.0)
    found = disturb(without, ratios, 0.01, np.random.default_rng(1))[:, 0]
    assert (found[200:401][::-1] - found[400:]).max() == pytest.approx(0.12 * 0.1, rel=0.01)
    assert 60 * errors.drift == pytest.approx(0.10 * FULL_SCALE, rel=0.05)


@pytest.mark.parametrize(
    ("one_sided", "dead", "expected"),
    [
        (False, [("inner", 0), ("outer", 1)], (0, 4)),
        (True, [("outer", 2)], (2,)),
    ],
)
def test_dead_sensors_are_counted_as_readings(one_sided, dead, expected):
    errors = StrainErrorsConfig(dead=[DeadSensorConfig(*sensor) for sensor in dead])
    assert strain_errors(SensorConfig(sections=3, one_sided=one_sided, errors=errors)).dead == expected


def test_a_preset_that_python_asks_for_is_known():
    with pytest.raises(InputError) as caught:
        strain_errors(SensorConfig(errors=StrainErrorsConfig(preset="perfect")))
    assert caught.value.field == "preset"


def test_uncertainty_follows_from_the_errors_unless_it_is_given():
    sensor = SensorConfig(errors=StrainErrorsConfig(noise=3e-3), pressure_errors=PressureErrors(offset=200.0))
    found = uncertainty(EstimatorConfig(), sensor)
    assert found == uncertainty_of(strain_errors(sensor), sensor.pressure_errors)
    assert (found.reading, found.pressure) == (pytest.approx(3e-3, rel=1e-2), 200.0)
    given = EstimatorConfig(uncertainty=UncertaintyConfig(pressure=0.0, friction=0.45))
    assert uncertainty(given, sensor) == replace(found, pressure=0.0, friction=0.45)
