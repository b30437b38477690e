"""Contacts on every side of a finger that leaves its plane, in balance, computed by statics."""

from dataclasses import replace
from functools import cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from soft_gripper.arrays import Array
from soft_gripper.extras.studies.contacts.dataset import G, read_finger
from soft_gripper.fingers.finger import Finger
from soft_gripper.fingers.spatial_chain import Loads, posture, spatial_chain, torques, weights

WAYS = ("bending", "sideways", "twist")
PLACES = 0.1, 0.99  # of the length
FORCES, PRESSURES = (0.1, 1.0), (0.0, 120e3)  # N, Pa
ACROSS = 0.8  # of the width of a face, within which forces act
MOST_BEND = 2.6  # rad, of the whole finger
_REPETITIONS, _STEP, _BALANCED = 200, 0.6, 1e-8  # rad


class SpatialContacts(NamedTuple):
    """M contacts in balance, each one force on a face."""

    q: Array  # (M, D) joint positions, way after way
    pressure: Array  # (M,) Pa
    gravity: Array  # (M, 3) m/s^2 in B
    arc_length: Array  # (M,) m
    normal_force: Array  # (M,) N
    force: Array  # (M, 3) N in B, friction included

    def at(self, rows: NDArray[np.int_] | NDArray[np.bool_]) -> "SpatialContacts":
        """Some of them."""
        return SpatialContacts(*(values[rows] for values in self))


@cache
def finger_in_space() -> Finger:
    """The shipped finger, which yields sideways and in twist as well."""
    return replace(read_finger(), yields=WAYS)


def contacts_in_space(
    number: int, friction: Array | float, seed: int, places: tuple[float, float] = PLACES, faces: int = 4
) -> SpatialContacts:
    """About `number` contacts at random places on the four faces, or on the inner and the outer one, if `faces` is 2.

    Pressures and weights are random too.

    `friction` is the coefficient, one for all or (number); its direction on the face is random. Contacts that bend the
    finger by more than MOST_BEND, or for which no balance is found, are left out.
    """
    rng, finger = np.random.default_rng(seed), finger_in_space()
    s, joints = finger.length * rng.uniform(*places, number), finger.joint_arc_lengths
    link = np.searchsorted(joints, s)
    angle, turn = rng.integers(faces, size=number) * 2 * np.pi / faces, rng.uniform(0, 2 * np.pi, number)
    normal = np.stack([np.cos(angle), np.sin(angle), np.zeros(number)], axis=-1).round()
    across = np.stack([-normal[:, 1], normal[:, 0], np.zeros(number)], axis=-1)
    section = finger.section(s)
    depth, middle = (section.inner_face - section.outer_face) / 2, (section.inner_face + section.outer_face) / 2
    half = np.stack([depth, np.broadcast_to(section.width / 2, s.shape), np.zeros(number)], axis=-1)
    place = (normal + rng.uniform(-ACROSS, ACROSS, number)[:, None] * across) * half
    place[:, 0] += middle
    place[:, 2] += s - np.append(0.0, joints)[link]
    along = np.array([0.0, 0.0, 1.0])
    rubbing = np.cos(turn)[:, None] * across + np.sin(turn)[:, None] * along
    size = rng.uniform(*FORCES, number)
    local = size[:, None] * (np.broadcast_to(friction, number)[:, None] * rubbing - normal)
    direction = rng.standard_normal((number, 3))
    gravity = G * rng.uniform(size=number)[:, None] * direction / np.linalg.norm(direction, axis=-1, keepdims=True)
    pressure = rng.uniform(*PRESSURES, number)
    q, force = np.empty((number, 3 * finger.segments)), np.empty((number, 3))
    for i in range(finger.segments + 1):
        at = link == i
        q[at], force[at] = _in_balance(finger, i, pressure[at], gravity[at], place[at], local[at])
    kept = np.isfinite(q).all(axis=-1) & (np.abs(q[:, : finger.segments]).sum(axis=-1) < MOST_BEND)
    return SpatialContacts(q, pressure, gravity, s, size, force).at(kept)


def _in_balance(
    finger: Finger, link: int, pressure: Array, gravity: Array, place: Array, local: Array
) -> tuple[Array, Array]:
    """Joint positions, (M, D), and forces in B, (M, 3), under forces that turn with the link; NaN without balance."""
    chain = spatial_chain(finger)
    own, frame = weights(finger, chain, gravity), int(chain.beyond(np.array(link)))
    driving, stiffness = chain.spread({"bending": finger.pressure_torque(pressure)}), chain.spread(finger.stiffnesses)
    points = np.concatenate([np.broadcast_to(own.points, own.forces.shape), place[:, None]], axis=1)
    q, left, still = driving / stiffness, np.full(driving.shape, np.inf), np.zeros((*points.shape[:2], 3))
    for _ in range(_REPETITIONS):
        at = posture(chain, q)
        force = (at.rotations[:, frame] @ local[..., None])[..., 0]
        loads = Loads(np.append(own.frames, frame), points, np.concatenate([own.forces, force[:, None]], axis=1), still)
        left = (driving + torques(at, loads)) / stiffness - q
        q = q + _STEP * left
    q[np.abs(left).max(axis=-1) > _BALANCED] = np.nan
    return q[:, np.argsort(chain.places(WAYS))], force
