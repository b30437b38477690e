"""A finger in space that is pushed in one place: its shape at rest, and how that follows from the push.

A push is a force F in B, constant in direction, at the arc length s and at y across the finger. A link is rigid, so
that the force may be shared among the ends of its link and both edges, linearly in s and y: then the points of all
loads are fixed, and the torques are linear in F for a place, and in the place for a force.

Near balance, with the stiffness K of the springs less the slope of the torques of all loads, the joints follow by

    dq = K^-1 (dtau/dF dF + dtau/ds ds + dtau/dy dy + driving db) ,

b being a share by which the drive is larger than is known.

Leading axes are free; D joints, way after way; C pressures, M points of loads.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from soft_gripper.arrays import Array
from soft_gripper.fingers.finger import Finger
from soft_gripper.fingers.spatial_chain import (
    Loads,
    Posture,
    SpatialChain,
    posture,
    resting_positions,
    spatial_chain,
    torque_slopes,
    torques,
    weights,
)
from soft_gripper.sensors.measurement import ways_in_space

UNKNOWNS = ("F_x", "F_y", "F_z", "s", "y", "b")


class Push(NamedTuple):
    """A force at a place of the finger."""

    force: Array  # (..., 3) N in B
    s: Array  # (...) m, arc length
    y: Array  # (...) m across the finger


class Response(NamedTuple):
    """Response of the joints to what acts on them."""

    missing: Array  # (..., D), the step to where they balance it
    slopes: Array  # (..., D, 6) by the unknowns of a push and by b


@dataclass(frozen=True, eq=False)
class PushedFinger:
    """The statics of a finger with linear springs."""

    finger: Finger
    gravity: Array  # (3,) m/s^2 in B

    @cached_property
    def ways(self) -> tuple[str, ...]:
        """In which the joints yield, in their order here."""
        return ways_in_space(self.finger)

    def driving(self, pressures: Array) -> Array:
        """Torques of pressures, (..., C) Pa -> (..., D) N m, and N where joints slide."""
        driven, none = self.finger.driven_ways, np.zeros((*np.shape(pressures)[:-1], self.finger.segments))
        each = [self.finger.torque_of_drive(way, pressures) if way in driven else none for way in self.ways]
        return np.concatenate(each, axis=-1)

    def at_rest(self, driving: Array, push: Push) -> Array:
        """Joint positions in balance, (..., D).

        Raises:
            SimulationDivergedError: if no balance is found.
        """
        loads = self._loads(self._forces(self._shares(push)[0], push.force))
        q = resting_positions(self._chain, self._stiffness, driving[..., self._in_chain], loads)
        return q[..., self._from_chain]

    def response(self, q: Array, driving: Array, push: Push) -> Response:
        """Response of joints at `q`, (..., D), to what acts on them."""
        at, (share, by_s, by_y) = posture(self._chain, q[..., self._in_chain]), self._shares(push)
        loads, driving = self._loads(self._forces(share, push.force)), driving[..., self._in_chain]
        missing = driving + torques(at, loads) - self._stiffness * q[..., self._in_chain]
        units = [self._forces(share, np.broadcast_to(unit, push.force.shape)) for unit in np.eye(3)]
        moved = [self._forces(slope, push.force) for slope in (by_s, by_y)]
        by_push = torques(_for_each(at), self._pushing(np.stack([*units, *moved], axis=-3)))  # (..., 5, D)
        wanted = np.concatenate([missing[..., None, :], by_push, driving[..., None, :]], axis=-2)
        K = np.diag(self._stiffness) - torque_slopes(at, loads)
        found = np.linalg.solve(K, np.swapaxes(wanted, -1, -2))[..., self._from_chain, :]
        return Response(found[..., 0], found[..., 1:])

    def across(self, q: Array, s: Array) -> Array:
        """Directions across the finger at arc lengths (...) m, of joints at `q`, (..., D): two rows, (..., 2, 3) in B.

        The first is the normal of the inner face, the second leads to the left.
        """
        at = posture(self._chain, q[..., self._in_chain])
        frames = self._chain.beyond(np.sum(self.finger.joint_arc_lengths < s[..., None], axis=-1))
        R = np.take_along_axis(at.rotations, frames[..., None, None, None], axis=-3)[..., 0, :, :]
        return np.asarray(np.swapaxes(R, -1, -2)[..., :2, :])

    @cached_property
    def half_width(self) -> float:
        """m, where the finger is narrowest."""
        return min(float(section.width) for section in self.finger.cross_sections) / 2

    def _shares(self, push: Push) -> tuple[Array, Array, Array]:
        """Shares of a force at the points, and their slopes by s and by y, (..., M) each."""
        ends, half = self.finger.link_ends, self.half_width
        s = np.clip(push.s, 0, ends[-1])[..., None]
        link = np.clip(np.searchsorted(ends, s[..., 0], side="left") - 1, 0, len(ends) - 2)
        on_link = (link[..., None] == np.arange(len(ends) - 1)).astype(float)  # (..., N + 1)
        t, u = (s - ends[:-1]) / np.diff(ends), (push.y / half + 1)[..., None] / 2
        along, across = np.stack([1 - t, t], axis=-1), np.stack([1 - u, u], axis=-1)
        by_s = np.array([-1.0, 1.0]) / np.diff(ends)[:, None] + 0 * along
        by_y = np.array([-0.5, 0.5]) / half + 0 * across

        def product(a: Array, b: Array) -> Array:
            points = on_link[..., None, None] * a[..., :, None] * b[..., None, :]
            return np.asarray(points.reshape(*points.shape[:-3], -1))

        return product(along, across), product(by_s, across), product(along, by_y)

    def _forces(self, shares: Array, force: Array) -> Array:
        """At the points, (..., M, 3) N."""
        return shares[..., None] * force[..., None, :]

    def _pushing(self, forces: Array) -> Loads:
        frames, points = self._points
        return Loads(frames, points, forces, np.zeros_like(forces))

    def _loads(self, forces: Array) -> Loads:
        """Loads of these forces and of the weight."""
        own, (frames, points) = weights(self.finger, self._chain, self.gravity), self._points
        of_weight = np.broadcast_to(own.forces, (*forces.shape[:-2], *own.forces.shape))
        both = np.concatenate([of_weight, forces], axis=-2)
        return Loads(
            np.concatenate([own.frames, frames]), np.concatenate([own.points, points]), both, np.zeros_like(both)
        )

    @cached_property
    def _points(self) -> tuple[NDArray[np.int_], Array]:
        """Frames and places of the points at which pushes act: ends of links, and the edges at each."""
        lengths = np.diff(self.finger.link_ends)
        frames = np.repeat(self._chain.beyond(np.arange(len(lengths))), 4)
        places = [(0.0, y, z) for length in lengths for z in (0.0, length) for y in (-self.half_width, self.half_width)]
        return frames, np.array(places)

    @cached_property
    def _chain(self) -> SpatialChain:
        return spatial_chain(self.finger)

    @cached_property
    def _in_chain(self) -> NDArray[np.int_]:
        return self._chain.places(self.ways)

    @cached_property
    def _from_chain(self) -> NDArray[np.int_]:
        return np.argsort(self._in_chain)

    @cached_property
    def _stiffness(self) -> Array:
        return self._chain.spread(self.finger.stiffnesses)


def _for_each(at: Posture) -> Posture:
    """The posture, with an axis for several loads."""
    return Posture(*(each[..., None, :, :, :] for each in at))
