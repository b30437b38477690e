"""Grip control, applied: the gripper opening, controlled through the common pressure of the fingers."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from pydrake.systems.framework import Diagram, DiagramBuilder, InputPort, OutputPort
from pydrake.systems.primitives import MatrixGain, Saturation

from soft_gripper.arrays import Array
from soft_gripper.control.grip import GripForce, GripForceBound, GripTorque, LowSelector, SampledSteps
from soft_gripper.control.pid_controller import PidController, PidGains
from soft_gripper.diagrams.wiring.drive import Commands
from soft_gripper.diagrams.wiring.named_wires import Ports, add_stage, inputs, vector_outputs
from soft_gripper.errors import InputError
from soft_gripper.fingers.plant_finger import PlantFinger
from soft_gripper.load.opening import Gripper, GripperOpening
from soft_gripper.scenario.schema import ControlConfig
from soft_gripper.signals import describe

UNITS = {"opening": "m", "torque": "N m", "force": "N"}  # of the measured quantities of a grip


@dataclass(frozen=True)
class Supply:
    """Range of pressures, or of tendon commands, that a controller may use, and its sampling period."""

    minimum: float  # Pa, N or m
    maximum: float  # Pa, N or m
    period: float  # s


class GripControl(Diagram):
    """Set point -> PID on the estimated opening -> pressure; a second PID may limit the torque or force on the fingers.

    ::

        set_point (1) m -----------------------> +-------------+ ---> pressure  (1) Pa, for all fingers
        {finger}.tip_pose (3) -----------------> | GripControl | ---> opening   (1) m, of the estimated tips
        {finger}.external_torque (N) N m ------> |             | ---> torque    (1) N m, that opens the fingers
        {finger}.contact_force_vector (3) N ---> +-------------+ ---> force     (1) N, of what is held

    `torque` is the mean over the fingers at their base joints; `force`, which exists with a force limit, is the mean of
    their closing forces, or with `force_bound` of the upper bounds of their forces: then the inputs
    `contact_force_interval` and `contact` of the fingers replace `contact_force_vector`. With a limit, the lower of the
    pressures commanded by the two PIDs is applied, and both PIDs receive the applied pressure.
    """

    def __init__(self, gripper: Gripper, joints: Mapping[str, int], config: ControlConfig, supply: Supply):
        """`joints` gives the number of joints of each finger by name, in the order of the gripper."""
        super().__init__()
        builder = DiagramBuilder()
        opening = builder.AddNamedSystem("gripper_opening", GripperOpening(gripper, list(joints)))
        gains = config.gains
        closing_gains = replace(gains, kp=-gains.kp, ki=-gains.ki, kd=-gains.kd)  # more pressure closes the gripper
        pid = _add_pid(builder, "pid", closing_gains, supply)
        builder.Connect(opening.get_output_port(), pid.GetInputPort("measurement"))
        grip = builder.AddNamedSystem("grip_torque", GripTorque(joints))
        torque = grip.get_output_port()
        builder.ExportInput(pid.GetInputPort("set_point"), "set_point")
        for block in (opening, grip):
            for name, port in inputs(block).items():
                builder.ExportInput(port, name)
        pressure = pid.GetOutputPort("output")
        outputs = {"opening": opening.get_output_port(), "torque": torque}
        if config.torque_limit is not None:
            pressure = _add_limit(builder, "torque", config.torque_limit, config.torque_gains, pid, torque, supply)
        if config.force_limit is not None:
            measure = GripForceBound if config.force_bound else GripForce
            grip_force = builder.AddNamedSystem("grip_force", measure(joints))
            for name, port in inputs(grip_force).items():
                builder.ExportInput(port, name)
            force = outputs["force"] = grip_force.get_output_port()
            pressure = _add_limit(builder, "force", config.force_limit, config.force_gains, pid, force, supply)
        for name, port in {"pressure": pressure, **outputs}.items():
            builder.ExportOutput(port, name)
        builder.BuildInto(self)
        for name in outputs:
            describe(self.GetOutputPort(name), UNITS[name])
        describe(self.GetOutputPort("pressure"), "Pa")


def _add_pid(
    builder: DiagramBuilder, name: str, gains: PidGains, supply: Supply, initial: float = 0.0
) -> PidController:
    pid = PidController(gains, supply.period, supply.minimum, supply.maximum, initial)
    return builder.AddNamedSystem(name, pid)


def _add_limit(
    builder: DiagramBuilder,
    kind: str,
    limit: float,
    gains: PidGains,
    pid: PidController,
    measured: OutputPort,
    supply: Supply,
) -> OutputPort:
    """Adds a PID on a torque or a force in parallel with that on the opening, and a selector of the lower pressure."""
    # It has no effect until the first torque or force is estimated.
    limiter = _add_pid(builder, f"{kind}_pid", gains, supply, supply.maximum)
    source = builder.AddNamedSystem(f"{kind}_limit", SampledSteps([limit], np.inf, supply.period))
    selector = builder.AddNamedSystem("selector", LowSelector())
    builder.Connect(source.get_output_port(), limiter.GetInputPort("set_point"))
    builder.Connect(measured, limiter.GetInputPort("measurement"))
    for controller, name in ((pid, "first"), (limiter, "second")):
        builder.Connect(controller.get_output_port(), selector.GetInputPort(name))
        builder.Connect(selector.get_output_port(), controller.GetInputPort("applied"))
    return selector.get_output_port()


def forms_gripper(fingers: Sequence[PlantFinger]) -> bool:
    """Whether there are two or more fingers on one palm, with bases fixed relative to each other."""
    if len(fingers) < 2:
        return False
    rigid = {body.index() for body in fingers[0].plant.GetBodiesWeldedTo(fingers[0].base)}
    return all(finger.base.index() in rigid for finger in fingers)


def find_gripper(fingers: Sequence[PlantFinger], field: str) -> Gripper:
    """The gripper formed by some fingers.

    Raises:
        InputError: if they do not form one; `field` is the field that requires it.
    """
    if not forms_gripper(fingers):
        names = [finger.name for finger in fingers]
        raise InputError(field, "fingers", names, "needs two fingers or more, with bases fixed relative to each other")
    return Gripper.of_bases([finger.X_WB for finger in fingers])


def add_grip_control(
    builder: DiagramBuilder,
    fingers: Sequence[PlantFinger],
    config: ControlConfig,
    supply: Supply,
    signals: Mapping[str, OutputPort],
    commands: Commands,
) -> tuple[InputPort, Ports]:
    """Adds `grip_control` for the fingers of one gripper, and a `{finger}.allocation` where it has to choose.

    Returns the input port of the set point, (1) m, and the signals. `signals` must contain `{finger}.tip_pose`,
    `{finger}.external_torque` and, if force is limited, `{finger}.contact_force_vector`, or
    `{finger}.contact_force_interval` and `{finger}.contact` for its bound. `commands` are those of the pressures, or of
    the tendons of fingers without chambers.

    Raises:
        InputError: if the fingers do not form a gripper, or contact force is limited but not estimated, or its bound
            is but contact is not detected.
    """
    gripper = find_gripper(fingers, "control")
    joints = {finger.name: finger.finger.segments for finger in fingers}
    control = builder.AddNamedSystem("grip_control", GripControl(gripper, joints, config, supply))
    for name, port in inputs(control).items():
        if name != "set_point":
            _check_available(name.rpartition(".")[2], config, name in signals)
            builder.Connect(signals[name], port)
    common = control.GetOutputPort("pressure")
    command_signals = {}
    for finger in fingers:
        command = _allocate(builder, finger, common, commands)
        builder.Connect(command, commands.inputs[finger.name])
        command_signals[f"{finger.name}.{commands.kind}_command"] = command
    grip_ports = {f"grip.{name}": port for name, port in vector_outputs(control).items() if name in UNITS}
    return control.GetInputPort("set_point"), {**grip_ports, **command_signals}


def _check_available(signal: str, config: ControlConfig, is_available: bool) -> None:
    if is_available:
        return
    if signal == "contact":
        expected = "requires contact detection: give estimator.contact_threshold, N m"
        raise InputError("control", "force_bound", config.force_bound, expected)
    expected = "requires an estimator of contact force: estimator.type contact or recursive"
    raise InputError("control", "force_limit", config.force_limit, expected)


def _allocate(builder: DiagramBuilder, finger: PlantFinger, common: OutputPort, commands: Commands) -> OutputPort:
    """The commands of a finger's chambers, or tendons, that bend it as the common one asks for."""
    if not commands.axes[finger.name]:
        return common
    bending = finger.finger.pressure_gains if commands.kind == "pressure" else finger.finger.tension_gains
    gains = bending["bending"].sum(axis=-1)
    shares = add_stage(builder, f"{finger.name}.shares", MatrixGain(allocation(gains)[:, None]), common)
    push_limit = Saturation(np.zeros(len(gains)), np.full(len(gains), np.inf))
    return commands.described(finger.name, add_stage(builder, f"{finger.name}.allocation", push_limit, shares))


def allocation(gains: Array) -> Array:
    """Shares of chambers, or tendons, in a common command, (C,): each takes its own if that is positive, else nothing.

    A command u bends the finger in proportion to u, whatever its sign, by the least sum of squares of the shares; the
    strongest of those that close it takes u itself.

    Args:
        gains: bending torque of each per unit, (C,), positive closes.
    """
    closing, opening = np.maximum(gains, 0.0), np.minimum(gains, 0.0)
    strength = (closing**2).sum() / closing.max() if closing.any() else -(opening**2).sum() / opening.min()
    sides = [strength * side / max(float((side**2).sum()), np.finfo(float).tiny) for side in (closing, opening)]
    return np.asarray(sides[0] + sides[1])


def add_set_points(builder: DiagramBuilder, set_point: InputPort, config: ControlConfig, period: float) -> Ports:
    """Adds `grip.set_points`, the steps of `config`; returns the signal."""
    source = SampledSteps(config.set_points or [], config.hold, period)
    builder.AddNamedSystem("grip.set_points", source)
    builder.Connect(source.get_output_port(), set_point)
    return {"grip.set_point": describe(source.get_output_port(), "m")}
