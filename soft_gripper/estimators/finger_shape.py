"""FingerShape: estimated joint positions -> places of joints and tip, and arcs.

This is the contract between estimators and users of the shape. An estimator is a system with the output port
`estimated_joint_angles` (N) rad; it takes the inputs it needs of the readings (`strain`, or the quantity of its
sensors), `pressure`, `driving_torque` and `X_WB`, by these names. This block derives the rest of the shape from the
joint angles; an estimator with better values puts them out under the same names. One with a covariance adds
`joint_angle_covariance` (N x N) rad^2.
"""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from soft_gripper.array_block import ArrayBlock
from soft_gripper.arrays import Array, Planar
from soft_gripper.estimators.arcs import ArcCurve, Arcs, join_arcs
from soft_gripper.estimators.plane import from_base
from soft_gripper.fingers.finger import Finger
from soft_gripper.fingers.kinematics import as_points, in_space
from soft_gripper.fingers.spatial_chain import Posture, SpatialChain, posture, vector_product
from soft_gripper.signals import POSE, XYZ, XZ

ANGLES = "estimated_joint_angles"
TIP = "estimated_tip_position"
ARC = ("x", "z", "heading", "kappa", "length", "center_x", "center_z")
ARC_UNITS = ("m", "m", "rad", "1/m", "m", "m", "m")
POSE_UNITS = ("m", "m", "rad")
BENDS = ("bending",)


class Places:
    """Joints and tip of a finger in space, and their derivatives by its joint positions."""

    def __init__(self, finger: Finger, deformations: Sequence[str]):
        chain = self._chain = SpatialChain.from_yields(finger.segments, finger.segment_length, deformations)
        self._to_chain = chain.position_indices(deformations)
        self._from_chain = np.argsort(self._to_chain)
        frames = chain.link_frames(np.arange(1, finger.segments + 1))
        self._frames = np.append(frames, frames[-1])
        self._half = finger.segment_length / 2
        self._moved = self._frames > np.arange(len(chain.deformations))[:, None]

    def __call__(self, q: Array) -> tuple[Array, Array]:
        """Places P = N + 1 of joints and tip, (..., P, 3) m in B, and the direction of the tip, (..., 3).

        `q` are the joint positions, (..., D).
        """
        return self._positions(posture(self._chain, q[..., self._to_chain]))

    def _positions(self, bent: Posture) -> tuple[Array, Array]:
        tip_direction = bent.rotations[..., -1, :, 2]
        places = bent.origins[..., self._frames, :]
        places[..., -1, :] += self._half * tip_direction
        return places, tip_direction

    def place_jacobian(self, q: Array) -> Array:
        """Derivatives of the places by the joint positions, (..., D, P, 3) m/rad, or 1."""
        bent = posture(self._chain, q[..., self._to_chain])
        places, screws = self._positions(bent)[0], bent.screws[..., None, :]
        jacobian = vector_product(screws[..., :3], places[..., None, :, :]) + screws[..., 3:]
        return np.asarray((jacobian * self._moved[..., None])[..., self._from_chain, :, :])

    def variance(self, q: Array, covariance: Array) -> Array:
        """Variances of joints and tip along x, y and z, m^2, (..., N + 1, 3).

        Args:
            q: joint positions, (..., D).
            covariance: of these, (..., D, D).
        """
        jacobian = np.moveaxis(self.place_jacobian(q), -3, -1)  # (..., P, 3, D)
        return np.asarray(np.maximum(((jacobian @ covariance[..., None, :, :]) * jacobian).sum(axis=-1), 0))


def position_std(finger: Finger, q: Array, covariance: Array) -> Array:
    """Standard deviations of the distances of joints and tip from their estimated positions, m, (..., N + 1).

    Args:
        finger: the nominal one, which only bends.
        q: estimated joint angles, rad, (..., N).
        covariance: of these, rad^2, (..., N, N).
    """
    return np.sqrt(Places(finger, BENDS).variance(q, covariance).sum(axis=-1))


def segment_arcs(finger: Finger, q: Array) -> Arcs:
    """The chain at joint angles (..., N) rad as a curve, an arc for every segment."""
    return join_arcs(q, np.full(finger.segments, finger.segment_length))


