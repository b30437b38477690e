"""What is uncertain because of the sensors: as much as they err, and what a gain makes of a bend."""

import numpy as np
import pytest

from soft_gripper.estimators.uncertainty import Uncertainty, uncertainty_of
from soft_gripper.sensors.measurement import LinearReadings
from soft_gripper.sensors.pressure_errors import PressureErrors
from soft_gripper.sensors.strain_errors import StrainErrors


@pytest.mark.parametrize(
    ("errors", "field", "expected"),
    [
        ({"noise": 3e-3, "low_frequency_noise": 4e-3}, "reading", 5e-3),
        ({"quantization": 0.12**0.5}, "reading", 0.1),
        ({"gain_error": 0.03, "hysteresis": 0.04}, "gain", 0.05),
        ({"creep": 0.1}, "gain", 0.1),
        ({"offset": 2e-3}, "offset", 2e-3),
        ({"drift": 6e-3}, "drift", 6e-3 / 60**0.5),
    ],
)
def test_strain_errors_are_added_as_variances(errors, field, expected):
    found, usual = uncertainty_of(StrainErrors(**errors)), Uncertainty()
    assert getattr(found, field) == pytest.approx(expected, rel=1e-3)
    others = set(vars(usual)) - {field}
    assert {name: getattr(found, name) for name in others} == {name: getattr(usual, name) for name in others}


def test_pressure_errors_and_the_finger():
    found = uncertainty_of(None, PressureErrors(gain_error=0.06, offset=300.0, noise=400.0), 0.08)
    assert (found.pressure, found.bend_per_pressure) == (500.0, pytest.approx(0.1, rel=2e-3))


def test_a_share_of_a_bend_adds_its_variance():
    bends = LinearReadings(np.array([0.0, -0.5]), np.array([1e-4, 1e-4])).uncertain_by(0.04)
    np.testing.assert_allclose(bends.variance, [1e-4, 5e-4])
