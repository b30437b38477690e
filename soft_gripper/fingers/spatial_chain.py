"""The chain in space: poses of its links, torques of loads at its joints, and its shape in balance with them.

Every joint is a screw in frame B: the axis about which it turns, zero if it slides, and the velocity of the point at
B's origin per rate of the joint (Lynch and Park, *Modern Robotics*, section 5.1). A load's torque at a joint is the
product of screw and wrench. All functions are pure; the leading axes are free, as in `kinematics`, which has the chain
in its plane.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from soft_gripper.arrays import Array
from soft_gripper.errors import SimulationDivergedError
from soft_gripper.fingers.finger import Finger
from soft_gripper.fingers.finger_parts import AXES, SLIDES, joint_order

_LOAD_STEPS = 6
_MAX_ITERATIONS = 100
_POSITION_TOLERANCE = 1e-11  # rad, and m: the last change of a shape in balance
_UNIT_CROSS_MATRICES = np.cross(np.eye(3)[:, None], np.eye(3)).swapaxes(-1, -2).reshape(3, 9)


@dataclass(frozen=True, eq=False)
class SpatialChain:
    """N equal segments with joints in their middles, J in all; a finger, or any rod."""

    deformations: tuple[str, ...]  # (J) deformation of each joint, see `finger_parts.AXES`, from the base to the tip
    segments: NDArray[np.int_]  # (J) segment of each joint
    segment_length: float  # m

    @classmethod
    def from_yields(cls, segments: int, segment_length: float, yields: Sequence[str]) -> "SpatialChain":
        """Makes a chain with these deformations in every segment."""
        deformations = [deformation for i in range(segments) for deformation in joint_order(yields, i)]
        return cls(tuple(deformations), np.repeat(np.arange(segments), len(yields)), segment_length)

    @cached_property
    def axes(self) -> Array:
        """Axes of the joints, (J, 3), in the frame of the link before."""
        return np.array([AXES[deformation] for deformation in self.deformations])

    @cached_property
    def joint_transforms(self) -> tuple[Array, Array]:
        """Transforms from frame to frame: at rest (J, 16), and the terms of cos - 1, sin and position (J, 3, 16).

        A joint lies `heights` along the link before it; there the frame turns, or slides along the axis.
        """
        axes, is_turn = self.axes[..., None], self.turns[:, None, None]
        cross = cross_matrices(self.axes)
        rest_transforms = np.zeros((len(self.deformations), 4, 4)) + np.eye(4)
        rest_transforms[:, 2, 3] = self.heights
        changes = np.zeros((len(self.deformations), 3, 4, 4))
        changes[:, 0, :3, :3], changes[:, 1, :3, :3] = -cross @ cross * is_turn, cross * is_turn
        changes[:, 2, :3, 3:] = axes * ~is_turn
        return rest_transforms.reshape(-1, 16), changes.reshape(-1, 3, 16)

    @cached_property
    def is_planar(self) -> bool:
        """Whether the chain only bends, so that all axes are y of B."""
        return set(self.deformations) == {"bending"}

    @cached_property
    def turns(self) -> NDArray[np.bool_]:
        """Mask of the joints that turn, (J,); the others slide."""
        return np.array([deformation not in SLIDES for deformation in self.deformations])

    @cached_property
    def heights(self) -> Array:
        """Distances of the joints along the links before them, (J,) m."""
        is_first = np.diff(self.segments, prepend=-1) > 0
        return is_first * np.where(self.segments == 0, 0.5, 1.0) * self.segment_length

    def interleaved(self, values: dict[str, Array]) -> Array:
        """Interleaves values of joints by deformation, (..., N) each, to (..., J); missing deformations have 0."""
        shape = np.broadcast_shapes(*(np.shape(value)[:-1] for value in values.values()))
        joints = zip(self.deformations, self.segments, strict=True)
        columns = [values[name][..., i] if name in values else 0.0 for name, i in joints]
        return np.stack([np.broadcast_to(value, shape) for value in columns], axis=-1)

    def separated(self, q: Array) -> dict[str, Array]:
        """Separates joint positions, (..., J), by deformation, (..., N) each."""
        deformations = np.array(self.deformations)
        return {deformation: q[..., deformations == deformation] for deformation in dict.fromkeys(self.deformations)}

    def position_indices(self, deformations: Sequence[str]) -> NDArray[np.int_]:
        """Indices of its joints among those counted deformation after deformation, (J,)."""
        way_indices = np.array([deformations.index(deformation) for deformation in self.deformations])
        return way_indices * (len(self.deformations) // len(deformations)) + self.segments

    def link_frames(self, link: NDArray[np.int_]) -> NDArray[np.int_]:
        """Frame of each link, (...); links count from 0 at the base to N."""
        return np.searchsorted(self.segments, link)


def spatial_chain(finger: Finger) -> SpatialChain:
    """The chain of a finger that does not shear."""
    return SpatialChain.from_yields(finger.segments, finger.segment_length, finger.yields)


class Posture(NamedTuple):
    """A bent chain in B; frame j is that beyond j joints, 0 is B."""

    frames: Array  # (..., J + 1, 4, 4), each a rotation and an origin, m
    motions: Array  # of the joints, (..., J, 3, 4): a point p is moved by the product with (p, 1)

    @property
    def rotations(self) -> Array:
        """Rotations of the frames, (..., J + 1, 3, 3)."""
        return self.frames[..., :3, :3]

    @property
    def origins(self) -> Array:
        """Origins of the frames, (..., J + 1, 3) m."""
        return self.frames[..., :3, 3]

    @property
    def screws(self) -> Array:
        """Screws of the joints, (..., J, 6): turning, and velocity of the point at B's origin."""
        skew_entries = self.motions[..., [2, 0, 1], [1, 2, 0]]
        return np.concatenate([skew_entries, self.motions[..., 3]], axis=-1)