def planar_pose(place: Planar, heading: Array) -> Array:
    """Values of ports such as `tip_pose`, (..., 3): x, z, heading."""
    return np.concatenate([as_points(place), heading[..., None]], axis=-1)


def arc_table(arcs: Arcs) -> Array:
    """Values of the port `arcs`, (..., S, 7): start, heading and shape of each arc, and its centre for drawing."""
    bends = np.stack([arcs.heading, arcs.kappa, np.broadcast_to(arcs.length, arcs.theta.shape)], axis=-1)
    return np.concatenate([as_points(arcs.start), bends, as_points(arcs.centers)], axis=-1)


class FingerShape(ArrayBlock):
    """The pose of one finger from its estimated joint angles.

    ::

        estimated_joint_angles (N) rad ---> +-------------+ ---> arcs                   (N x 7) an arc a segment
                                            | FingerShape | ---> joint_positions        (N x 2) x, z; m in B
        X_WB (12) [R | p] ----------------> |             | ---> joint_positions_world  (N x 3) m
                                            +-------------+ ---> tip_pose               (3) x, z, heading in B

    Matrices leave their ports row after row. Stateless.
    """

    def __init__(self, finger: Finger):
        super().__init__()
        self.take(ANGLES, finger.segments)
        self.take("X_WB", 12)
        put_out_places(self, finger, BENDS, ANGLES)


def put_out_places(block: ArrayBlock, finger: Finger, deformations: Sequence[str], q: str) -> None:
    """Declares the step "places" and the outputs of FingerShape in a block with the input X_WB.

    `q` is the step with the joint positions, (..., D).
    """
    joints, places, N = range(finger.segments), Places(finger, deformations), finger.segments
    block.derive("places", lambda q: (*places(q), q[..., :N].sum(axis=-1)), q)
    put_out_arcs(block, lambda q: segment_arcs(finger, q[..., :N]), q, segment=joints)
    block.put_out(
        *("joint_positions", lambda places: places[0][..., :-1, ::2], "places"), unit="m", joint=joints, xz=XZ
    )
    block.put_out(
        "joint_positions_world",
        lambda places, X_WB: from_base(X_WB, places[0][..., :-1, :]),
        *("places", "X_WB"),
        unit="m",
        joint=joints,
        xyz=XYZ,
    )
    block.put_out("tip_pose", _tip_pose, "places", unit=POSE_UNITS, pose=POSE)


def _tip_pose(places: tuple[Array, Array, Array]) -> Array:
    """Pose of the tip in the bending plane, (..., 3); its heading follows the bends beyond half a turn."""
    positions, tip_direction, bend = places
    heading = np.arctan2(tip_direction[..., 0], tip_direction[..., 2])
    heading = heading + 2 * np.pi * np.round((bend - heading) / (2 * np.pi))
    return np.concatenate([positions[..., -1, ::2], heading[..., None]], axis=-1)


def put_out_arcs(block: ArrayBlock, arcs: Callable[..., Arcs], source: str, **axis: Sequence[int]) -> None:
    """Declares the output `arcs` of a block, computed by a function from a step, along the named axis."""
    axes: dict[str, Any] = {**axis, "arc": ARC}
    block.put_out("arcs", lambda step: arc_table(arcs(step)), source, unit=ARC_UNITS, **axes)


def put_out_curve(block: ArrayBlock, curve: str, joints: Sequence[int]) -> None:
    """Declares the pose outputs of a block with the input X_WB; `curve` is the step that they come from."""

    def world(curve: ArcCurve, X_WB: Array) -> Array:
        return from_base(X_WB, in_space(curve.joints))

    block.put_out("joint_positions", lambda curve: as_points(curve.joints), curve, unit="m", joint=joints, xz=XZ)
    tip_pose = "tip_pose", lambda curve: planar_pose(curve.tip, curve.tip_heading), curve
    block.put_out(*tip_pose, unit=POSE_UNITS, pose=POSE)
    block.put_out("joint_positions_world", world, curve, "X_WB", unit="m", joint=joints, xyz=XYZ)
