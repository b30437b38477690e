"""grip_control: the distance between two fingertips, held through their common pressure."""

from collections.abc import Mapping, Sequence

import numpy as np
from pydrake.math import RigidTransform
from pydrake.systems.framework import Diagram, DiagramBuilder, InputPort, OutputPort

from soft_gripper.diagrams.plant import PlantFinger
from soft_gripper.diagrams.pressure_steps import step_source
from soft_gripper.diagrams.scenario import Scenario
from soft_gripper.errors import InputError
from soft_gripper.fingertip_distance import FingertipDistance
from soft_gripper.pid_controller import PidGains, SampledPidController


class GripControl(Diagram):
    """Set point -> PID on the estimated distance -> pressure.

    set_point (1) m ----------------> +-------------+ ---> pressure  (1) Pa, for both fingers
    first_tip_pose, second_tip_pose > | GripControl | ---> distance  (1) m, between the estimated tips
                                      +-------------+
    """

    def __init__(self, scenario: Scenario, X_B1B2: RigidTransform):
        """`X_B1B2` is the pose of the second finger's base in the first's."""
        super().__init__()
        gains, supply = scenario.control.gains, scenario.pressure
        # More pressure brings the tips together: the output acts in reverse.
        reverse = PidGains(-gains.kp, -gains.ki, -gains.kd, gains.derivative_filter, gains.tracking_time)
        builder = DiagramBuilder()
        distance = builder.AddNamedSystem("fingertip_distance", FingertipDistance(X_B1B2))
        pid = SampledPidController(reverse, scenario.sensor.period, supply.minimum, supply.maximum)
        builder.AddNamedSystem("pid", pid)
        builder.Connect(distance.get_output_port(), pid.GetInputPort("measurement"))
        for block, name in ((pid, "set_point"), (distance, "first_tip_pose"), (distance, "second_tip_pose")):
            builder.ExportInput(block.GetInputPort(name), name)
        builder.ExportOutput(pid.get_output_port(), "pressure")
        builder.ExportOutput(distance.get_output_port(), "distance")
        builder.BuildInto(self)


def add_grip_control(
    builder: DiagramBuilder,
    scenario: Scenario,
    fingers: Sequence[PlantFinger],
    commands: Mapping[str, InputPort],
    signals: Mapping[str, OutputPort],
) -> dict[str, OutputPort]:
    """Adds `grip_control` and its set points; returns the signals.

    Raises:
        InputError: unless there are just two fingers.
    """
    if len(fingers) != 2:
        raise InputError("control", "set_points", scenario.control.set_points, "closed loop needs two fingers")
    first, second = fingers
    control = GripControl(scenario, first.X_WB.inverse() @ second.X_WB)
    builder.AddNamedSystem("grip_control", control)
    set_points = step_source(np.array(scenario.control.set_points), scenario.control.hold)
    builder.AddNamedSystem("grip.set_points", set_points)
    builder.Connect(set_points.get_output_port(), control.GetInputPort("set_point"))
    for finger, port in ((first, "first_tip_pose"), (second, "second_tip_pose")):
        builder.Connect(signals[f"{finger.name}.tip_pose"], control.GetInputPort(port))
        builder.Connect(control.GetOutputPort("pressure"), commands[finger.name])
    pressure = control.GetOutputPort("pressure")
    return {
        "grip.set_point": set_points.get_output_port(),
        "grip.distance": control.GetOutputPort("distance"),
        **{f"{finger.name}.pressure_command": pressure for finger in fingers},
    }
