"""Signals that come straight from the plant: its state, the free objects, the arm."""

from collections.abc import Iterable, Sequence

import numpy as np
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import Joint, ModelInstanceIndex, PrismaticJoint, QuaternionFloatingJoint, RevoluteJoint
from pydrake.systems.framework import DiagramBuilder, OutputPort
from pydrake.systems.primitives import MatrixGain

from soft_gripper.diagrams.scene import Scene, arm_joints
from soft_gripper.diagrams.wiring.named_wires import add_stage
from soft_gripper.signals import describe

POSE, POSE_UNITS = ("q_w", "q_x", "q_y", "q_z", "x", "y", "z"), ("1", "1", "1", "1", "m", "m", "m")
WRENCH = ("torque_x", "torque_y", "torque_z", "force_x", "force_y", "force_z")
WRENCH_UNITS = ("N m", "N m", "N m", "N", "N", "N")


def add_plant_signals(
    builder: DiagramBuilder,
    scene: Scene,
    free: Iterable[str],
    arm: str | None = None,
    wrenches: bool = True,
) -> dict[str, OutputPort]:
    """Adds blocks that select signals from the plant's state; returns the signals.

    They are `plant.state`; for each free model `{object}.pose` and `{object}.contact_wrench`, and what else a
    deformable one adds; and for the arm `{arm}.joint_positions`, `{arm}.joint_velocities` and `{arm}.joint_torques`.

    `free` names the free models, `arm` the arm; `wrenches`: with the contact wrenches.
    """
    plant = scene.plant
    names, units = plant.GetStateNames(), state_units(plant)
    signals = {"plant.state": describe(plant.get_state_output_port(), units, state=names)}
    for name in free:
        model = plant.GetModelInstanceByName(name)
        if name in scene.deformables:
            object_signals = scene.deformables[name].add_signals(builder, plant)
            signals |= {s: port for s, port in object_signals.items() if wrenches or s != f"{name}.contact_wrench"}
            continue
        first = plant.get_body(plant.GetBodyIndices(model)[0]).floating_positions_start()
        pose = _pick(builder, plant, f"{name}.pose", range(first, first + 7))
        signals[f"{name}.pose"] = describe(pose, POSE_UNITS, pose_entry=POSE)
        if wrenches:
            wrench = _contact_wrench(builder, plant, model, name)
            signals[f"{name}.contact_wrench"] = describe(wrench, WRENCH_UNITS, wrench=WRENCH)
    return signals | (_arm_signals(builder, plant, arm) if arm is not None else {})


def _contact_wrench(builder: DiagramBuilder, plant: MultibodyPlant, model: ModelInstanceIndex, name: str) -> OutputPort:
    """The wrench of all contacts of a free model at its first link, which is the force along its six free motions."""
    forces = plant.get_generalized_contact_forces_output_port(model)
    if forces.size() == len(WRENCH):
        return forces
    first = plant.get_body(plant.GetBodyIndices(model)[0]).floating_velocities_start_in_v()
    velocities = plant.GetVelocitiesFromArray(model, np.arange(plant.num_velocities()))
    offset = int(np.flatnonzero(velocities == first)[0])
    selector = MatrixGain(np.eye(forces.size())[offset : offset + len(WRENCH)])
    return add_stage(builder, f"{name}.contact_wrench", selector, forces)


def _arm_signals(builder: DiagramBuilder, plant: MultibodyPlant, arm: str) -> dict[str, OutputPort]:
    model = plant.GetModelInstanceByName(arm)
    joints = arm_joints(plant, model)
    names = [joint.name() for joint in joints]
    nq = plant.num_positions()
    lengths = [isinstance(joint, PrismaticJoint) for joint in joints]
    unit = ["m" if is_length else "rad" for is_length in lengths]
    effort = ["N" if is_length else "N m" for is_length in lengths]
    positions = _pick(builder, plant, f"{arm}.joint_positions", [joint.position_start() for joint in joints])
    velocities = _pick(builder, plant, f"{arm}.joint_velocities", [nq + joint.velocity_start() for joint in joints])
    torques = _actuation(builder, plant, model, f"{arm}.joint_torques", joints)
    return {
        f"{arm}.joint_positions": describe(positions, unit, arm_joint=names),
        f"{arm}.joint_velocities": describe(velocities, [f"{name}/s" for name in unit], arm_joint=names),
        f"{arm}.joint_torques": describe(torques, effort, arm_joint=names),
    }


def describe_arm_state(plant: MultibodyPlant, arm: str, port: OutputPort) -> None:
    """Declares that a port carries positions and then velocities of an arm's joints."""
    joints = arm_joints(plant, plant.GetModelInstanceByName(arm))
    position_units, velocity_units = zip(*map(_joint_units, joints), strict=True)
    labels = [f"{joint.name()}_{kind}" for kind in "qv" for joint in joints]
    describe(port, [unit for units in (*position_units, *velocity_units) for unit in units], arm_state=labels)


def _pick(builder: DiagramBuilder, plant: MultibodyPlant, name: str, entries: Sequence[int]) -> OutputPort:
    """Selects entries of the plant's state."""
    selector = MatrixGain(np.eye(plant.num_multibody_states())[list(entries)])
    return add_stage(builder, name, selector, plant.get_state_output_port())


def _actuation(
    builder: DiagramBuilder, plant: MultibodyPlant, model: ModelInstanceIndex, name: str, joints: Sequence[Joint]
) -> OutputPort:
    """The torques or forces that the actuators of a model apply, in the order of its joints."""
    actuated = [plant.get_joint_actuator(i).joint().index() for i in plant.GetJointActuatorIndices(model)]
    rows = [[joint.index() == index for index in actuated] for joint in joints]
    selector = MatrixGain(np.array(rows, dtype=float).reshape(len(joints), -1))
    return add_stage(builder, name, selector, plant.get_net_actuation_output_port(model))


def state_units(plant: MultibodyPlant) -> list[str]:
    """The unit of each entry of the plant's state."""
    positions, velocities = ["1"] * plant.num_positions(), ["1"] * plant.num_velocities()
    for joint in (plant.get_joint(index) for index in plant.GetJointIndices()):
        position_units, velocity_units = _joint_units(joint)
        positions[joint.position_start() : joint.position_start() + len(position_units)] = position_units
        velocities[joint.velocity_start() : joint.velocity_start() + len(velocity_units)] = velocity_units
    return positions + velocities


def _joint_units(joint: Joint) -> tuple[list[str], list[str]]:
    if isinstance(joint, QuaternionFloatingJoint):
        return list(POSE_UNITS), ["rad/s"] * 3 + ["m/s"] * 3
    if isinstance(joint, RevoluteJoint):
        return ["rad"], ["rad/s"]
    return (["m"], ["m/s"]) if isinstance(joint, PrismaticJoint) else ([], [])
