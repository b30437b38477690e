"""Contacts in balance, computed by statics: forces on the faces of a finger, with any friction, one or several.

In: a number and a seed. Out: `Contacts`. Another kind of contact is a function that draws `Forces` and gives them to
`balanced_contacts`.

A force turns with the link that it presses on: it is fixed in the link's frame, as its place is. M contacts, K forces
of each.
"""

from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from soft_gripper.arrays import Array
from soft_gripper.fingers.finger import Finger
from soft_gripper.fingers.spatial_chain import Loads, posture, spatial_chain, torques, vector_product, weights
from soft_gripper.sensors.measurement import spatial_deformations
from studies.contacts.contacts import INNER, OUTER, Contacts, G, read_finger

MAX_BEND = 2.6  # rad of the whole finger
_REPETITIONS, _STEP, _BALANCED = 200, 0.6, 1e-8  # rad
_SIDES = {"inner": INNER, "outer": OUTER}


class Forces(NamedTuple):
    """Forces on links, in the frames of these."""

    link: NDArray[np.int_]  # (M, K)
    place: Array  # (M, K, 3) m
    force: Array  # (M, K, 3) N


def link_forces(finger: Finger, s: Array, offset: Array, force: Array) -> Forces:
    """Forces on the links at arc lengths (M, K) m, at offsets (M, K, 3) m from the axis there."""
    begins = np.append(0.0, finger.joint_arc_lengths)
    link = np.searchsorted(finger.joint_arc_lengths, s)
    return Forces(link, offset + (s - begins[link])[..., None] * [0.0, 0.0, 1.0], force)


def balanced_contacts(
    finger: Finger,
    pressure: Array,
    gravity: Array,
    forces: Forces,
    normal_force: Array,
    s: Array,
    side: Array,
    mu: Array,
) -> Contacts:
    """Contacts in balance that bend the finger by less than MAX_BEND.

    Args:
        finger: that does not creep.
        pressure, gravity: (M,) Pa and (M, 3) m/s^2 in B.
        forces: of the contacts.
        normal_force, s, side, mu: of the contacts, see `Contacts`; `mu` is their coefficient of friction.
    """
    chain = spatial_chain(finger)
    weight, stiffness = weights(finger, chain, gravity), chain.interleaved(finger.stiffnesses)
    driving = chain.interleaved({"bending": finger.pressure_torque(pressure)})
    link_map = np.swapaxes(forces.link[..., None] == np.arange(finger.segments + 1), -1, -2).astype(float)
    link_forces, link_moments = (link_map @ vector for vector in (forces.force, np.cross(forces.place, forces.force)))

    def load_torques(q: Array) -> tuple[Array, Array, Array]:
        """Torques of weight and contacts at the joints, and the sum of the contacts' forces in B."""
        bent = posture(chain, q)
        R = bent.rotations[..., weight.frames, :, :]
        force, moment = ((R @ vector[..., None])[..., 0] for vector in (link_forces, link_moments))
        contact = Loads(weight.frames, np.zeros((finger.segments + 1, 3)), force, moment)
        return torques(bent, weight), torques(bent, contact), force.sum(axis=-2)

    bending = np.array(chain.deformations) == "bending"

    def deflection(torque: Array) -> Array:
        q: Array = torque / stiffness
        q[:, bending] = finger.angle(torque[:, bending])
        return q

    q = change = deflection(driving)
    for _ in range(_REPETITIONS):
        weight_torque, torque, _ = load_torques(q)
        change = deflection(driving + weight_torque + torque) - q
        q = q + _STEP * change
    _, torque, force = load_torques(q)
    order = np.argsort(chain.position_indices(spatial_deformations(finger)))
    q, torque = q[:, order], torque[:, order]
    is_balanced = (np.abs(change).max(axis=-1) < _BALANCED) & (np.abs(q[:, : finger.segments].sum(axis=-1)) < MAX_BEND)
    return Contacts(finger, q, pressure, gravity, normal_force, force, torque, s, side, mu).subset(is_balanced)


FRICTION = 0.9  # Coulomb, of contacts at rest, at most
FORCES = {"inner": (0.1, 2.0), "outer": (0.1, 1.8)}  # N
PRESSURES = {"inner": (30e3, 150e3), "outer": (-30e3, 100e3)}  # Pa


def rubbing_contacts(
    number: int,
    seed: int,
    friction: Array | float = FRICTION,
    fraction: Array | float | None = None,
    places: tuple[float, float] = (0.1, 1.0),
    finger: Callable[[], Finger] = read_finger,
    forces: Mapping[str, tuple[float, float]] = FORCES,
) -> Contacts:
    """About `number` random contacts in the bending plane, with a fraction of the friction one way or the other.

    `friction`, a coefficient, and `fraction` are one for all or (number); without a fraction, fractions are random.
    `places` are fractions of the length of the finger that `finger` returns, `forces` ranges by side, N.
    """
    fraction = np.random.default_rng(seed).uniform(size=number) if fraction is None else fraction
    rng, rubbed_finger = np.random.default_rng(seed), finger()
    side = np.asarray(rng.choice(list(_SIDES), number), dtype=str)
    s = rubbed_finger.length * rng.uniform(*places, number)
    force, pressure = (np.array([rng.uniform(*ranges[name]) for name in side]) for ranges in (forces, PRESSURES))
    rub = fraction * friction * rng.choice([-1, 1], number)
    strength = G * rng.uniform(size=number)
    gravity = strength[:, None] * _plane_directions(2 * np.pi * rng.uniform(size=number))
    forces_on_faces = _face_forces(rubbed_finger, side, s[:, None], force[:, None], rub[:, None])
    sides, mu = np.array([_SIDES[name] for name in side]), np.broadcast_to(friction, number)
    return balanced_contacts(rubbed_finger, pressure, gravity, forces_on_faces, force, s, sides, mu)


