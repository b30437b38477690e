"""A load on a string, against closed forms: its friction, its swing, and its weight."""

from dataclasses import replace

import numpy as np
import pytest
from identified import RELEASE, recorded, release
from scipy.signal import find_peaks

from soft_gripper.extras.hardware.identification.fit import _vertex, fit
from soft_gripper.extras.hardware.identification.free_parameters import free_parameters
from soft_gripper.extras.hardware.identification.simulated_motion import Hold, Setup, tip_motion
from soft_gripper.fingers.finger_parts import TipLoad

MASS, FRICTION = 0.3, 5e-4  # kg, m
HUNG = replace(release(1.4), load=TipLoad(MASS, 0.0, 0.0), string=0.2)


@pytest.fixture(scope="module")
def stiff(beam):
    """Twenty times as stiff, so that it hardly turns, lightly damped, without creep."""
    modulus = 20 * beam.base.youngs_modulus
    stiffer = beam.with_sections(lambda part: replace(part, youngs_modulus=modulus))
    return replace(stiffer, relaxation_time=1e-4, creep=())


def half_swings(finger, setup):
    """How far the tip turns from extremum to extremum, rad, (14,)."""
    heading = tip_motion(finger, setup, HUNG).heading
    extrema = np.sort(np.concatenate([find_peaks(side)[0] for side in (heading, -heading)]))
    return np.abs(np.diff([_vertex(heading[k - 1 : k + 2])[1] for k in extrema]))[:14]


def test_friction_takes_as_much_of_every_swing_as_den_hartog_says(stiff):
    """Within half a period an amplitude A becomes (A - d) q - d, d being where friction holds the tip out of balance.

    By the energy of a light cantilever under a force at its end, which turns it by 3 / (2 L) of what it moves,
    d = 3/4 torque L / (E I). The decay q is that without friction. A half-swing is the sum of two amplitudes.
    """
    free, rubbed = half_swings(stiff, Setup()), half_swings(stiff, Setup(load_friction=FRICTION))
    q = (free[-1] / free[0]) ** (1 / (len(free) - 1))
    assert q > 0.99
    held = (q * rubbed[:-1] - rubbed[1:]).mean() / (2 * (1 + q))
    bending = stiff.base.youngs_modulus * 0.03**4 / 12
    assert held == pytest.approx(0.75 * FRICTION * MASS * 9.81 * stiff.length / bending, rel=0.04)


def test_a_load_hangs_down_from_a_tip_that_a_hand_holds_turned(beam):
    """And so all is at rest until the hand lets go."""
    motion = replace(HUNG, hold=Hold(0.002, 0.05), events=(RELEASE, 1e3))
    tip = tip_motion(beam, Setup(), motion)
    np.testing.assert_allclose(tip.tip, tip.tip[0], atol=1e-3 * beam.length)


@pytest.mark.slow
def test_friction_is_found(beam, pool):
    """From a first guess of none; the search does not end at its first small step."""
    light, hung = replace(beam, relaxation_time=2e-3), TipLoad(0.05, -0.015, 0.0)
    motion = recorded(light, replace(release(1.0), load=hung, string=0.2), Setup(load_friction=FRICTION))
    free = free_parameters(light, ["load_friction"], [])
    assert free.values(fit(free, [motion], pool.map).x) == pytest.approx([FRICTION], rel=0.02)
