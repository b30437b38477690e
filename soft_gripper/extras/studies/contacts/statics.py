"""Contacts in balance, computed by statics: forces on the faces of a finger, with any friction, one or several."""

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from soft_gripper.arrays import Array, Planar
from soft_gripper.extras.studies.contacts.dataset import SIDES, Contacts, G, read_finger
from soft_gripper.fingers.finger import Finger
from soft_gripper.fingers.kinematics import forward_kinematics, gravity_torque
from soft_gripper.fingers.statics import relaxed_law

PLACES = 0.42, 0.99  # of the length
FORCES = {"inner": (0.1, 2.0), "outer": (0.1, 1.8)}  # N
PRESSURES = {"inner": (30e3, 150e3), "outer": (-30e3, 100e3)}  # Pa
MOST_BEND = 2.6  # rad of the whole finger
_REPETITIONS, _STEP, _BALANCED = 400, 0.3, 1e-9  # rad


def rubbing_contacts(
    number: int,
    friction: Array | float,
    share: Array | float,
    seed: int,
    places: tuple[float, float] = PLACES,
    finger: Finger | None = None,
) -> Contacts:
    """Random contacts in balance, with a share of the friction along the face, one way or the other.

    `friction`, a coefficient, and `share` are one for all or (number); `finger` is the shipped one unless another is
    given. Those that bend the finger by more than MOST_BEND, or for which no balance is
    found, are left out.
    """
    rng, finger = np.random.default_rng(seed), finger or read_finger()
    side = rng.choice(list(SIDES), number)
    sign = np.array([SIDES[one] for one in side])
    place = finger.length * rng.uniform(*places, number)
    force, pressure = (np.array([rng.uniform(*ranges[one]) for one in side]) for ranges in (FORCES, PRESSURES))
    rub = share * friction * rng.choice([-1, 1], number)
    strength = G * rng.uniform(size=number)
    direction: Planar = np.exp(2j * np.pi * rng.uniform(size=number))
    gravity = strength * direction
    section = finger.section(place)
    offset = np.where(side == "inner", section.inner_face, section.outer_face)
    q, kept = balanced(finger, pressure, gravity, lambda q: rubbing_torque(finger, q, place, offset, sign * force, rub))
    torque = rubbing_torque(finger, q, place, offset, sign * force, rub)
    rest = (
        np.zeros(number),
        np.broadcast_to(friction, number),
    )  # a peg's radius, which has no meaning here, and the coefficient
    values: tuple[Any, ...] = q, pressure, gravity, sign * force, force * np.hypot(1, rub), place, torque, side, *rest
    return Contacts(*(value[kept] for value in values))


def balanced(
    finger: Finger, pressure: Array, gravity: Planar, torque_at: Callable[[Array], Array]
) -> tuple[Array, NDArray[np.bool_]]:
    """Joint angles in balance with pressure, weight and the torques of forces, (M, N) rad, and which are found, (M).

    `torque_at` gives the torques at joint angles, (M, N) N m. A finger bent by more than MOST_BEND counts as not found.
    """
    driven, angle = finger.pressure_torque(pressure), relaxed_law(finger).inverse()
    q = moved = angle(driven)
    for _ in range(_REPETITIONS):
        moved = angle(driven + gravity_torque(finger, q, gravity[:, None]) + torque_at(q)) - q
        q = q + _STEP * moved
    return q, (np.abs(moved).max(axis=-1) < _BALANCED) & (np.abs(q.sum(axis=-1)) < MOST_BEND)


def rubbing_torque(finger: Finger, q: Array, place: Array, offset: Array, force: Array, rub: Array) -> Array:
    """Torque of M forces at the joints, N m, (M, N).

    Args:
        finger, q: the finger and its joint angles, (M, N) rad.
        place, offset: of the points of contact, (M) m from the base and from the neutral axis, inner side positive.
        force: across the finger, (M) N, positive where it presses on the inner side.
        rub: friction along the finger, toward its tip, divided by the absolute force, (M).
    """
    sites = forward_kinematics(q, finger.segment_length).at(place[:, None], offset[:, None])
    rubbed, pressed = (np.abs(force) * rub)[:, None], force[:, None]
    return sites.torques(rubbed * sites.directions - pressed * sites.normals)[:, 0]


_APART, _POINTS = 0.15, 12  # of the length between two contacts, at least; forces of a spread contact


def several_contacts(number: int, friction: float, seed: int, spread: bool = False, near: float = 0.3) -> Contacts:
    """About `number` pairs of contacts on one side, or contacts spread over a stretch of the finger.

    They lie beyond `near`, a share of the length; force and place are the sum of their forces and its centre.
    """
    rng, finger = np.random.default_rng([seed, spread]), read_finger()
    side = np.asarray(rng.choice(list(SIDES), number), dtype=str)
    sign = np.array([SIDES[one] for one in side])
    ends = np.sort(rng.uniform(near, 1, (number, 2)), axis=-1)
    shares = rng.uniform(0.2, 0.8, number)[:, None] * np.array([1.0, -1.0]) + np.array([0.0, 1.0])
    if spread:
        ends, shares = ends @ _spread_out(), np.full((number, _POINTS), 1 / _POINTS)
    total, pressure = (np.array([rng.uniform(*ranges[one]) for one in side]) for ranges in (FORCES, PRESSURES))
    gravity = np.asarray(G * np.exp(2j * np.pi * rng.uniform(size=number)), dtype=complex)
    place, forces = finger.length * ends, (sign * total)[:, None] * shares
    rubs = friction * rng.uniform(-1, 1, forces.shape)
    kept = np.ptp(ends, axis=-1) > _APART
    place, forces, rubs = place[kept], forces[kept], rubs[kept]
    return _in_balance(finger, pressure[kept], gravity[kept], place, forces, rubs, side[kept])


def _spread_out() -> Array:
    """From two ends to points at equal distances between them, (2, _POINTS)."""
    along = np.linspace(0, 1, _POINTS)
    return np.array([1 - along, along])


def _in_balance(
    finger: Finger,
    pressure: Array,
    gravity: Planar,
    place: Array,
    forces: Array,
    rubs: Array,
    side: NDArray[np.str_],
) -> Contacts:
    section = finger.section(place)
    offset = np.where(forces > 0, section.inner_face, section.outer_face)

    def torque_at(q: Array) -> Array:
        each = zip(place.T, offset.T, forces.T, rubs.T, strict=True)
        torque: Array = sum((rubbing_torque(finger, q, *one) for one in each), np.zeros_like(q))
        return torque

    q, kept = balanced(finger, pressure, gravity, torque_at)
    total = forces.sum(axis=-1)
    center, unknown = (forces * place).sum(axis=-1) / total, np.zeros_like(total)
    values: tuple[Any, ...] = q, pressure, gravity, total, np.abs(total), center, torque_at(q), side, unknown, unknown
    return Contacts(*(value[kept] for value in values))
