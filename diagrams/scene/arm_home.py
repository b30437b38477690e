"""The posture in which the arm of a scenario begins."""

from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import Joint, ModelInstanceIndex

from soft_gripper.diagrams.schema.scenario import ArmConfig
from soft_gripper.errors import InputError


def set_home_posture(plant: MultibodyPlant, arm: ArmConfig) -> None:
    """Makes the home posture of the arm its default.

    Raises:
        InputError: if there is no such model, or the posture does not fit its joints.
    """
    if not plant.HasModelInstanceNamed(arm.model):
        raise InputError("arm", "model", arm.model, "is none of the models")
    joints = arm_joints(plant, plant.GetModelInstanceByName(arm.model))
    if len(arm.home) != len(joints):
        raise InputError("arm", "home", arm.home, f"give a position for each of: {', '.join(j.name() for j in joints)}")
    for joint, position in zip(joints, arm.home, strict=True):
        (low,), (high,) = joint.position_lower_limits(), joint.position_upper_limits()
        if not low <= position <= high:
            expected = f"give a position within its limits, {low:g} to {high:g}"
            raise InputError("arm.home", joint.name(), position, expected)
        joint.set_default_positions([position])


def arm_joints(plant: MultibodyPlant, model: ModelInstanceIndex) -> list[Joint]:
    """The movable joints of a model, each of one degree of freedom, in the order of its positions.

    Raises:
        InputError: if a joint has more than one degree of freedom.
    """
    joints = [plant.get_joint(index) for index in plant.GetJointIndices(model)]
    for joint in joints:
        if joint.num_positions() > 1:
            raise InputError("arm", "joint", joint.name(), "has several degrees of freedom; an arm's joints have one")
    return sorted((j for j in joints if j.num_positions()), key=lambda joint: joint.position_start())
