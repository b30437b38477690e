"""How friction spoils the estimates of single contacts, from none to the edge of the friction cone.

    python -m soft_gripper.evaluation.contacts.friction_cone

A finger that is pressed on a peg until it rests mobilises only a part of the friction that the coefficient allows.
Here contacts are computed by statics instead: a force on a face of the finger, with any share of the friction.
"""

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from soft_gripper.arrays import Array, Planar
from soft_gripper.evaluation.contacts.dataset import (
    LAYOUTS,
    PEG_FRICTION,
    SIDES,
    Contacts,
    G,
    combined_friction,
    describe_borders,
    read_finger,
)
from soft_gripper.evaluation.contacts.estimates import ESTIMATOR, Condition, estimate_contacts, ideal_readings
from soft_gripper.evaluation.contacts.trials import contact_errors
from soft_gripper.fingers.finger import Finger
from soft_gripper.fingers.kinematics import forward_kinematics, gravity_torque
from soft_gripper.fingers.statics import relaxed_law
from soft_gripper.sensors.sensor_layout import SensorLayout

SHARES = 0.0, 1 / 3, 2 / 3, 1.0  # of the friction that the coefficient allows
PLACES = 0.42, 0.99  # of the length
FORCES = {"inner": (0.1, 2.0), "outer": (0.1, 1.8)}  # N
PRESSURES = {"inner": (30e3, 150e3), "outer": (-30e3, 100e3)}  # Pa
MOST_BEND = 2.6  # rad of the whole finger
_REPETITIONS, _STEP, _BALANCED = 400, 0.3, 1e-9  # rad


def rubbing_contacts(
    number: int, friction: float, share: Array | float, seed: int, places: tuple[float, float] = PLACES
) -> Contacts:
    """Random contacts in balance, with a share of the friction along the face, one way or the other.

    `share` is one for all or (number). Those that bend the finger by more than MOST_BEND, or for which no balance is
    found, are left out.
    """
    rng, finger = np.random.default_rng(seed), read_finger()
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
    rest = np.zeros(number), np.full(number, friction)  # a peg's radius, which has no meaning here, and the coefficient
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


def main(number: int = 400, seed: int = 1) -> None:
    """Prints medians and 90th percentiles, with ideal sensors and an exact nominal model."""
    friction = combined_friction(PEG_FRICTION)
    widths = 15, 8, 15, 8
    names = "force: median", "90 %", "place: median", "90 %"
    titles = "".join(f"{name:>{width}}" for name, width in zip(names, widths, strict=True))
    print(f"{'friction':<10}{'sections':<12}{'contacts':>8}{titles}")
    for share in SHARES:
        contacts = rubbing_contacts(number, friction, share, seed)
        for sections, borders in LAYOUTS:
            layout = SensorLayout(contacts.finger, sections, borders=borders)
            found = estimate_contacts(ESTIMATOR, layout, Condition(), ideal_readings(layout, contacts), contacts)
            errors = contact_errors(found, contacts)
            numbers = [100 * np.nanpercentile(e, p) for e in (errors.force, errors.place) for p in (50, 90)]
            what = f"{share * friction:<10.2f}{sections}: {describe_borders(layout):<9}{len(contacts.q):>8}"
            print(what + "".join(f"{number:>{width}.2f}" for number, width in zip(numbers, widths, strict=True)))


if __name__ == "__main__":
    main()
