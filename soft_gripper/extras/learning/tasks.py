"""Tasks of E environments: the random part of an episode, and rewards computed from ground truth.

A new task is a `Task` named in `make_task`, with its config in `config.py`.
"""

from collections.abc import Sequence
from typing import Any, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from soft_gripper.arrays import Array
from soft_gripper.extras.learning.config import EnvironmentConfig, GraspConfig, PickPlaceConfig, ReachConfig


class Judgement(NamedTuple):
    """Result of one step, (E) each."""

    reward: Array
    terminated: NDArray[np.bool_]
    info: dict[str, Any]  # ground truth, which observations do not contain


class Truth(Protocol):
    """Current ground truth of E stations."""

    def object_places(self) -> Array:
        """The frame of the object of the task in the world, (E, 3) m."""

    def normal_forces(self) -> tuple[Array, Array]:
        """Normal force on each finger, (E, F) N, and the largest of any finger in the episode, (E) N."""

    def tip_errors(self) -> Array:
        """Distance of the tip from its target, (E) m."""


class Task(Protocol):
    """A task of E environments."""

    def draw(self, rng: np.random.Generator) -> Sequence[float]:
        """Draws the random part of an episode: parameters of the source in a station that the policy follows."""

    def begin(self, rows: NDArray[np.int_], task_draws: Array, truth: Truth) -> None:
        """Notes the beginning of episodes of some environments, whose random parts are `task_draws`, (rows, ...)."""

    def judge(self, truth: Truth) -> Judgement:
        """Scores the state after a step."""


_HELD_HEIGHT_FRACTION = 0.8  # fraction of the height above which a touched object counts as held up


class GraspTask:
    """Earns time_step (lifted fraction - force_weight force) a step, and -1 for a crushed object, which ends it."""

    def __init__(self, config: GraspConfig, time_step: float, count: int):
        """`time_step` from a step to the next, s; `count` of environments."""
        self._config, self._time_step = config, time_step
        self._begins = np.zeros((count, 3))

    def draw(self, rng: np.random.Generator) -> Sequence[float]:
        return ()

    def begin(self, rows: NDArray[np.int_], task_draws: Array, truth: Truth) -> None:
        self._begins[rows] = truth.object_places()[rows]

    def judge(self, truth: Truth) -> Judgement:
        config, height = self._config, (truth.object_places() - self._begins)[:, 2]
        force, peak_force = truth.normal_forces()
        lift_fraction = np.clip(height / config.height, 0.0, 1.0)
        is_crushed = peak_force > config.crushing_force
        reward = self._time_step * (lift_fraction - config.force_weight * force.max(axis=-1)) - is_crushed
        is_held = (lift_fraction >= _HELD_HEIGHT_FRACTION) & (force > 0).all(axis=-1) & ~is_crushed
        info = {"height": height, "force": force, "peak_force": peak_force, "crushed": is_crushed, "success": is_held}
        return Judgement(reward, is_crushed, info)


_STANDING_HEIGHT = 2e-3  # m, below which an object stands on the table


class PickPlace:
    """Earns time_step (fraction of the path - force_weight force) a step, and 1 when the object stands there alone.

    Either that or a crushed object, which earns -1, ends the episode. The path is at least as long as the tolerance.
    """

    def __init__(self, config: PickPlaceConfig, time_step: float, count: int):
        """`time_step` from a step to the next, s; `count` of environments."""
        self._config, self._time_step = config, time_step
        self._begins, self._paths = np.zeros((count, 3)), np.zeros(count)  # m; paths along x to the goals

    def draw(self, rng: np.random.Generator) -> Sequence[float]:
        low, high = self._config.goal
        return (rng.uniform(low, high),)

    def begin(self, rows: NDArray[np.int_], task_draws: Array, truth: Truth) -> None:
        self._begins[rows] = truth.object_places()[rows]
        self._paths[rows] = task_draws[:, 0] - self._begins[rows, 0]

    def judge(self, truth: Truth) -> Judgement:
        config, path = self._config, self._paths
        place, (force, peak_force) = truth.object_places() - self._begins, truth.normal_forces()
        error, height = np.abs(path - place[:, 0]), place[:, 2]
        is_crushed = peak_force > config.crushing_force
        is_placed = (error < config.tolerance) & (np.abs(height) < _STANDING_HEIGHT) & ~force.any(axis=-1)
        fraction = np.clip(1 - error / np.maximum(np.abs(path), config.tolerance), 0.0, 1.0)
        reward = self._time_step * (fraction - config.force_weight * force.max(axis=-1)) + is_placed - 1.0 * is_crushed
        info = {"error": error, "height": height, "force": force, "peak_force": peak_force}
        return Judgement(reward, is_placed | is_crushed, info | {"crushed": is_crushed, "success": is_placed})


class Reach:
    """Earns time_step / (1 + (error / scale)^2) a step: near 1 a second where the true tip is at the target."""

    def __init__(self, config: ReachConfig, time_step: float):
        """`time_step` from a step to the next, s."""
        self._config, self._time_step = config, time_step

    def draw(self, rng: np.random.Generator) -> Sequence[float]:
        """Draws the swing of a `TipTarget`."""
        (min_pressure, max_pressure), (shortest, longest) = self._config.pressure, self._config.period
        amplitude = rng.uniform(0.5, 1.0) * (max_pressure - min_pressure) / 2
        mean_pressure = rng.uniform(min_pressure + amplitude, max_pressure - amplitude)
        return mean_pressure, amplitude, rng.uniform(shortest, longest), rng.uniform(0.0, 2 * np.pi)

    def begin(self, rows: NDArray[np.int_], task_draws: Array, truth: Truth) -> None:
        pass

    def judge(self, truth: Truth) -> Judgement:
        error = truth.tip_errors()
        reward = self._time_step / (1 + (error / self._config.scale) ** 2)
        return Judgement(reward, np.zeros(len(error), bool), {"tip_error": error})


def make_task(config: EnvironmentConfig, count: int) -> Task:
    """The task of `count` environments."""
    if config.reach is not None:
        return Reach(config.reach, config.time_step)
    if config.grasp is not None:
        return GraspTask(config.grasp, config.time_step, count)
    assert config.pick_place is not None
    return PickPlace(config.pick_place, config.time_step, count)
