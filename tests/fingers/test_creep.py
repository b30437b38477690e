"""Internal angles of creep, compared with solutions of their differential equation."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from scipy.integrate import quad

from soft_gripper.fingers.creep import advance, memory_torque
from soft_gripper.fingers.finger_parts import CreepBranch

BRANCHES = (CreepBranch(0.2, 0.3), CreepBranch(0.1, 4.0))
TIMES = np.array([[0.3], [4.0]])  # s, of the branches


@pytest.mark.parametrize("period", [1e-3, 1.0])
def test_internal_angles_are_exact_where_angles_are_linear_between_samples(period):
    """Against the integral of  exp(-(t - s) / time) q(s) / time , at the end of a path of 20 pieces."""
    angles = np.random.default_rng(1).standard_normal((21, 3))
    z, end = np.zeros((2, 3)), 20 * period
    for before, after in pairwise(angles):
        z = advance(BRANCHES, z, before, after, period)
    for branch, joint in np.ndindex(2, 3):
        time = TIMES[branch, 0]

        def kernel(s, time=time, joint=joint):
            return np.exp((s - end) / time) / time * np.interp(s, np.arange(21) * period, angles[:, joint])

        pieces = [quad(kernel, i * period, (i + 1) * period, epsabs=1e-15, epsrel=1e-13)[0] for i in range(20)]
        assert z[branch, joint] == pytest.approx(sum(pieces), abs=1e-12)


def test_the_step_is_right_from_a_ten_millionth_of_a_time_to_a_million_times():
    branches = tuple(CreepBranch(0.1, time) for time in (1e-6, 1e7))
    z = advance(branches, np.zeros((2, 1)), np.array([0.0]), np.array([1.0]), 1.0)
    np.testing.assert_allclose(z[:, 0], [1 - 1e-6, 0.5e-7], rtol=1e-7)


def test_leading_axes_are_free(tapered_finger):
    rng = np.random.default_rng(2)
    z, before, after = rng.standard_normal((4, 7, 2, 5)), rng.standard_normal((4, 7, 5)), rng.standard_normal((4, 7, 5))
    finger = replace(tapered_finger, creep=BRANCHES)
    later = advance(BRANCHES, z, before, after, 0.2)
    torque = memory_torque(finger, later)
    assert torque.shape == (4, 7, 5)
    np.testing.assert_array_equal(later[2, 3], advance(BRANCHES, z[2, 3], before[2, 3], after[2, 3], 0.2))
    expected = (0.2 * later[2, 3, 0] + 0.1 * later[2, 3, 1]) * finger.stiffness
    np.testing.assert_allclose(torque[2, 3], expected, rtol=1e-12)
