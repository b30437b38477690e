"""A user's own estimator wherever one of this project is named: what is none is refused."""

import pytest

from soft_gripper.errors import InputError
from soft_gripper.estimators.named_estimators import estimator_function
from soft_gripper.estimators.uncertainty import Uncertainty
from soft_gripper.sensors.sensor_layout import SensorLayout


@pytest.mark.parametrize("name", ["gausian", "own_blocks:nothing", "own_blocks:mean_bend"])
def test_what_is_no_estimator_of_many_samples_is_refused(name, shipped_finger):
    with pytest.raises(InputError) as error:
        estimator_function(name, SensorLayout(shipped_finger, 2), Uncertainty())
    assert (error.value.field, error.value.value) == ("--estimator", name)
