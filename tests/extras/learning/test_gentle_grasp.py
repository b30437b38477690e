"""The example of a gentle grasp: episodes, intervals, policies on made-up observations, and learning on a formula."""

import gymnasium
import numpy as np
import pytest
from gymnasium.spaces import Box
from gymnasium.vector import SyncVectorEnv

from gentle_grasp import learn as module
from gentle_grasp.episodes import Episode, mean, run_episodes, share
from gentle_grasp.policies import STEP, GentleGrasp, GentleParameters, HandTuned
from soft_gripper.extras.learning.config import load_environment


class Counting:
    """A policy that acts by how often it has acted."""

    acted = 0

    def act(self, observation):
        self.acted += 1
        return np.array([self.acted, observation[0]])


class Short(gymnasium.Env):
    """An environment whose episodes end after two steps and those of the seed, and remember the actions."""

    observation_space, action_space = Box(-99, 99, (1,)), Box(-99, 99, (2,))

    def __init__(self, end):
        self.end, self.actions = end, []

    def reset(self, *, seed=None, options=None):
        if seed is not None:
            self.seed = seed
        self.steps = 0
        return np.array([self.seed], np.float32), {"mass": 0.03}

    def step(self, action):
        self.steps += 1
        self.actions.append(action.tolist())
        over = self.steps == 2 + self.seed
        info = {"success": over and self.seed > 1, "peak_force": 0.1 * self.steps}
        if self.end == "diverged":
            return np.array([0.0], np.float32), 0.0, False, True, {"diverged": "no convergence"}
        observation = np.array([self.seed + self.steps], np.float32)
        return observation, 0.0, over and self.end == "over", over and self.end == "late", info


@pytest.mark.parametrize("end", ["over", "late"])
@pytest.mark.parametrize("count", [1, 2, 3])
def test_episodes_end_when_they_are_over_or_late_and_are_what_their_last_step_says(end, count):
    environments = [Short(end) for _ in range(count)]
    found = run_episodes(SyncVectorEnv([lambda env=env: env for env in environments]), [Counting(), Counting()], [1, 2])
    assert found == [Episode(1, False, pytest.approx(0.3)), Episode(2, True, pytest.approx(0.4))]
    first = [[1, 1], [2, 2], [3, 3]]
    assert environments[0].actions[:3] == first
    assert environments[1 % count].actions[-4:][:2] == [[1, 2], [2, 3]]


@pytest.mark.parametrize(
    ("successes", "number", "low", "high"),
    [  # Newcombe, Stat. Med. 17, 1998, 857-872, table I, method 3
        (81, 263, 0.2553, 0.3662),
        (15, 148, 0.0624, 0.1605),
        (0, 20, 0.0, 0.1611),
        (1, 29, 0.0061, 0.1718),
    ],
)
def test_shares_have_the_score_interval_of_wilson(successes, number, low, high):
    found = share(successes, number)
    assert found.value == pytest.approx(successes / number)
    assert (found.low, found.high) == pytest.approx((low, high), abs=6e-5)


def test_the_bootstrap_agrees_with_the_normal_approximation_where_that_holds():
    values = np.random.default_rng(0).normal(2.0, 0.5, 400)
    found, error = mean(values), values.std() / 20
    assert found.value == values.mean()
    assert found.low == pytest.approx(found.value - 1.96 * error, abs=0.1 * error)
    assert found.high == pytest.approx(found.value + 1.96 * error, abs=0.1 * error)


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


def test_the_hand_tuned_grasp_lifts_when_the_fingers_rest_with_a_grip():
    def first_lift(openings, torque):
        policy = HandTuned()
        heights = [height(policy.act(np.array([10 * o, 10 * torque], np.float32))) for o in openings]
        return int(np.argmax(np.array(heights) > 0))

    closing = np.concatenate([np.linspace(0.07, 0.04, 10), np.full(20, 0.04)])
    assert first_lift(closing, 0.05) == 11  # two tenths of a second after the last motion beyond the band
    assert first_lift(closing, 0.01) == 0  # not yet: nothing is gripped


VARIATION = load_environment("soft_grasp").config.variation


def needed(seed):
    return module.holding_difficulty(seed, VARIATION)


def formula(environments, policies, seeds):
    """Force is in proportion to the torque that is held, and holds what is not too heavy for it."""
    forces = [policy._parameters.target / 0.11 for policy in policies]
    pairs = zip(seeds, forces, strict=True)
    return [Episode(seed, force > needed(seed) * 9.81 / 2, force) for seed, force in pairs]
