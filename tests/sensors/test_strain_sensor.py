"""StrainSensor: sensors of strain along the two sides or any paths, and no others."""

import pytest

from soft_gripper.errors import InputError
from soft_gripper.sensors.link_sensors import CurvatureSensors, OrientationSensors
from soft_gripper.sensors.path_sensors import PathSensors, named_paths
from soft_gripper.sensors.sensor_layout import SensorLayout
from soft_gripper.sensors.strain_sensor import StrainSensor


def sides(finger):
    return SensorLayout(finger, 2)


def four_faces(finger):
    return PathSensors(finger, 2, paths=named_paths("four_faces", finger))


@pytest.mark.parametrize("sensors", [sides, four_faces])
def test_puts_out_strain(shipped_finger, sensors):
    layout = sensors(shipped_finger)
    block = StrainSensor(layout, 0.01)
    assert {name: block.GetOutputPort(name).size() for name in block.outputs} == {
        "extension_ratio": layout.readings,
        "strain": layout.readings,
    }


@pytest.mark.parametrize("kind", [CurvatureSensors, OrientationSensors])
def test_sensors_of_something_else_are_refused(shipped_finger, kind):
    layout = kind(shipped_finger, 2)
    with pytest.raises(InputError, match=f"StrainSensor: layout = '{layout.quantity}': give sensors of strain"):
        StrainSensor(layout, 0.01)
