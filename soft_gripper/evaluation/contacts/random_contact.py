"""One random single contact: what is drawn for it, its simulation, and whether it is one contact and no more."""

from dataclasses import dataclass
from functools import cache

import numpy as np
from pydrake.common.eigen_geometry import Quaternion
from pydrake.math import RotationMatrix

from soft_gripper.arrays import Array
from soft_gripper.estimators.plane import BendingPlane
from soft_gripper.evaluation.contacts.bench import (
    STILL,
    ContactBench,
    G,
    Setting,
    Settled,
    combined_friction,
    read_finger,
)
from soft_gripper.fingers.finger import Finger
from soft_gripper.fingers.kinematics import forward_kinematics
from soft_gripper.fingers.statics import resting_angles
from soft_gripper.truth.contact import touches

SIDES = {"inner": 1, "outer": -1}  # toward +x of B or away from it


def peg_center(finger: Finger, q: Array, s: float, side: str, radius: float) -> complex:
    """Centre, z + i x m in B, of a peg along y that touches the inner or the outer face at arc length `s` m."""
    chain = forward_kinematics(q, finger.segment_length)
    link = int(chain.link_at(np.array(s)))
    section = finger.section((finger.link_ends[link] + finger.link_ends[link + 1]) / 2)
    face = section.inner_face if side == "inner" else section.outer_face
    return complex(chain.at(np.array([s]), float(face) + SIDES[side] * radius).points[0])


RADIUS = (3, 12)  # mm, in whole ones, so that a bench serves many contacts
PLACE = (0.4, 1.0)  # of the finger's length
# kPa, pressure at which the finger would just touch the peg, and which then changes to the other.
TOUCHING = {"inner": (0.0, 120.0), "outer": (-30.0, 120.0)}
PRESSING = {"inner": 150.0, "outer": -50.0}  # the furthest that it goes from there
LEAST_FORCE = 0.05  # N
MOST_LINKS = 3
EDGE = 1.003  # times what friction alone makes of the normal force: a total above is no force on a face


@dataclass(frozen=True)
class RandomContact:
    """What is random about a contact."""

    side: str  # of the finger, "inner" or "outer"
    radius_mm: float  # of the peg
    place_mm: float  # arc length at which it is put to the finger
    touching_kpa: float  # pressure at which the finger would just touch it
    pressure_kpa: float
    orientation: tuple[float, float, float, float]  # of the finger's base, a unit quaternion w, x, y, z

    @property
    def R_WB(self) -> RotationMatrix:  # noqa: N802
        return RotationMatrix(Quaternion(np.array(self.orientation)))

    @property
    def gravity(self) -> complex:
        """In the bending plane, z + i x in B, m/s^2."""
        plane = BendingPlane(self.R_WB.matrix()[:, ::2].T, np.zeros(3))
        return complex(plane.planar(np.array([0.0, 0.0, -G])))


@dataclass(frozen=True)
class Contact:
    """A single contact at rest."""

    number: int
    drawn: RandomContact
    found: Settled
    redrawn: tuple[str, ...]  # why what was drawn before was none
    friction: float  # Coulomb, between the finger and the peg


def draw(rng: np.random.Generator, length: float) -> RandomContact:
    """What is random about a contact of a finger, every part evenly distributed; `length` of the finger, m."""
    side = str(rng.choice(list(SIDES)))
    radius = int(rng.integers(*RADIUS, endpoint=True))
    place = 1e3 * length * rng.uniform(*PLACE)
    touching = rng.uniform(*TOUCHING[side])
    pressure = touching + (PRESSING[side] - touching) * rng.uniform()
    quaternion = rng.normal(size=4)
    orientation = tuple(map(float, quaternion / np.linalg.norm(quaternion)))
    return RandomContact(side, float(radius), float(place), float(touching), float(pressure), orientation)  # type: ignore[arg-type]


def run_contact(seed: int, number: int, friction: float) -> Contact:
    """Simulates what is drawn until it is a single contact; the same, whatever other contacts there are.

    `friction` is the coefficient of the peg's surface, which combines with the finger's.
    """
    combined = combined_friction(friction)
    redrawn: list[str] = []
    while True:
        rng = np.random.default_rng([seed, number, len(redrawn)])
        drawn = draw(rng, read_finger().length)
        found = press(drawn, friction)
        flaw = flaw_of(drawn, found, combined)
        if not flaw:
            return Contact(number, drawn, found, tuple(redrawn), combined)
        redrawn.append(flaw)


@cache
def bench(radius_mm: float, friction: float) -> ContactBench:
    """The bench for pegs of a radius and a surface, one in a process: systems written in Python are not freed."""
    return ContactBench(1e-3 * radius_mm, friction)


def press(drawn: RandomContact, friction: float) -> Settled:
    """The contact at rest, with a peg of that coefficient of friction."""
    finger = read_finger()
    q = resting_angles(finger, 1e3 * drawn.touching_kpa, drawn.gravity)
    center = peg_center(finger, q, 1e-3 * drawn.place_mm, drawn.side, 1e-3 * drawn.radius_mm)
    return bench(drawn.radius_mm, friction).press(Setting(drawn.R_WB, center, q, 1e3 * drawn.pressure_kpa))


def flaw_of(drawn: RandomContact, found: Settled, friction: float) -> str:
    """Why it is no single contact that can be measured; empty: it is one. `friction` is that of the contact."""
    touching = np.flatnonzero(touches(found.link_force))
    if not len(touching):
        return "lost"
    if found.velocity > STILL:
        return "not at rest"
    if len(touching) > MOST_LINKS or touching[-1] - touching[0] >= len(touching):
        return "several places"
    if found.total > EDGE * np.hypot(1, friction) * abs(found.force):
        return "on an edge"
    if found.force * SIDES[drawn.side] < LEAST_FORCE:
        return "too weak"
    return ""
