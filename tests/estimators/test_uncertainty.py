"""What is assumed to be uncertain: numbers that are none are refused, by name."""

from dataclasses import fields

import pytest

from soft_gripper.errors import InputError
from soft_gripper.estimators.uncertainty import Uncertainty

NAMES = [field.name for field in fields(Uncertainty)]


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("value", [-1e-9, float("nan"), float("inf")])
def test_what_is_no_standard_deviation(name, value):
    with pytest.raises(InputError) as caught:
        Uncertainty(**{name: value})
    assert str(caught.value).startswith(f"uncertainty: {name} = {value!r}: ")


@pytest.mark.parametrize("name", ["angle", "bend_per_pressure", "pressure"])
def test_finger_and_pressure_may_be_certain(name):
    assert getattr(Uncertainty(**{name: 0.0}), name) == 0


@pytest.mark.parametrize("name", ["reading", "load_pressure"])
def test_readings_and_loads_may_not(name):
    with pytest.raises(InputError, match=f"uncertainty: {name} = 0.0"):
        Uncertainty(**{name: 0.0})
