"""Joints that follow others, such as those of a parallelogram: <mimic> in URDF and SDFormat."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from soft_gripper.arrays import Array
from soft_gripper.model_import.imported_model import Mimic


@dataclass(frozen=True)
class Couplings:
    """Positions q of all n joints from those p of the k that follow no other: q = matrix p + offset."""

    leads: NDArray[np.int_]  # (k,) indices of the joints that follow no other
    matrix: Array  # (n, k)
    offset: Array  # (n,) rad or m

    def full(self, leader_positions: Array) -> Array:
        """Positions of all joints, (..., n), from those of the joints that follow no other, (..., k)."""
        positions = leader_positions @ self.matrix.T + self.offset
        positions[..., self.leads] = leader_positions  # free of rounding, and of what is wrong with others
        return positions

    def follow_leaders(self, positions: Array) -> Array:
        """Positions, (..., n), with the followers put where their leaders demand."""
        return self.full(positions[..., self.leads])

    def leader_efforts(self, efforts: Array) -> Array:
        """Efforts, (..., n), with those of followers carried by their leaders; followers have none."""
        leader_efforts = np.zeros_like(efforts)
        leader_efforts[..., self.leads] = efforts @ self.matrix
        return leader_efforts


def couplings(joints: Sequence[str], mimics: Sequence[Mimic] = ()) -> Couplings:
    """Couplings of joints by their names; none follows itself through others."""
    laws = {mimic.joint: mimic for mimic in mimics}
    leader_names = [name for name in joints if name not in laws]
    matrix, offset = np.zeros((len(joints), len(leader_names))), np.zeros(len(joints))
    for i, name in enumerate(joints):
        factor = 1.0
        while (law := laws.get(name)) is not None:
            offset[i] += factor * law.offset
            factor, name = factor * law.multiplier, law.leader
        matrix[i, leader_names.index(name)] = factor
    return Couplings(np.array([joints.index(name) for name in leader_names], dtype=int), matrix, offset)
