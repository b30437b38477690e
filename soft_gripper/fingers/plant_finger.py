"""A finger in a MultibodyPlant: its links, joints, frames and actuators; as screws, poses of its links in its base.

The plant gives the screw axis of every joint from a finger's base to its tip once; joints may turn or slide. All
samples are then computed at once, by the product of exponentials (Lynch and Park,
Modern Robotics, section 4.1).
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from pydrake.math import RigidTransform
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import Frame, JacobianWrtVariable, Joint, ModelInstanceIndex, RevoluteSpring, RigidBody
from pydrake.systems.framework import Context

from soft_gripper.arrays import Array
from soft_gripper.fingers.finger import Finger
from soft_gripper.fingers.finger_links import joint_name, link_name, tip_name
from soft_gripper.fingers.finger_parts import SLIDES


class ScrewChain(NamedTuple):
    """J joints that lead to the tip of a finger, and P frames beyond them, where all these joints are at zero."""

    positions: NDArray[np.intp]  # (J) indices of the joints' positions in the plant's, from base to tip
    moves: Array  # (J, 3, 9) terms of sine, 1 - cosine and position of a joint in rotation and shift, see `poses`
    homes: Array  # (P, 3, 4) [R | p] in B
    joints_before: list[int]  # (P) number of joints that move each frame

    def poses(self, state: Array) -> Array:
        """Poses of the frames in B, [R | p], (..., nq + nv) -> (..., P, 3, 4) m.

        With A the matrix of a unit axis a x , and v the velocity of the point at B's origin per rate of the joint, the
        position q turns by  1 + sin q A + (1 - cos q) A A  and shifts by  q v + (1 - cos q) A v + (q - sin q) A A v.
        """
        angles = state[..., self.positions].reshape(-1, len(self.positions)).T  # (J, K): long rows of samples are quick
        sines, versines = np.sin(angles), 1 - np.cos(angles)
        shifts = np.stack([angles, versines, angles - sines], axis=1)
        rotation = np.eye(3)[..., None] + 0 * angles[0]
        shift, poses = 0.0, []
        for home, begin, end in zip(self.homes, [0, *self.joints_before], self.joints_before, strict=False):
            for joint in range(begin, end):  # one at a time stays in the processor's cache
                rotated_moves = self.moves[joint].T @ rotation
                shift = shift + (rotated_moves[:, 6:] * shifts[joint]).sum(axis=1)
                rotation = rotation + (rotated_moves[:, :3] * sines[joint] + rotated_moves[:, 3:6] * versines[joint])
            pose = home.T @ rotation
            pose[:, 3] += shift
            poses.append(pose)
        return np.moveaxis(np.array(poses), -1, 0).reshape(*state.shape[:-1], len(poses), 3, 4)


def screw_chain(plant: MultibodyPlant, frames: Sequence[Frame]) -> ScrewChain:
    """Builds the chain of a finalized plant from the first of `frames` through all others."""
    context, base = plant.CreateDefaultContext(), frames[0]
    # Indices of the plant's positions that move each frame in the base.
    positions = [np.flatnonzero(_velocity_jacobian(plant, context, frame, base).any(axis=0)) for frame in frames]
    angles = plant.GetPositions(context)
    angles[positions[-1]] = 0
    plant.SetPositions(context, angles)
    homes = np.array([frame.CalcPose(context, base).GetAsMatrix34() for frame in frames])
    # Positions are numbered depth first, so those of a chain increase from its base to its tip.
    rates = _velocity_jacobian(plant, context, frames[-1], base)[:, positions[-1]].T
    axes = rates[:, :3]
    velocities = (rates[:, 3:] - np.cross(axes, homes[-1, :, 3]))[..., None]
    cross = np.cross(axes[:, None], -np.eye(3))  # (J, 3, 3): across @ v is axis x v
    cross_squared = cross @ cross
    moves = np.concatenate([cross, cross_squared, velocities, cross @ velocities, cross_squared @ velocities], axis=-1)
    return ScrewChain(positions[-1], moves, homes, list(map(len, positions)))


def _velocity_jacobian(plant: MultibodyPlant, context: Context, frame: Frame, base: Frame) -> Array:
    """Angular and linear velocity of a frame in the base per rate of every position, (6, nq)."""
    wrt = JacobianWrtVariable.kQDot
    return plant.CalcJacobianSpatialVelocity(context, wrt, frame, np.zeros(3), base, base)


@dataclass(frozen=True, eq=False)
class PlantFinger:
    """A finger of one model instance of a plant.

    Use it once the plant is finalized; a model that is read later may change its name.
    """

    finger: Finger
    plant: MultibodyPlant
    model: ModelInstanceIndex
    # Springs of the bending joints, then of the other turning joints, if they are not pairs of linear springs.
    torsion_springs: tuple[RevoluteSpring, ...] = ()

    @property
    def name(self) -> str:
        """Name in blocks and signals: the finger's name; "{model}.{finger}" if another model has one of that name."""
        finger_name = self.finger.name
        is_unique = self.plant.NumBodiesWithName(link_name(finger_name, 0)) == 1
        return finger_name if is_unique else f"{self.model_name}.{finger_name}"

    @property
    def model_name(self) -> str:
        return str(self.plant.GetModelInstanceName(self.model))

    @cached_property
    def links(self) -> list[RigidBody]:
        """Links from the base to the tip, N + 1; the frame of the first is frame B."""
        names = (link_name(self.finger.name, i) for i in range(self.finger.segments + 1))
        return [self.plant.GetBodyByName(name, self.model) for name in names]

    @cached_property
    def joints(self) -> list[Joint]:
        """Joints that bend the finger in its plane, from the base to the tip, N."""
        return self.joints_of("bending")

    def joints_of(self, deformation: str) -> list[Joint]:
        """Joints of one deformation, see `finger_parts.AXES`, from the base to the tip, N."""
        return _find_joints(self.plant, self.model, self.finger, deformation)

    @cached_property
    def frames(self) -> list[Frame]:
        """Frames at the joints, fixed to the links beyond them, and at the tip, N + 1."""
        tip = self.plant.GetFrameByName(tip_name(self.finger.name), self.model)
        return [*(link.body_frame() for link in self.links[1:]), tip]

    @cached_property
    def screws(self) -> ScrewChain:
        """The poses of its links and its tip in frame B, N + 2 frames."""
        return screw_chain(self.plant, [self.base.body_frame(), *self.frames])

    @property
    def base(self) -> RigidBody:
        return self.links[0]

    @property
    def is_anchored(self) -> bool:
        """Whether the base is welded to the world."""
        return bool(self.plant.IsAnchored(self.base))

    @cached_property
    def X_WB(self) -> RigidTransform:  # noqa: N802
        """The base frame in the world in the plant's default context, as a simulation begins."""
        return self.plant.EvalBodyPoseInWorld(self.plant.CreateDefaultContext(), self.base)

    @cached_property
    def has_implicit_springs(self) -> bool:
        """Whether its springs are actuators, which a discrete plant solves implicitly."""
        name = self.joints[0].name()
        return bool(self.plant.GetJointActuatorByName(name, self.model).has_controller())

    @property
    def actuator_names(self) -> list[str]:
        """The joints that the actuators of the model drive, in the order of the actuators."""
        indices = self.plant.GetJointActuatorIndices(self.model)
        return [self.plant.get_joint_actuator(index).joint().name() for index in indices]

    def position_selector(self, deformation: str = "bending") -> Array:
        """Matrix that selects the joint positions, rad or m, from the plant's state, (N, nq + nv)."""
        starts = [joint.position_start() for joint in self.joints_of(deformation)]
        return np.eye(self.plant.num_multibody_states())[starts]

    def torque_selector(self, deformation: str = "bending") -> Array:
        """Matrix that selects joints from the generalized forces of their model, (N, model's nv)."""
        plant_selector = np.zeros((len(self.joints), self.plant.num_velocities()))
        starts = [joint.velocity_start() for joint in self.joints_of(deformation)]
        plant_selector[np.arange(len(starts)), starts] = 1.0
        return np.array([self.plant.GetVelocitiesFromArray(self.model, row) for row in plant_selector])

    def actuator_selector(self, deformation: str = "bending") -> Array:
        """Matrix that assigns joint torques, or forces, to the actuators of their model, (N, nu)."""
        names = self.actuator_names
        return np.eye(len(names))[[names.index(joint.name()) for joint in self.joints_of(deformation)]]


def _find_joints(plant: MultibodyPlant, model: ModelInstanceIndex, finger: Finger, deformation: str) -> list[Joint]:
    names = (joint_name(finger.name, i, deformation) for i in range(finger.segments))
    return [plant.GetJointByName(name, model) for name in names]


def add_torsion_springs(plant: MultibodyPlant, model: ModelInstanceIndex, finger: Finger) -> PlantFinger:
    """Adds a torsion spring at every turning joint of a finger expanded without springs.

    They are Drake's force element, whose torque is the stiffness times the angle at any angle; the pair of linear
    springs of the expanded URDF approximates that, see `finger_links`. Their stiffness is a parameter of the plant's
    context (`RevoluteSpring.SetStiffness`), that of linear springs is not. The plant is not yet finalized.
    """
    stiffnesses = {name: stiffness for name, stiffness in finger.stiffnesses.items() if name not in SLIDES}
    springs = [
        RevoluteSpring(joint, 0.0, stiffness)
        for name in sorted(stiffnesses)  # bending first
        for joint, stiffness in zip(_find_joints(plant, model, finger, name), stiffnesses[name], strict=True)
    ]
    return PlantFinger(finger, plant, model, tuple(plant.AddForceElement(spring) for spring in springs))
