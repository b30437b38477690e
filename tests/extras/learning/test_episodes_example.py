"""run_episode: from a seed to the end of an episode."""

import numpy as np
import pytest

from gentle_grasp.episodes import Episode, run_episode, run_episodes


class Counting:
    """A policy that acts by how often it has acted in this episode."""

    def begin(self):
        self.acted = 0

    def act(self, observation):
        self.acted += 1
        return np.array([self.acted, observation[0]])


class Short:
    """An environment whose episodes end after three steps, and remember the seed and the actions."""

    def __init__(self, end):
        self.end, self.actions = end, []

    def reset(self, seed):
        self.seed, self.steps = seed, 0
        return np.array([seed]), {"mass": 0.03}

    def step(self, action):
        self.steps += 1
        assert self.steps <= 3, "goes on after the end"
        self.actions.append(action.tolist())
        over = self.steps == 3
        info = {"success": over and self.seed > 1, "peak_force": 0.1 * self.steps}
        return np.array([self.seed + self.steps]), 0.0, over and self.end == "over", over and self.end == "late", info


@pytest.mark.parametrize("end", ["over", "late"])
def test_episodes_end_when_they_are_over_or_late_and_are_what_their_last_step_says(end):
    env = Short(end)
    found = run_episodes(env, Counting(), [1, 2])
    assert found == [Episode(1, False, pytest.approx(0.3)), Episode(2, True, pytest.approx(0.3))]
    assert env.actions == [[1, 1], [2, 2], [3, 3], [1, 2], [2, 3], [3, 4]]


def test_an_episode_that_diverges_is_no_success():
    env = Short("late")
    env.step = lambda action: (np.array([0.0]), 0.0, False, True, {"diverged": "no convergence"})
    found = run_episode(env, Counting(), 1)
    assert not found.success
    assert np.isnan(found.peak_force)
