"""The sensors of the evaluations of contact."""

from soft_gripper.extras.paper.forces import LAYOUTS, describe_borders
from soft_gripper.fingers.finger import Finger
from soft_gripper.sensors.sensor_layout import SensorLayout


def test_borders_are_said_in_millimetres(shipped_finger: Finger) -> None:
    layouts = [SensorLayout(shipped_finger, sections, borders=borders) for sections, borders in LAYOUTS]
    assert [describe_borders(layout) for layout in layouts] == ["60", "40", "30 60 90"]
