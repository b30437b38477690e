"""The policies, on observations that are made up."""

import numpy as np
import pytest

from gentle_grasp.policies import (
    LATEST_LIFT,
    STEP,
    GentleGrasp,
    GentleParameters,
    HandTuned,
)

KNOWN = GentleParameters()


def observed(torque):
    """An observation of SoftGrasp-v0 with a grip torque, N m."""
    observation = np.zeros(10, np.float32)
    observation[4:6] = -10 * torque
    return observation


def pressure(action):
    return float(np.interp(action[0], [-1, 1], [-20e3, 130e3]))


def height(action):
    return float(np.interp(action[1], [-1, 1], [0.0, 0.08]))


def test_the_learned_policy_approaches_squeezes_holds_and_lifts():
    policy, pressures, torque = GentleGrasp(KNOWN), [], 0.0
    for _ in range(60):
        action = policy.act(observed(torque))
        pressures.append(pressure(action))
        torque = 1.5e-6 * max(pressures[-1] - 30e3, 0.0)  # an object that is touched at 30 kPa
    rates = np.diff(pressures) / STEP
    assert rates[0] == pytest.approx(KNOWN.approach, rel=1e-4)
    assert rates[15] == pytest.approx(KNOWN.squeeze, rel=1e-4)
    assert torque == pytest.approx(KNOWN.target, rel=0.05)
    assert height(action) == pytest.approx(0.08)


def test_what_was_touched_once_is_squeezed_slowly_even_if_the_touch_is_lost():
    policy = GentleGrasp(KNOWN)
    pressures = [pressure(policy.act(observed(torque))) for torque in (0.0, 0.0, 1.1 * KNOWN.touch, 0.0, 0.0)]
    np.testing.assert_allclose(np.diff(pressures)[0] / STEP, KNOWN.approach, rtol=1e-4)
    assert (np.diff(pressures)[1:] / STEP < KNOWN.squeeze * 1.001).all()


def test_the_lift_waits_for_the_grip_but_not_for_ever():
    policy = GentleGrasp(KNOWN)
    heights = [height(policy.act(observed(0.0))) for _ in range(60)]
    assert np.flatnonzero(heights)[0] == pytest.approx(LATEST_LIFT / STEP, abs=1.1)


def test_the_hand_tuned_grasp_lifts_when_the_fingers_rest_with_a_grip():
    def first_lift(openings, torque):
        policy = HandTuned()
        heights = [height(policy.act(np.array([10 * o, 10 * torque], np.float32))) for o in openings]
        return int(np.argmax(np.array(heights) > 0))

    closing = np.concatenate([np.linspace(0.07, 0.04, 10), np.full(20, 0.04)])
    assert first_lift(closing, 0.05) == 11  # two tenths of a second after the last motion beyond the band
    assert first_lift(closing, 0.01) == 0  # not yet: nothing is gripped
