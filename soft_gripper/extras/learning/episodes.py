"""Episodes of E environments of one file: spaces, variation, ends and rewards, for any simulator of the stations."""

from collections.abc import Sequence
from copy import deepcopy
from typing import Any, NamedTuple, Protocol

import numpy as np
from gymnasium.spaces import Box
from numpy.typing import NDArray

from soft_gripper.arrays import Array
from soft_gripper.extras.learning.config import EnvironmentConfig
from soft_gripper.extras.learning.episode_variation import Draw, draw
from soft_gripper.extras.learning.station import MAX_OBSERVED
from soft_gripper.extras.learning.tasks import Truth, make_task

Rows = NDArray[np.int_]  # numbers of environments


class Stations(Truth, Protocol):
    """Stations of E environments, built once."""

    resting: Array  # (n,), the action with which an episode begins

    def begin(self, rows: Rows, draws: Sequence[Draw], task_draws: Array) -> None:
        """Begins episodes in some environments, with their variations and random task parameters, (rows, ...)."""

    def step(self, actions: Array) -> list[str]:
        """Applies actions, (E, n), for a time step; returns E reasons for divergence, empty without divergence."""

    def observe(self) -> Array:
        """The observations, (E, k)."""


class Stepped(NamedTuple):
    """Result of a step, (E, ...) each."""

    observed: NDArray[np.float32]
    reward: NDArray[np.float64]
    terminated: NDArray[np.bool_]
    truncated: NDArray[np.bool_]
    info: dict[str, Any]  # of the task
    diverged: list[str]  # reasons; empty where an episode did not diverge


class Episodes:
    """Episodes that begin at random, and end with their task, after their duration, or where a simulation diverges."""

    def __init__(self, config: EnvironmentConfig, stations: Stations, count: int):
        """`count` of environments."""
        self._config, self.stations, self._task = config, stations, make_task(config, count)
        self._steps = np.zeros(count, int)  # of every episode
        self._observed = stations.observe()
        self.action_space = Box(-1.0, 1.0, stations.resting.shape, np.float32)
        self.observation_space = Box(-MAX_OBSERVED, MAX_OBSERVED, self._observed.shape[1:], np.float32)

    def begin(self, random: Sequence[np.random.Generator]) -> tuple[NDArray[np.float32], list[Draw]]:
        """Begins an episode in every environment, by its random numbers; returns observations and draws."""
        draws = self._begin(np.arange(len(random)), random)
        self._observed = self.stations.observe()
        return self._observed.astype(np.float32), draws

    def step(self, actions: Array, restarted: Rows, random: Sequence[np.random.Generator]) -> Stepped:
        """Applies actions, (E, n) within -1 to 1; environments `restarted` begin an episode instead.

        Where a simulation diverges, the reward is 0, and the observation that of the step before.
        """
        last_observed, reasons = self._observed, self.stations.step(actions)
        self._steps += 1
        diverged = np.array([bool(reason) for reason in reasons])
        judgement = self._task.judge(self.stations)
        is_late = self._steps * self._config.time_step > self._config.duration - 1e-9
        is_restarted = np.isin(np.arange(len(reasons)), restarted)
        # Non-finite values would spread in blocks: a failed episode restarts at once, with the next episode's draw.
        failed = np.flatnonzero(diverged & ~is_restarted)
        self._begin(failed, [deepcopy(random[i]) for i in failed.tolist()])
        self._begin(restarted, [random[i] for i in restarted.tolist()])
        self._observed = self.stations.observe()
        self._observed[failed] = last_observed[failed]
        reward = np.where(diverged | is_restarted, 0.0, judgement.reward)
        terminated, truncated = judgement.terminated & ~diverged & ~is_restarted, (is_late | diverged) & ~is_restarted
        return Stepped(self._observed.astype(np.float32), reward, terminated, truncated, judgement.info, reasons)

    def _begin(self, rows: Rows, random: Sequence[np.random.Generator]) -> list[Draw]:
        if not len(rows):
            return []
        draws = [draw(rng, self._config.variation) for rng in random]
        task_draws = np.array([self._task.draw(rng) for rng in random])
        self.stations.begin(rows, draws, task_draws)
        self._task.begin(rows, task_draws, self.stations)
        self._steps[rows] = 0
        return draws
