"""What is fitted of an arm, against one that is known."""

from dataclasses import replace

import numpy as np
import pytest

from soft_gripper.fingers.finger_parts import CreepBranch
from soft_gripper.hardware.replay.drive_fit import bend_under, fit_drive
from soft_gripper.hardware.replay.geometry_fit import fit_geometry, measured
from soft_gripper.hardware.replay.stretched_arm import stretched_arm

DOWN = np.array([0.0, 0.0, 9.81])


@pytest.fixture(scope="module")
def geometry(arms, arm_finger):
    return fit_geometry(arms[:3], arm_finger)


def test_geometry_holds_on_a_recording_that_it_never_saw(arms, arm_finger, geometry):
    theta, length = geometry.wires.sections(arms[3].inner, arms[3].outer)
    q = np.repeat(theta / 6, 6, axis=-1)
    _, bodies, _ = stretched_arm(geometry.parts, q, length, arm_finger.section_ends(2))
    assert np.abs(bodies - measured(arms[3], geometry.delay)[0]).mean() < 1e-3
    assert abs(geometry.delay) < 0.01


def test_late_wires_are_noticed(arms, arm_finger):
    late = [replace(a, inner=np.roll(a.inner, 4, axis=0), outer=np.roll(a.outer, 4, axis=0)) for a in arms]
    late = [replace(a, inner=_held(a.inner), outer=_held(a.outer)) for a in late]
    assert fit_geometry(late, arm_finger).delay == pytest.approx(0.08, abs=0.01)


def _held(wires):
    wires = wires.copy()
    wires[:4] = wires[4]
    return wires


def test_a_delay_shows_bodies_where_they_were_before(arms):
    positions, headings = measured(arms[0], 0.05)
    np.testing.assert_allclose(positions[10], (arms[0].positions[7] + arms[0].positions[8]) / 2)
    np.testing.assert_allclose(headings[10], (arms[0].headings[7] + arms[0].headings[8]) / 2)


def test_the_drive_finds_which_chamber_bends_where(arms, arm_finger, geometry):
    gains = fit_drive(arms, geometry, arm_finger, DOWN).gains
    upper, lower = gains[0], gains[-1]
    np.testing.assert_array_equal(upper[2:], 0)
    np.testing.assert_array_equal(lower[:2], 0)
    assert upper[0] > 0 > upper[1]
    assert upper[0] == pytest.approx(-upper[1], rel=0.2)


def test_creep_lets_a_held_torque_bend_further():
    """In the end the bend is that of the stiffness that is left, 1 - share; at once that of all of it."""
    bends = bend_under(CreepBranch(0.4, 0.5), np.ones((2000, 1)))
    assert bends[0, 0] == 1
    assert bends[-1, 0] == pytest.approx(1 / 0.6, rel=1e-6)
