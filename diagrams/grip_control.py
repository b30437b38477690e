"""grip_control: the distance between two fingertips, held through their common pressure."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
from pydrake.math import RigidTransform
from pydrake.systems.framework import Diagram, DiagramBuilder, InputPort, OutputPort

from soft_gripper.diagrams.plant import PlantFinger
from soft_gripper.diagrams.scenario import Scenario
from soft_gripper.errors import InputError
from soft_gripper.fingertip_distance import FingertipDistance
from soft_gripper.grip_torque import GripTorque
from soft_gripper.low_selector import LowSelector
from soft_gripper.pid_controller import PidGains, SampledPidController
from soft_gripper.sampled_steps import SampledSteps


class GripControl(Diagram):
    """Set point -> PID on the estimated distance -> pressure; a second PID may limit what the fingers feel.

    set_point (1) m -------------------------> +-------------+ ---> pressure  (1) Pa, for both fingers
    {first,second}_tip_pose -----------------> | GripControl | ---> distance  (1) m, between the estimated tips
    {first,second}_external_torque (N) N m --> +-------------+ ---> torque    (1) N m, that opens the fingers

    `torque` is the mean over both fingers at their base joints. With a torque limit the lower of the
    pressures that the two PIDs ask for is taken, and both are told which.
    """

    def __init__(self, scenario: Scenario, X_B1B2: RigidTransform, joints: Sequence[int]):
        """`X_B1B2` is the pose of the second finger's base in the first's, `joints` the numbers of their joints."""
        super().__init__()
        builder = DiagramBuilder()
        distance = builder.AddNamedSystem("fingertip_distance", FingertipDistance(X_B1B2))
        pid = _add_pid(builder, "pid", scenario, _reversed(scenario.control.gains))
        builder.Connect(distance.get_output_port(), pid.GetInputPort("measurement"))
        feeling = builder.AddNamedSystem("grip_torque", GripTorque(joints))
        torque = feeling.get_output_port()
        builder.ExportInput(pid.GetInputPort("set_point"), "set_point")
        for block in (distance, feeling):
            for i in range(block.num_input_ports()):
                builder.ExportInput(block.get_input_port(i), block.get_input_port(i).get_name())
        pressure = pid.GetOutputPort("output")
        if scenario.control.torque_limit > 0:
            pressure = _add_torque_limit(builder, scenario, pid, torque)
        builder.ExportOutput(pressure, "pressure")
        builder.ExportOutput(distance.get_output_port(), "distance")
        builder.ExportOutput(torque, "torque")
        builder.BuildInto(self)


def _reversed(gains: PidGains) -> PidGains:
    """More pressure brings the tips together: the output acts in reverse."""
    return replace(gains, kp=-gains.kp, ki=-gains.ki, kd=-gains.kd)


def _add_pid(builder: DiagramBuilder, name: str, scenario: Scenario, gains: PidGains) -> SampledPidController:
    supply = scenario.pressure
    pid = SampledPidController(gains, scenario.sensor.period, supply.minimum, supply.maximum)
    return builder.AddNamedSystem(name, pid)


def _add_torque_limit(
    builder: DiagramBuilder, scenario: Scenario, pid: SampledPidController, torque: OutputPort
) -> OutputPort:
    """A PID on the torque beside that on the distance, and the selector of the lower pressure."""
    control = scenario.control
    limiter = _add_pid(builder, "torque_pid", scenario, control.torque_gains)
    period = scenario.sensor.period
    limit = builder.AddNamedSystem("torque_limit", SampledSteps([control.torque_limit], np.inf, period))
    selector = builder.AddNamedSystem("selector", LowSelector())
    builder.Connect(limit.get_output_port(), limiter.GetInputPort("set_point"))
    builder.Connect(torque, limiter.GetInputPort("measurement"))
    for source, name in ((pid, "first"), (limiter, "second")):
        builder.Connect(source.get_output_port(), selector.GetInputPort(name))
        builder.Connect(selector.get_output_port(), source.GetInputPort("applied"))
    return selector.get_output_port()


def add_grip_control(
    builder: DiagramBuilder,
    scenario: Scenario,
    fingers: Sequence[PlantFinger],
    commands: Mapping[str, InputPort],
    signals: Mapping[str, OutputPort],
) -> tuple[InputPort, dict[str, OutputPort]]:
    """Adds `grip_control`; returns where the set point goes in, and the signals.

    Raises:
        InputError: unless there are just two fingers.
    """
    if len(fingers) != 2:
        raise InputError("control", "fingers", [finger.name for finger in fingers], "closed loop needs two fingers")
    first, second = fingers
    control = GripControl(scenario, first.X_WB.inverse() @ second.X_WB, [f.finger.segments for f in fingers])
    builder.AddNamedSystem("grip_control", control)
    for finger, which in ((first, "first"), (second, "second")):
        for signal in ("tip_pose", "external_torque"):
            builder.Connect(signals[f"{finger.name}.{signal}"], control.GetInputPort(f"{which}_{signal}"))
        builder.Connect(control.GetOutputPort("pressure"), commands[finger.name])
    return control.GetInputPort("set_point"), {
        "grip.distance": control.GetOutputPort("distance"),
        "grip.torque": control.GetOutputPort("torque"),
        **{f"{finger.name}.pressure_command": control.GetOutputPort("pressure") for finger in fingers},
    }


def add_set_points(
    builder: DiagramBuilder,
    scenario: Scenario,
    fingers: Sequence[PlantFinger],
    commands: Mapping[str, InputPort],
    signals: Mapping[str, OutputPort],
) -> dict[str, OutputPort]:
    """Adds `grip_control` and `grip.set_points`, the steps of the scenario; returns the signals."""
    set_point, of_control = add_grip_control(builder, scenario, fingers, commands, signals)
    control = scenario.control
    source = SampledSteps(control.set_points, control.hold, scenario.sensor.period)
    builder.AddNamedSystem("grip.set_points", source)
    builder.Connect(source.get_output_port(), set_point)
    return {"grip.set_point": source.get_output_port(), **of_control}
