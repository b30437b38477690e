"""The joints of a model once Drake has read it, whatever the format of its file: limits, actuators, couplings."""

import math
from collections.abc import Iterable, Mapping
from types import MappingProxyType
from typing import Protocol

from pydrake.geometry import CollisionFilterDeclaration, GeometrySet
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import Joint, JointActuator

from soft_gripper.errors import InputError
from soft_gripper.files.notes import LEFT_OUT, READ
from soft_gripper.model_import.added_model import AddedModel

_LIMITS_FORM = "{ lower, upper, velocity, effort } in rad, rad/s and N m, or m, m/s and N"
_LIMIT_TOLERANCE = 1e-3  # rad or m, by which limits of joints that follow others may be rounded in files


class JointLimits(Protocol):
    """Limits of a joint that replace those of its file; None: as in the file."""

    lower: float | None  # rad or m
    upper: float | None
    velocity: float | None  # rad/s or m/s
    effort: float | None  # N m or N


def set_limits(model: AddedModel, limits: Mapping[str, JointLimits]) -> None:
    """Gives the joints of an arm the limits of a scenario, which replace those of its file, and checks the result.

    Those that follow others need none, and have no effort.

    Raises:
        InputError: if there is no such joint, or one has a range, velocity or effort of zero.
    """
    leaders = {mimic.joint: mimic.leader for mimic in model.mimics}
    model_joints = (model.plant.get_joint(index) for index in model.plant.GetJointIndices(model.index))
    joints = {joint.name(): joint for joint in model_joints if joint.num_velocities() == 1}
    for name, config in limits.items():
        if name not in joints:
            raise InputError("arm", "limits", name, f"no such joint; known: {', '.join(joints)}")
        if name in leaders and config.effort is not None:
            expected = f"leave it out: the joint follows '{leaders[name]}', without an actuator"
            raise InputError(f"arm.limits.{name}", "effort", config.effort, expected)
    motors = {actuator.joint().name(): actuator for actuator in _actuators(model)}
    for name, joint in joints.items():
        if name in limits:
            _set_limits(model.plant, joint, motors.get(name), limits[name])
    motors = {actuator.joint().name(): actuator for actuator in _actuators(model)}
    for name in [name for name in joints if name not in leaders]:
        motor = motors.get(name)
        _check(model, joints[name], motor.effort_limit() if motor is not None else 0.0)


def _actuators(model: AddedModel) -> list[JointActuator]:
    actuators = (model.plant.get_joint_actuator(index) for index in model.plant.GetJointActuatorIndices())
    return [actuator for actuator in actuators if actuator.model_instance() == model.index]


def _limits(joint: Joint) -> tuple[float, float, float]:
    """The least and the largest position and the largest velocity of a joint."""
    (lower,), (upper,) = joint.position_lower_limits(), joint.position_upper_limits()
    return float(lower), float(upper), float(joint.velocity_upper_limits()[0])


def _set_limits(plant: MultibodyPlant, joint: Joint, motor: JointActuator | None, limits: JointLimits) -> None:
    lower, upper, _ = _limits(joint)
    if limits.lower is not None or limits.upper is not None:
        lower = lower if limits.lower is None else limits.lower
        upper = upper if limits.upper is None else limits.upper
        if not lower < upper:
            raise InputError(f"arm.limits.{joint.name()}", "upper", upper, f"must be above the lower limit, {lower:g}")
        joint.set_position_limits([lower], [upper])
    if limits.velocity is not None:
        joint.set_velocity_limits([-limits.velocity], [limits.velocity])
    if limits.effort is not None and motor is None:
        plant.AddJointActuator(f"{joint.name()}_actuator", joint, limits.effort)
    elif limits.effort is not None and motor is not None:
        motor.set_effort_limit(limits.effort)


def _check(model: AddedModel, joint: Joint, effort: float) -> None:
    name = joint.name()
    place = f"{model.file.path}: joint '{name}'"
    lower, upper, velocity = _limits(joint)
    expected = f"give what the joint can do at most, in the file or in the scenario: arm.limits.{name}: {_LIMITS_FORM}"
    for field, value in (("limit.effort", effort), ("limit.velocity", velocity)):
        if not value > 0:
            raise InputError(place, field, value, expected)
        if value == math.inf:
            why = f"the file gives none; arm.limits.{name} can"
            model.file.note(READ, f"joint '{name}': {field}", "unlimited", why.replace(name, "JOINT"))
    if not lower < upper:
        raise InputError(place, "limit.upper", upper, f"is not above limit.lower; {expected}")


