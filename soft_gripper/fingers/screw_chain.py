"""A finger in its plant as screws: poses of its links in its base, at many states at once.

The plant gives the screw axis of every joint from a finger's base to its tip once; joints may turn or slide. All
samples are then computed at once, by the product of exponentials (Lynch and Park,
Modern Robotics, section 4.1).
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import Frame, JacobianWrtVariable
from pydrake.systems.framework import Context

from soft_gripper.arrays import Array


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
