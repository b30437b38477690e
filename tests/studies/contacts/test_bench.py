"""The bench against statics: what a peg does to a finger is one force at one place."""

from functools import cache

import numpy as np
import pytest
from pydrake.math import RollPitchYaw

from soft_gripper.fingers.kinematics import forward_kinematics
from soft_gripper.fingers.statics import resting_angles
from studies.contacts.contacts import G, read_finger
from studies.contacts.peg import (
    SIDES,
    ContactBench,
    SettledFinger,
    combined_friction,
    peg_center,
)

RADIUS, PLACE = 0.006, 0.08  # m; the middle of a link
R_WB = RollPitchYaw(0.4, -0.5, 1.1).ToRotationMatrix()
PRESSURES = {"inner": (40e3, 90e3), "outer": (60e3, 10e3)}  # Pa, when it just touches, and then
ROUGH = 0.3


@cache
def pressed(side: str, friction: float) -> tuple[SettledFinger, complex, complex]:
    """What comes of it; the centre of the peg, and gravity, both z + i x in B."""
    x, _, z = R_WB.matrix().T @ [0, 0, -G]
    before, after = PRESSURES[side]
    q = resting_angles(read_finger(), before, complex(z, x))
    center = peg_center(read_finger(), q, PLACE, side, RADIUS)
    return ContactBench(RADIUS, friction).press(R_WB, center, q, after), center, complex(z, x)


def torque_of(found: SettledFinger, along: float) -> np.ndarray:
    """At the joints, of one force: `found.force` across the link that it meets, and `along` it."""
    finger = read_finger()
    chain, link = forward_kinematics(found.q, finger.segment_length), int(np.argmax(found.link_force))
    direction = np.exp(1j * chain.headings[link])
    face = finger.section(finger.length * (link / finger.segments))
    depth = face.inner_face if found.force > 0 else face.outer_face
    origin = chain.joints[link - 1]
    place = origin + (found.arc_length - finger.link_ends[link] + 1j * float(depth)) * direction
    force = (along - 1j * found.force) * direction
    levers = np.where(np.arange(finger.segments) < link, place - chain.joints, 0)
    return (levers.conj() * force).imag


@pytest.mark.parametrize("side", SIDES)
def test_a_smooth_peg_is_one_force_across_the_finger(side: str) -> None:
    """Force times lever is the true torque of every joint; there is no friction."""
    found, _, _ = pressed(side, 0.0)
    assert found.force * SIDES[side] > 0.3
    assert found.total == pytest.approx(abs(found.force), rel=1e-5)
    np.testing.assert_allclose(torque_of(found, 0.0), found.torque, atol=1e-3 * np.abs(found.torque).max())


@pytest.mark.parametrize("side", SIDES)
def test_friction_acts_along_the_face(side: str) -> None:
    found, _, _ = pressed(side, ROUGH)
    friction = np.sqrt(found.total**2 - found.force**2)
    assert np.linalg.norm(found.vector) == pytest.approx(found.total, rel=1e-3)
    assert friction > 0.01 * found.total
    errors = [np.abs(torque_of(found, sign * friction) - found.torque).max() for sign in (-1, 1)]
    assert min(errors) < 3e-3 * np.abs(found.torque).max()


def test_friction_is_that_of_both_surfaces() -> None:
    """2 a b / (a + b); the finger has 0.9."""
    assert combined_friction(0.3) == pytest.approx(0.45)
    assert combined_friction(0.0) == 0


def test_a_bench_is_as_new_for_every_contact() -> None:
    bench, (first, center, _) = ContactBench(RADIUS, ROUGH), pressed("inner", ROUGH)
    again, other = ((R_WB, center, first.q + shift, 90e3) for shift in (0.0, 0.01))
    found = bench.press(*again)
    bench.press(*other)
    for one, two in zip(found, bench.press(*again), strict=True):
        np.testing.assert_array_equal(one, two)
