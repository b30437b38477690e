"""Tasks of E environments: what is random in an episode, and rewards computed from ground truth."""

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
    """Ground truth of E stations, now."""

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

    def begin(self, rows: NDArray[np.int_], drawn: Array, truth: Truth) -> None:
        """Notes the beginning of episodes of some environments, whose random parts are `drawn`, (rows, ...)."""

    def judge(self, truth: Truth) -> Judgement:
        """Scores the state after a step."""


_HELD_HEIGHT_SHARE = 0.8  # share of the height above which a touched object counts as held up


class Grasp:
    """Earns time_step (lifted share - force_weight force) a step, and -1 for a crushed object, which ends it."""

    def __init__(self, config: GraspConfig, time_step: float, count: int):
        """`time_step` from a step to the next, s; `count` of environments."""
        self._config, self._time_step = config, time_step
        self._begins = np.zeros((count, 3))

    def draw(self, rng: np.random.Generator) -> Sequence[float]:
        return ()

    def begin(self, rows: NDArray[np.int_], drawn: Array, truth: Truth) -> None:
        self._begins[rows] = truth.object_places()[rows]

    def judge(self, truth: Truth) -> Judgement:
        config, height = self._config, (truth.object_places() - self._begins)[:, 2]
        force, peak = truth.normal_forces()
        lifted = np.clip(height / config.height, 0.0, 1.0)
        crushed = peak > config.crushing_force
        reward = self._time_step * (lifted - config.force_weight * force.max(axis=-1)) - crushed
        held = (lifted >= _HELD_HEIGHT_SHARE) & (force > 0).all(axis=-1) & ~crushed
        info = {"height": height, "force": force, "peak_force": peak, "crushed": crushed, "success": held}
        return Judgement(reward, crushed, info)


_RESTING = 2e-3  # m, below which an object stands on the table


class PickPlace:
    """Earns time_step (share of the way - force_weight force) a step, and 1 when the object stands there alone.

    Either that or a crushed object, which earns -1, ends the episode. The way is at least as long as the tolerance.
    """

    def __init__(self, config: PickPlaceConfig, time_step: float, count: int):
        """`time_step` from a step to the next, s; `count` of environments."""
        self._config, self._time_step = config, time_step
        self._begins, self._ways = np.zeros((count, 3)), np.zeros(count)  # m; ways along x to the goals

    def draw(self, rng: np.random.Generator) -> Sequence[float]:
        least, most = self._config.goal
        return (rng.uniform(least, most),)

    def begin(self, rows: NDArray[np.int_], drawn: Array, truth: Truth) -> None:
        self._begins[rows] = truth.object_places()[rows]
        self._ways[rows] = drawn[:, 0] - self._begins[rows, 0]

    def judge(self, truth: Truth) -> Judgement:
        config, way = self._config, self._ways
        place, (force, peak) = truth.object_places() - self._begins, truth.normal_forces()
        error, height = np.abs(way - place[:, 0]), place[:, 2]
        crushed = peak > config.crushing_force
        placed = (error < config.tolerance) & (np.abs(height) < _RESTING) & ~force.any(axis=-1)
        share = np.clip(1 - error / np.maximum(np.abs(way), config.tolerance), 0.0, 1.0)
        reward = self._time_step * (share - config.force_weight * force.max(axis=-1)) + placed - 1.0 * crushed
        info = {"error": error, "height": height, "force": force, "peak_force": peak}
        return Judgement(reward, placed | crushed, info | {"crushed": crushed, "success": placed})


class Reach:
    """Earns time_step / (1 + (error / scale)^2) a step: near 1 a second where the true tip is at the target."""

    def __init__(self, config: ReachConfig, time_step: float):
        """`time_step` from a step to the next, s."""
        self._config, self._time_step = config, time_step

    def draw(self, rng: np.random.Generator) -> Sequence[float]:
        """The swing of a `TipTarget`."""
        (least, most), (shortest, longest) = self._config.pressure, self._config.period
        amplitude = rng.uniform(0.5, 1.0) * (most - least) / 2
        mean = rng.uniform(least + amplitude, most - amplitude)
        return mean, amplitude, rng.uniform(shortest, longest), rng.uniform(0.0, 2 * np.pi)

    def begin(self, rows: NDArray[np.int_], drawn: Array, truth: Truth) -> None:
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
        return Grasp(config.grasp, config.time_step, count)
    assert config.pick_place is not None
    return PickPlace(config.pick_place, config.time_step, count)
