"""The task of a scenario, applied: planned before anything moves, then led by a TaskMachine.

The pose of an object is reported with an error (`task.pose_error`), so that a moved object is reported where it then
is. The path check uses the reported pose too, because the true one is not known before the fingers arrive. Pick and
place uses steps of 5 ms and a stiction tolerance of 0.1 mm/s: at 10 ms and 1 mm/s a heavy or slippery object creeps
in the fingers and turns.
"""

from collections.abc import Sequence

from pydrake.multibody.plant import MultibodyPlant
from pydrake.systems.framework import DiagramBuilder, InputPort, OutputPort

from soft_gripper.control.arm_motion import ArmLimits, LimitError
from soft_gripper.control.task_machine import TaskMachine
from soft_gripper.control.task_phases import Rules
from soft_gripper.control.tool_follower import ToolFollower
from soft_gripper.diagrams.manipulation.arm import Arm
from soft_gripper.diagrams.manipulation.task_plan import plan_phases
from soft_gripper.diagrams.wiring.external import External
from soft_gripper.errors import InputError
from soft_gripper.scenario.scenario import ModelConfig, TaskConfig


def add_task(
    builder: DiagramBuilder,
    task: TaskConfig,
    models: Sequence[ModelConfig],
    arm: Arm,
    period: float,
    desired_state: InputPort,
    grip: tuple[InputPort, OutputPort, OutputPort] | None,
) -> tuple[TaskMachine, dict[str, OutputPort]]:
    """Adds `task`; returns it and the signals.

    Args:
        builder: of a diagram with the arm's plant.
        task: the `task` part of a scenario.
        models: the `models` part, with the object that is handled.
        arm: that moves.
        period: of the samples, s.
        desired_state: of the arm, where `add_arm_control` takes it in.
        grip: of a task that commands the gripper, the set point, opening and torque of its grip control.

    Raises:
        InputError: if a phase leads where the arm cannot go.
    """
    rules = Rules(plan_phases(task, models, arm), task.grip_threshold, task.timeout, task.quiet_band)
    machine = builder.AddNamedSystem("task", TaskMachine(rules, period))
    builder.Connect(machine.GetOutputPort("desired_state"), desired_state)
    signals = {f"task.{name}": machine.GetOutputPort(name) for name in ("phase", "outcome", "desired_state")}
    if grip is not None:
        set_point, opening, torque = grip
        builder.Connect(opening, machine.GetInputPort("opening"))
        builder.Connect(torque, machine.GetInputPort("torque"))
        builder.Connect(machine.GetOutputPort("set_point"), set_point)
        signals["grip.set_point"] = machine.GetOutputPort("set_point")
    return machine, signals


def add_tool_target(
    builder: DiagramBuilder, plant: MultibodyPlant, arm: Arm, period: float, desired_state: InputPort
) -> External:
    """Adds `{arm}.tool_follower`.

    Returns:
        where `{arm}.X_WTool` goes in, a RigidTransform, the pose of the frame by which the gripper is welded; and
        `{arm}.desired_state`, what is desired of the joints, (2 n).

    Raises:
        InputError: if the arm's file leaves a limit open.
    """
    try:
        limits = ArmLimits.of_plant(arm.plant, arm.config.acceleration)
    except LimitError as error:
        raise InputError("arm", "model", arm.name, str(error)) from None
    follower = ToolFollower(arm.plant, arm.tool, limits, period)
    builder.AddNamedSystem(f"{arm.name}.tool_follower", follower)
    builder.Connect(plant.get_state_output_port(arm.model), follower.GetInputPort("robot_state"))
    builder.Connect(follower.GetOutputPort("desired_state"), desired_state)
    target, desired = follower.GetInputPort("X_WTool"), follower.GetOutputPort("desired_state")
    return External({f"{arm.name}.X_WTool": target}, {f"{arm.name}.desired_state": desired})
