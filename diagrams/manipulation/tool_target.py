"""Where the tool of an arm is to be, as an input: a ToolFollower, applied."""

from pydrake.multibody.plant import MultibodyPlant
from pydrake.systems.framework import DiagramBuilder, InputPort

from soft_gripper.diagrams.manipulation.arm import Arm
from soft_gripper.diagrams.wiring.external import External
from soft_gripper.errors import InputError
from soft_gripper.manipulation.arm_motion import ArmLimits, LimitError
from soft_gripper.manipulation.tool_follower import ToolFollower


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
