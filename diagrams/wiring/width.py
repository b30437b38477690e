"""The width of what a gripper holds, applied."""

from collections.abc import Mapping, Sequence

from pydrake.systems.framework import DiagramBuilder, OutputPort

from soft_gripper.diagrams.wiring.grip_control import find_gripper
from soft_gripper.diagrams.wiring.named_wires import inputs
from soft_gripper.estimation.object_width import ObjectWidth
from soft_gripper.fingers.finger import Finger
from soft_gripper.fingers.plant_finger import PlantFinger


def add_object_width(
    builder: DiagramBuilder,
    fingers: Sequence[PlantFinger],
    believed: Mapping[str, Finger],
    signals: Mapping[str, OutputPort],
) -> OutputPort:
    """Adds `object_width` for the fingers of one gripper; returns the width, (1) m.

    Args:
        builder: of a diagram with the fingers' plant.
        fingers: of one gripper.
        believed: the fingers as they are believed to be, by their names.
        signals: has `{finger}.estimated_joint_angles` and `{finger}.contact`.

    Raises:
        InputError: unless the fingers form a gripper.
    """
    gripper = find_gripper(fingers, "estimator.contact_threshold")
    width = ObjectWidth(gripper, {finger.name: believed[finger.name] for finger in fingers})
    builder.AddNamedSystem("object_width", width)
    for name, port in inputs(width).items():
        builder.Connect(signals[name], port)
    return width.get_output_port()
