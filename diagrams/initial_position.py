"""Positions of joints in which a run begins, by the names of the joints, as Drake's own scenarios give them."""

from collections.abc import Mapping, Sequence

import numpy as np
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import ModelInstanceIndex

from soft_gripper.errors import InputError
from soft_gripper.model_import.imported_model import Mimic


def set_initial_position(
    plant: MultibodyPlant,
    model: ModelInstanceIndex,
    positions: Mapping[str, Sequence[float]],
    mimics: Sequence[Mimic],
    where: str,
) -> None:
    """Sets default positions of joints of a model, before the plant is finalized; joints that follow others go along.

    Args:
        plant: with the model.
        model: whose joints are named.
        positions: by name of a joint, one for each of its degrees of freedom, rad or m.
        mimics: joints of the model that follow others.
        where: part of the scenario, for messages.

    Raises:
        InputError: for a joint that is unknown, does not move or follows another, or a position beyond its limits.
    """
    joints = {joint.name(): joint for joint in map(plant.get_joint, plant.GetJointIndices(model))}
    following = {mimic.joint: mimic.leader for mimic in mimics}
    joint_positions = {name: np.array(position) for name, position in positions.items()}
    for name, position in joint_positions.items():
        if name in following:
            raise InputError(where, f"initial_position.{name}", [*position], f"leave it out: follows {following[name]}")
    for mimic in mimics:
        if mimic.leader in joint_positions:
            joint_positions[mimic.joint] = mimic.multiplier * joint_positions[mimic.leader] + mimic.offset
    for name, position in joint_positions.items():
        joint = joints.get(name)
        if joint is None or joint.num_positions() == 0:
            movable_names = (name for name, joint in joints.items() if joint.num_positions() and name not in following)
            expected = f"no joint that moves has this name; known: {', '.join(movable_names) or 'none'}"
            raise InputError(where, f"initial_position.{name}", [*position], expected)
        low, high = joint.position_lower_limits(), joint.position_upper_limits()
        if len(position) != len(low):
            raise InputError(where, f"initial_position.{name}", [*position], f"give {len(low)} numbers, in a list")
        if not np.all((low <= position) & (position <= high)):
            limits = " and ".join(f"{minimum:g} to {maximum:g}" for minimum, maximum in zip(low, high, strict=True))
            follows = f"; it follows '{following[name]}'" if name in following else ""
            expected = f"must be within the limits of the joint, {limits}{follows}"
            raise InputError(where, f"initial_position.{name}", [*position], expected)
        joint.set_default_positions(position)
