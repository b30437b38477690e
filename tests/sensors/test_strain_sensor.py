"""StrainSensor: sensors of strain along the two sides or any paths, and no others."""

import pytest

from soft_gripper.errors import InputError
from soft_gripper.sensors.link_sensors import CurvatureSensors, OrientationSensors
from soft_gripper.sensors.strain_sensor import StrainSensor


@pytest.mark.parametrize("kind", [CurvatureSensors, OrientationSensors])
def test_sensors_of_something_else_are_refused(shipped_finger, kind):
    layout = kind(shipped_finger, 2)
    with pytest.raises(InputError, match=f"StrainSensor: layout = '{layout.quantity}': give sensors of strain"):
        StrainSensor(layout, 0.01)
