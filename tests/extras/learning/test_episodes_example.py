"""run_episodes: from seeds to the ends of episodes, as many at once as there are environments."""

import gymnasium
import numpy as np
import pytest
from gymnasium.spaces import Box
from gymnasium.vector import SyncVectorEnv

from gentle_grasp.episodes import Episode, run_episodes


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


def test_an_episode_that_diverges_is_no_success():
    (found,) = run_episodes(SyncVectorEnv([lambda: Short("diverged")]), [Counting()], [1])
    assert not found.success
    assert np.isnan(found.peak_force)