def posture(chain: SpatialChain, q: Array) -> Posture:
    """The posture at joint positions, (..., J) rad, and m where joints slide."""
    if chain.is_planar:
        return _planar_posture(chain, q)
    joints, (rest, changes) = len(chain.deformations), chain.joint_transforms
    joint_terms = np.empty((*q.shape, 1, 3))
    joint_terms[..., 0, 0], joint_terms[..., 0, 1], joint_terms[..., 0, 2] = np.cos(q) - 1, np.sin(q), q
    steps = ((joint_terms @ changes)[..., 0, :] + rest).reshape(*q.shape, 4, 4)
    frames = _products(steps, joints // (chain.segments[-1] + 1))
    outer_frames = frames[..., 1:, :, :]
    axes = (outer_frames[..., :3, :3] @ chain.axes[:, :, None])[..., 0]
    from_origin = np.empty((*q.shape, 3, 4))
    from_origin[..., :3], from_origin[..., 3] = np.eye(3), -outer_frames[..., :3, 3]
    motions = cross_matrices(axes) @ from_origin
    if not chain.turns.all():
        motions[..., :3] *= chain.turns[:, None, None]
        motions[..., 3][..., ~chain.turns, :] = axes[..., ~chain.turns, :]
    return Posture(frames, motions)


def _planar_posture(chain: SpatialChain, q: Array) -> Posture:
    """The posture of a chain that only bends: angles about one axis add up, which is much quicker than products."""
    headings, lengths = q.cumsum(axis=-1), chain.heights[1:]
    pose_terms = np.empty((*q.shape, 5))  # cos, sin, x, z and 1 of each joint
    cos, sin = pose_terms[..., 0], pose_terms[..., 1]
    np.cos(headings, out=cos)
    np.sin(headings, out=sin)
    pose_terms[..., 0, 2:], pose_terms[..., 4] = (0.0, 0.0, 1.0), 1.0
    np.cumsum(lengths * sin[..., :-1], axis=-1, out=pose_terms[..., 1:, 2])
    np.cumsum(lengths * cos[..., :-1], axis=-1, out=pose_terms[..., 1:, 3])
    pose_terms[..., 3] += chain.heights[0]
    frames = np.empty((*q.shape[:-1], q.shape[-1] + 1, 4, 4))
    frames[..., 0, :, :], frames[..., 1:, :, :] = np.eye(4), (pose_terms @ _PLANAR_FRAME).reshape(*q.shape, 4, 4)
    frames[..., 1:, [0, 2], 3] = pose_terms[..., 2:4]  # finite if the angle beyond is NaN
    return Posture(frames, (pose_terms @ _PLANAR_MOTION).reshape(*q.shape, 3, 4))


def _entries(size: int, **places: tuple[int, ...]) -> Array:
    """Matrix from cos, sin, x, z and 1 to the entries of a matrix: each adds to the given entries, or is subtracted."""
    entries = np.zeros((5, size))
    for name, signed_indices in places.items():
        for place in signed_indices:
            entries[("cos", "sin", "x", "z", "one").index(name), abs(place)] = np.sign(place) or 1.0
    return entries


_PLANAR_FRAME = _entries(16, cos=(0, 10), sin=(2, -8), one=(5, 15))
_PLANAR_MOTION = _entries(12, one=(2, -8), z=(-3,), x=(11,))


def _products(steps: Array, joints_per_segment: int) -> Array:
    """Products of J matrices up to each of them, the identity first, (..., J + 1, 4, 4).

    Products within segments come first, then those over segments: over 2, over 4 and so on.
    """
    segment_steps = steps.reshape(*steps.shape[:-3], steps.shape[-3] // joints_per_segment, joints_per_segment, 4, 4)
    for j in range(1, joints_per_segment):
        segment_steps[..., j, :, :] = segment_steps[..., j - 1, :, :] @ segment_steps[..., j, :, :]
    products = np.empty((*steps.shape[:-3], steps.shape[-3] + 1, 4, 4))
    products[..., 0, :, :] = np.eye(4)
    segment_products = products[..., :-1:joints_per_segment, :, :]  # of all segments before
    segment_products[..., 1:, :, :] = segment_steps[..., :-1, -1, :, :]
    step, segments = 1, segment_products.shape[-3]
    while step < segments:
        segment_products[..., step:, :, :] = segment_products[..., :-step, :, :] @ segment_products[..., step:, :, :]
        step *= 2
    products[..., 1:, :, :] = (segment_products[..., None, :, :] @ segment_steps).reshape(steps.shape)
    return products


def cross_matrices(a: Array) -> Array:
    """Matrices of the products  a x  , (..., 3) -> (..., 3, 3)."""
    return np.asarray(a @ _UNIT_CROSS_MATRICES).reshape(*a.shape, 3)


def vector_product(a: Array, b: Array) -> Array:
    """a x b, (..., 3); a few times as fast as numpy's."""
    next_axis, previous_axis = [1, 2, 0], [2, 0, 1]
    return np.asarray(a[..., next_axis] * b[..., previous_axis] - a[..., previous_axis] * b[..., next_axis])


class Loads(NamedTuple):
    """Dead loads on M points of a chain: forces and moments that keep their directions in B."""

    frames: NDArray[np.int_]  # (M) to which the points are fixed, see `Posture`
    points: Array  # (..., M, 3) m in these frames
    forces: Array  # (..., M, 3) N
    moments: Array  # (..., M, 3) N m

    def positions(self, bent: Posture) -> Array:
        """Positions of the points, (..., M, 3) m in B."""
        rotated_points = bent.rotations[..., self.frames, :, :] @ self.points[..., None]
        return bent.origins[..., self.frames, :] + rotated_points[..., 0]

    def times(self, fraction: float) -> "Loads":
        return self._replace(forces=fraction * self.forces, moments=fraction * self.moments)


def torques(bent: Posture, loads: Loads) -> Array:
    """Torques of loads at the joints, N m, and N where joints slide, (..., J)."""
    return np.asarray((bent.screws * _wrenches(bent, loads)).sum(axis=-1))


def _outboard_sums(bent: Posture, loads: Loads, values: Array) -> Array:
    """Sums over the points that each joint moves, (..., M, K) -> (..., J, K)."""
    is_moved = loads.frames > np.arange(bent.screws.shape[-2])[:, None]
    return np.asarray(is_moved.astype(float) @ values)


def _wrenches(bent: Posture, loads: Loads) -> Array:
    """Wrenches of all loads beyond each joint, about B's origin: moment and force, (..., J, 6)."""
    moments = np.cross(loads.positions(bent), loads.forces) + loads.moments
    return _outboard_sums(bent, loads, np.concatenate(np.broadcast_arrays(moments, loads.forces), axis=-1))


def torque_slopes(bent: Posture, loads: Loads) -> Array:
    """Derivatives of `torques` by the joint positions, (..., J, J): of the torque at j by the position of i.

    A joint i moves all beyond it: points, and for i < j the screw of joint j. So with the wrench
    (m, f) and the sums  A = sum (p f' - p . f)  of what the outer of the two joints carries, and screws (w, v),

        i < j:  w_i . (A_j' w_j + w_j x m_j + v_j x f_j)
        j <= i: w_j . (A_i w_i + v_i x f_i) .
    """
    places = loads.positions(bent)
    w, v = bent.screws[..., :3], bent.screws[..., 3:]
    wrench = _wrenches(bent, loads)
    m, f = wrench[..., :3], wrench[..., 3:]
    products = places[..., :, None] * loads.forces[..., None, :]
    products = products - np.trace(products, axis1=-2, axis2=-1)[..., None, None] * np.eye(3)
    A = _outboard_sums(bent, loads, products.reshape(*products.shape[:-2], 9)).reshape(*w.shape[:-1], 3, 3)
    inner = (w[..., None, :] @ A)[..., 0, :] + np.cross(w, m) + np.cross(v, f)
    outer = (A @ w[..., None])[..., 0] + np.cross(v, f)
    return np.asarray(np.tril(inner @ w.swapaxes(-1, -2), -1) + np.triu(w @ outer.swapaxes(-1, -2)))


def resting_positions(chain: SpatialChain, stiffness: Array, driving: Array, loads: Loads) -> Array:
    """Joint positions in balance: stiffness times position is the torque of drive and loads, (..., J).

    Found by Newton's method, the loads growing in a few steps.

    Args:
        chain: of J joints.
        stiffness: of the joints, (J,) N m/rad, and N/m where they slide.
        driving: torques of a pressure, (..., J) N m, and N.
        loads: of the chain, its weight among them.

    Raises:
        SimulationDivergedError: if no balance is found.
    """
    q = driving / stiffness + np.zeros((*loads.forces.shape[:-2], len(chain.deformations)))
    for fraction in np.arange(1, _LOAD_STEPS + 1) / _LOAD_STEPS:
        for _ in range(_MAX_ITERATIONS):
            bent = posture(chain, q)
            step_loads = loads.times(fraction)
            residual = driving + torques(bent, step_loads) - stiffness * q
            step = np.linalg.solve(np.diag(stiffness) - torque_slopes(bent, step_loads), residual[..., None])[..., 0]
            q = q + step
            if np.abs(step).max() < _POSITION_TOLERANCE:
                break
        else:
            raise SimulationDivergedError("no equilibrium found under the loads")
    return q


def weights(finger: Finger, chain: SpatialChain, gravity: Array) -> Loads:
    """The weight of a finger's links; `gravity` is (..., 3) m/s^2 in B."""
    links = finger.links
    x, z = links.center
    forces = gravity[..., None, :] * links.mass[:, None]
    points = np.stack([x, np.zeros(x.shape), z], axis=-1)
    return Loads(chain.link_frames(np.arange(finger.segments + 1)), points, forces, np.zeros(forces.shape))
