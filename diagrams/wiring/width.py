"""The width of what a gripper holds, applied."""

from collections.abc import Mapping

from pydrake.systems.framework import DiagramBuilder, OutputPort

from soft_gripper.diagrams.wiring.named_wires import inputs
from soft_gripper.estimation.gripper_opening import Gripper
from soft_gripper.estimation.object_width import ObjectWidth
from soft_gripper.fingers.finger import Finger


def add_object_width(
    builder: DiagramBuilder, gripper: Gripper, believed: Mapping[str, Finger], signals: Mapping[str, OutputPort]
) -> OutputPort:
    """Adds `object_width` for the fingers of one gripper; returns the width, (1) m.

    Args:
        builder: of any diagram.
        gripper: where the fingers stand.
        believed: the fingers as they are believed to be, in the order of the gripper, by their names.
        signals: has `{finger}.estimated_joint_angles` and `{finger}.contact`.
    """
    width = ObjectWidth(gripper, believed)
    builder.AddNamedSystem("object_width", width)
    for name, port in inputs(width).items():
        builder.Connect(signals[name], port)
    return width.get_output_port()