def couple(model: AddedModel) -> None:
    """Lets joints follow others, without actuators; raises an InputError if the plant's solver knows no couplers."""
    followers = {mimic.joint for mimic in model.mimics}
    for actuator in [actuator for actuator in _actuators(model) if actuator.joint().name() in followers]:
        model.plant.RemoveJointActuator(actuator)
    for mimic in model.mimics:
        joint, leader = (model.joint(name) for name in (mimic.joint, mimic.leader))
        try:
            model.plant.AddCouplerConstraint(joint, leader, mimic.multiplier, mimic.offset)
        except RuntimeError:
            follower = f"joint '{mimic.joint}' of {model.file.path.name}"
            expected = f"cannot let {follower} follow '{mimic.leader}'; choose lagged or sap"
            raise InputError("plant_config", "discrete_contact_approximation", "tamsi", expected) from None
        law = f"{mimic.multiplier:g} {mimic.leader}" + (f" + {mimic.offset:g}" if mimic.offset else "")
        model.file.note(READ, f"joint '{mimic.joint}'", law, "it follows, and has no place in postures")


def free_followers(model: AddedModel, limits: Mapping[str, JointLimits] = MappingProxyType({})) -> None:
    """Leaves out limits of joints that would stop their leaders, with a note, except those of a scenario.

    Limits that are rounded become those to which the leader takes the joint.
    """
    laws = {mimic.joint: mimic for mimic in model.mimics}

    def leader_range(name: str) -> tuple[float, float]:
        """Range of a joint as its leader moves it; limits of the joint itself do not count."""
        if (law := laws.get(name)) is None:
            return _limits(model.joint(name))[:2]
        ends = [law.offset + (law.multiplier * end if law.multiplier else 0.0) for end in leader_range(law.leader)]
        return min(ends), max(ends)

    for name, law in laws.items():
        joint, given_limits = model.joint(name), limits.get(name)
        (low, high), (lower, upper, velocity) = leader_range(name), _limits(joint)
        is_bounded = math.isfinite(low) and math.isfinite(high)
        contradicts = is_bounded and (low < lower - _LIMIT_TOLERANCE or high > upper + _LIMIT_TOLERANCE)
        is_given = given_limits is not None and (given_limits.lower is not None or given_limits.upper is not None)
        if not is_given and (contradicts or not lower < upper):
            joint.set_position_limits([-math.inf], [math.inf])
            if lower < upper:  # files give limits of zero to what follows
                why = f"it follows '{law.leader}', which takes it from {low:g} to {high:g}; arm.limits can give others"
                model.file.note(LEFT_OUT, f"joint '{name}': limits", f"{lower:g} to {upper:g}", why)
        elif not is_given and is_bounded:
            joint.set_position_limits([min(lower, low)], [max(upper, high)])
        if not velocity > 0:
            joint.set_velocity_limits([-math.inf], [math.inf])


def exclude_self_contact(model: AddedModel) -> None:
    """Excludes contact between the links of an arm, unless its file says which do: neighbours in most arms overlap."""
    plant, scene_graph = model.plant, model.parser.scene_graph()
    if scene_graph is None or not model.parser.GetCollisionFilterGroups().empty():
        return
    frames = [plant.GetBodyFrameIdOrThrow(index) for index in plant.GetBodyIndices(model.index)]
    filter_all = CollisionFilterDeclaration().ExcludeWithin(GeometrySet(frames))
    scene_graph.collision_filter_manager().Apply(filter_all)


def exclude_contact(model: AddedModel, group_pairs: Iterable[tuple[Iterable[str], Iterable[str]]]) -> None:
    """Excludes contact between bodies of a model, in pairs of groups of their names."""
    plant, scene_graph = model.plant, model.parser.scene_graph()
    for pair in group_pairs if scene_graph is not None else ():
        group, other_group = (
            GeometrySet([plant.GetBodyFrameIdOrThrow(plant.GetBodyByName(name, model.index).index()) for name in names])
            for names in pair
        )
        scene_graph.collision_filter_manager().Apply(CollisionFilterDeclaration().ExcludeBetween(group, other_group))
