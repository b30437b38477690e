"""A peg at the face of a finger at rest: it touches there and nowhere else."""

import numpy as np
import pytest

from soft_gripper.fingers.finger import Finger
from soft_gripper.fingers.kinematics import forward_kinematics
from soft_gripper.fingers.statics import resting_angles
from studies.contacts.peg import SIDES, peg_center


@pytest.mark.parametrize("side", SIDES)
@pytest.mark.parametrize("s", [0.048, 0.0771, 0.1188])
def test_a_peg_touches_the_face_of_one_link(shipped_finger: Finger, side: str, s: float) -> None:
    """Seen from each link, at its place along the axis, it is as far off as its radius and the face."""
    radius, sign = 0.006, SIDES[side]
    q = resting_angles(shipped_finger, 50e3, 0j)
    center = peg_center(shipped_finger, q, s, side, radius)
    chain, ends = forward_kinematics(q, shipped_finger.segment_length), shipped_finger.link_ends
    origins = np.concatenate([[0], chain.joints])
    seen = (center - origins) * np.exp(-1j * chain.headings)
    link = int(np.flatnonzero((ends[:-1] <= s) & (s < ends[1:]))[0])
    section = shipped_finger.section((ends[link] + ends[link + 1]) / 2)
    face = float(section.inner_face if side == "inner" else section.outer_face)
    assert seen[link].real == pytest.approx(s - ends[link], abs=1e-12)
    assert seen[link].imag == pytest.approx(face + sign * radius, abs=1e-12)
