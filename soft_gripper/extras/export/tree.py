"""Reads the tree of bodies of a finalized plant for files of other simulators: joints, poses at zero, mobilities."""

from collections.abc import Iterable, Iterator, Mapping
from typing import Any

import numpy as np
from pydrake.math import RigidTransform
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import (
    BodyIndex,
    JacobianWrtVariable,
    Joint,
    PrismaticJoint,
    RevoluteJoint,
    RigidBody,
    RotationalInertia,
    WeldJoint,
)

from soft_gripper.arrays import Array
from soft_gripper.diagrams.station_parts import Station
from soft_gripper.errors import InputError
from soft_gripper.fingers.plant_finger import PlantFinger


def child_joints(plant: MultibodyPlant) -> dict[Any, list[Joint]]:
    """Joints to the children of each body, by its index."""
    joints: dict[Any, list[Joint]] = {}
    for index in plant.GetJointIndices():
        joint = plant.get_joint(index)
        joints.setdefault(joint.parent_body().index(), []).append(joint)
    return joints


def tree_depth(plant: MultibodyPlant) -> int:
    """Number of bodies in the longest chain from the world to a leaf, without the world."""
    children = child_joints(plant)
    depth = 0
    level = children.get(plant.world_body().index(), [])
    while level:
        depth += 1
        level = [child for joint in level for child in children.get(joint.child_body().index(), [])]
    return depth


def neighbors(plant: MultibodyPlant) -> dict[Any, set[Any]]:
    """Bodies whose contacts with a body need a listed pair in MuJoCo, by its index.

    They are fixed to the body, or to one that a joint connects with it, unless that is fixed to the world.
    """
    bodies = [plant.get_body(BodyIndex(number)) for number in range(plant.num_bodies())]
    welded_bodies = {body.index(): {welded.index() for welded in plant.GetBodiesWeldedTo(body)} for body in bodies}
    neighbor_bodies = {index: set(indices) for index, indices in welded_bodies.items()}
    for joint in map(plant.get_joint, plant.GetJointIndices()):
        parents = welded_bodies[joint.parent_body().index()]
        children = welded_bodies[joint.child_body().index()]
        if plant.world_body().index() not in parents:
            for body in parents:
                neighbor_bodies[body] |= children
            for body in children:
                neighbor_bodies[body] |= parents
    return neighbor_bodies


def springs(fingers: Iterable[PlantFinger]) -> Iterator[tuple[Any, tuple[float, float]]]:
    """Stiffness and damping of every joint of fingers, by joint index."""
    for finger in fingers:
        for deformation, stiffness in finger.finger.stiffnesses.items():
            for joint, k in zip(finger.joints_of(deformation), stiffness, strict=True):
                yield joint.index(), (float(k), float(k) * finger.finger.relaxation_time)


def exports_creep(finger: PlantFinger) -> bool:
    """Whether creep depends on the angles of the joints alone."""
    law = finger.finger.pressure_law
    return bool(finger.finger.creep) and not (law is not None and law.widens)


def missing_properties(station: Station) -> Iterator[str]:
    """Texts on properties of fingers and parts of a scenario that are missing in the file."""
    scenario = station.scenario
    for finger in station.fingers:
        for name in ("elastic_law", "tendons"):
            if getattr(finger.finger, name):
                yield f"{finger.name}: {name}"
        if finger.finger.takes_stiffness:
            yield f"{finger.name}: pressure_law.stiffness_taken; it bends as if pressure took nothing of its stiffness"
    if scenario.task is not None and scenario.task.grips:
        yield "task: it waits for estimates; the arm stays where the run begins"
    if scenario.external:
        yield f"external: {', '.join(scenario.external)}; commands are those of the scenario"
    if scenario.control.set_points is not None:
        yield "control.set_points: a closed loop; pressures stay 0"
    if scenario.pressure.leaks:
        yield "pressure.leaks"


def zero_pose(joint: Joint) -> RigidTransform:
    """Pose of a joint's child in its parent at zero position; of a free body, at the beginning of a run."""
    plant = joint.GetParentPlant()
    child = joint.child_body()
    if child.is_floating_base_body():
        return plant.GetDefaultFloatingBaseBodyPose(child)
    X_PF = joint.frame_on_parent().GetFixedPoseInBodyFrame()
    X_CM = joint.frame_on_child().GetFixedPoseInBodyFrame()
    X_FM = joint.X_FM() if isinstance(joint, WeldJoint) else RigidTransform()
    return X_PF @ X_FM @ X_CM.inverse()


def joint_axis(joint: Joint) -> Array:
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


def central_inertia(body: RigidBody) -> RotationalInertia:
    """Inertia of a body about its centre of mass, in its frame, kg m^2."""
    return body.default_spatial_inertia().Shift(body.default_com()).CalcRotationalInertia()


def mobilities(
    plant: MultibodyPlant, joint_springs: Mapping[Any, tuple[float, float]], step: float
) -> dict[Any, float]:
    """Mobility of the centre of mass of each body, 1/kg, by its index: the mean over all directions.

    With all joints at zero, acceleration per force: a third of the trace of J M^-1 J^T. What springs and dampers take
    from it within a step is approximated joint by joint, by the diagonals of M and M + h D + h^2 K.

    Args:
        plant: finalized.
        joint_springs: stiffness K and damping D of joints, by their index; others have their own damping.
        step: h, s; 0 for mobilities at an instant.
    """
    context = plant.CreateDefaultContext()
    positions = plant.GetPositions(context)
    drag = np.zeros(plant.num_velocities())
    for joint in map(plant.get_joint, plant.GetJointIndices()):
        if isinstance(joint, RevoluteJoint | PrismaticJoint):
            positions[joint.position_start()] = 0.0
            stiffness, damping = joint_springs.get(joint.index(), (0.0, joint.default_damping()))
            drag[joint.velocity_start()] = step * damping + step**2 * stiffness
    plant.SetPositions(context, positions)
    mass = plant.CalcMassMatrix(context)
    world = plant.world_frame()
    mobility = {}
    inertia = np.diag(mass)
    for number in range(plant.num_bodies()):
        body = plant.get_body(BodyIndex(number))
        J = plant.CalcJacobianTranslationalVelocity(
            context, JacobianWrtVariable.kV, body.body_frame(), body.default_com(), world, world
        )
        mean_mobility = float(np.trace(J @ np.linalg.solve(mass, J.T))) / 3 if J.size else 0.0
        free_rate, damped_rate = (((J**2).sum(axis=0) / inertias).sum() for inertias in (inertia, inertia + drag))
        mobility[body.index()] = mean_mobility * float(damped_rate / free_rate) if mean_mobility > 0 else 0.0
    return mobility


def scoped_name(joint: Joint) -> str:
    """Name of a joint in its scope, `model::joint`."""
    return f"{joint.GetParentPlant().GetModelInstanceName(joint.model_instance())}::{joint.name()}"


def text(values: Iterable[float]) -> str:
    """Formats numbers with all their digits."""
    return " ".join(repr(float(value)) for value in values)