def _plane_directions(angle: Array) -> Array:
    """Directions in the bending plane, (..., 3), at angles from z toward x."""
    return np.stack([np.sin(angle), np.zeros(angle.shape), np.cos(angle)], axis=-1)


def _face_forces(finger: Finger, side: NDArray[np.str_], s: Array, force: Array, rub: Array) -> Forces:
    """Forces (M, K) N on the inner or outer face; `rub` is friction per force, toward the tip."""
    section, is_inside, zeros = finger.section(s), (side == "inner")[:, None], np.zeros(s.shape)
    faces = np.where(is_inside, section.inner_face, section.outer_face)
    local = force[..., None] * np.stack([np.where(is_inside, -1.0, 1.0) + zeros, zeros, rub], axis=-1)
    return link_forces(finger, s, np.stack([faces, zeros, zeros], axis=-1), local)


_MIN_DISTANCE, _POINTS = 0.15, 12  # of the length between two contacts, at least; forces of a spread contact


def several_contacts(
    number: int, friction: float, seed: int, is_spread: bool = False, base_end: float = 0.3
) -> Contacts:
    """About `number` pairs of contacts on one side, or contacts spread over a stretch of the finger.

    They lie beyond `base_end`, a fraction of the length; force and place are the sum of their forces and its centre.
    """
    rng, finger = np.random.default_rng([seed, is_spread]), read_finger()
    side = np.asarray(rng.choice(list(_SIDES), number), dtype=str)
    ends = np.sort(rng.uniform(base_end, 1, (number, 2)), axis=-1)
    fractions = rng.uniform(0.2, 0.8, number)[:, None] * np.array([1.0, -1.0]) + np.array([0.0, 1.0])
    if is_spread:
        places = np.linspace(0, 1, _POINTS)
        ends = ends @ np.array([1 - places, places])
        fractions = np.full((number, _POINTS), 1 / _POINTS)
    total, pressure = (np.array([rng.uniform(*ranges[name]) for name in side]) for ranges in (FORCES, PRESSURES))
    gravity = G * _plane_directions(2 * np.pi * rng.uniform(size=number))
    force, rub = total[:, None] * fractions, friction * rng.uniform(-1, 1, fractions.shape)
    mask = np.ptp(ends, axis=-1) > _MIN_DISTANCE
    side, s, force, rub, total = side[mask], finger.length * ends[mask], force[mask], rub[mask], total[mask]
    sides, center = np.array([_SIDES[name] for name in side]), (force * s).sum(axis=-1) / total
    forces = _face_forces(finger, side, s, force, rub)
    return balanced_contacts(finger, pressure[mask], gravity[mask], forces, total, center, sides, np.zeros_like(total))


PLACES = 0.1, 0.99  # of the length
_ACROSS = 0.8  # of the width of a face, within which forces act


@cache
def finger_in_space() -> Finger:
    """The shipped finger, which yields sideways and in twist as well."""
    return replace(read_finger(), yields=("bending", "sideways", "twist"))


def contacts_in_space(
    number: int, friction: Array | float, seed: int, places: tuple[float, float] = PLACES, faces: int = 4
) -> Contacts:
    """About `number` contacts at random places on the four faces, or on the inner and the outer one, if `faces` is 2.

    `friction` is the coefficient, one for all or (number); its direction on the face is random.
    """
    rng, finger = np.random.default_rng(seed), finger_in_space()
    s = finger.length * rng.uniform(*places, number)
    side = rng.integers(faces, size=number) * 2 * np.pi / faces
    turn = rng.uniform(0, 2 * np.pi, number)
    zeros, z_axis = np.zeros(number), np.array([0.0, 0.0, 1.0])
    normal = np.stack([np.cos(side), np.sin(side), zeros], axis=-1).round()
    tangent, section = vector_product(np.broadcast_to(z_axis, normal.shape), normal), finger.section(s)
    depth, middle = (section.inner_face - section.outer_face) / 2, (section.inner_face + section.outer_face) / 2
    half_extents = np.stack([depth, np.broadcast_to(section.width / 2, s.shape), zeros], axis=-1)
    place = (normal + rng.uniform(-_ACROSS, _ACROSS, number)[:, None] * tangent) * half_extents
    place[:, 0] += middle
    rubbing = np.cos(turn)[:, None] * tangent + np.sin(turn)[:, None] * z_axis
    size, mu = rng.uniform(0.1, 1.0, number), np.broadcast_to(friction, number)
    local = size[:, None] * (mu[:, None] * rubbing - normal)
    direction = rng.standard_normal((number, 3))
    gravity = G * rng.uniform(size=number)[:, None] * direction / np.linalg.norm(direction, axis=-1, keepdims=True)
    forces = link_forces(finger, s[:, None], place[:, None], local[:, None])
    return balanced_contacts(finger, rng.uniform(0.0, 120e3, number), gravity, forces, size, s, side, mu)
