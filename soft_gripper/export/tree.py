"""The tree of bodies of a finalized plant, as files of other simulators describe it: in the zero posture."""

from collections.abc import Iterable, Iterator
from typing import Any

from pydrake.math import RigidTransform
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import Joint, PrismaticJoint, RevoluteJoint, RigidBody, RotationalInertia, WeldJoint

from soft_gripper.arrays import Array
from soft_gripper.diagrams.station_parts import Station
from soft_gripper.errors import InputError
from soft_gripper.fingers.plant_finger import PlantFinger


def joints_below(plant: MultibodyPlant) -> dict[Any, list[Joint]]:
    """The joints to the children of each body, by its index."""
    found: dict[Any, list[Joint]] = {}
    for index in plant.GetJointIndices():
        joint = plant.get_joint(index)
        found.setdefault(joint.parent_body().index(), []).append(joint)
    return found


def springs(fingers: Iterable[PlantFinger]) -> Iterator[tuple[Any, tuple[float, float]]]:
    """Stiffness and damping of every joint of fingers, by joint index."""
    for finger in fingers:
        for way, stiffness in finger.finger.stiffnesses.items():
            for joint, k in zip(finger.joints_of(way), stiffness, strict=True):
                yield joint.index(), (float(k), float(k) * finger.finger.relaxation_time)


def left_out(station: Station) -> Iterator[str]:
    """Properties of fingers and parts of a scenario that the file does not have."""
    scenario = station.scenario
    for finger in station.fingers:
        own = finger.finger
        parts = {
            "creep": own.creep,
            "elastic_law": own.elastic_law,
            "tendons": own.tendons,
            "pressure_law": any(own.laws),
        }
        for name, part in parts.items():
            if part:
                yield f"{finger.name}: {name}"
        yield f"{finger.name}: hydroelastic_modulus of its skin; contacts are those of the other simulator"
    if scenario.task is not None:
        yield "task: the arm stays where the run begins"
    if scenario.control.set_points is not None:
        yield "control.set_points: a closed loop; pressures stay 0"
    if scenario.pressure.leaks:
        yield "pressure.leaks"


def pose_at_zero(joint: Joint) -> RigidTransform:
    """The child in the parent where the joint is at zero; a free body where a run begins."""
    plant, child = joint.GetParentPlant(), joint.child_body()
    if child.is_floating_base_body():
        X_WC: RigidTransform = plant.GetDefaultFloatingBaseBodyPose(child)
        return X_WC
    X_PF = joint.frame_on_parent().GetFixedPoseInBodyFrame()
    X_CM = joint.frame_on_child().GetFixedPoseInBodyFrame()
    X_FM = joint.X_FM() if isinstance(joint, WeldJoint) else RigidTransform()
    X_PC: RigidTransform = X_PF @ X_FM @ X_CM.inverse()
    return X_PC


def axis_of(joint: Joint) -> Array:
    """The unit vector along or about which a joint moves, (3,), in its own frame.

    Raises:
        InputError: if it moves otherwise.
    """
    if isinstance(joint, RevoluteJoint):
        return joint.revolute_axis()
    if isinstance(joint, PrismaticJoint):
        return joint.translation_axis()
    expected = f"is a {joint.type_name()} joint; fixed, revolute, prismatic and free ones can be exported"
    raise InputError("export", "joint", joint.name(), expected)


def inertia_of(body: RigidBody) -> RotationalInertia:
    """Of a body about its centre of mass, in its frame, kg m^2."""
    about_center: RotationalInertia = body.default_spatial_inertia().Shift(body.default_com()).CalcRotationalInertia()
    return about_center


def text(values: Iterable[float]) -> str:
    """Numbers with all their digits."""
    return " ".join(repr(float(value)) for value in values)
