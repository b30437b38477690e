"""Tasks of a station: rewards computed from ground truth."""

from typing import Any, NamedTuple, Protocol

import numpy as np
from pydrake.systems.framework import Context

from soft_gripper.arrays import Array
from soft_gripper.extras.learning.config import GraspConfig, PickPlaceConfig, ReachConfig
from soft_gripper.extras.learning.station import LearningStation
from soft_gripper.fingers.kinematics import as_planar, in_space


class Judgement(NamedTuple):
    """Result of one step, of one environment or of several: (...)."""

    reward: Any
    terminated: Any
    info: dict[str, Any]  # ground truth, which observations do not contain


class Task(Protocol):
    """A task of a station; contexts are those of the station's whole diagram."""

    def begin(self, context: Context, rng: np.random.Generator) -> None:
        """Draws the random part of the task, and sets it in a context in which an episode begins."""

    def judge(self, context: Context) -> Judgement:
        """Scores the state after a step."""


class Handled(NamedTuple):
    """The object of a task and the forces on it."""

    place: Array  # (3,) m, of its frame, from where the episode began
    force: Array  # (F,) N, normal, of each finger
    peak: float  # N, the largest of any finger in the episode


class HandledObject:
    """A task that reads the object of a station."""

    def __init__(self, station: LearningStation):
        assert station.object is not None
        self._station, self._body = station, station.object
        self.begins_at: Array = np.zeros(3)  # m in the world, the object's frame at the start of an episode

    def begin(self, context: Context, rng: np.random.Generator) -> None:
        self.begins_at = self._place(context)

    def look(self, context: Context) -> Handled:
        """The object in a context of the whole diagram."""
        forces = self._station.forces
        assert forces is not None
        own = forces.GetMyContextFromRoot(context)
        force, peak = (forces.GetOutputPort(name).Eval(own) for name in ("force", "peak"))
        return Handled(self._place(context) - self.begins_at, force, float(max(peak.max(), force.max())))

    def _place(self, context: Context) -> Array:
        place: Array = self._body.EvalPoseInWorld(self._station.parts.plant.GetMyContextFromRoot(context)).translation()
        return place


_HELD_HEIGHT_SHARE = 0.8  # share of the height above which a touched object counts as held up


def grasp_judgement(config: GraspConfig, time_step: float, height: Array, force: Array, peak: Array) -> Judgement:
    """The result of a step of `Grasp`, from the height, (...) m, the forces of F fingers, (..., F), and their peak."""
    lifted = np.clip(height / config.height, 0.0, 1.0)
    crushed = np.asarray(peak) > config.crushing_force
    reward = time_step * (lifted - config.force_weight * force.max(axis=-1)) - crushed
    held = (lifted >= _HELD_HEIGHT_SHARE) & (force > 0).all(axis=-1) & ~crushed
    return Judgement(
        reward, crushed, {"height": height, "force": force, "peak_force": peak, "crushed": crushed, "success": held}
    )


class Grasp(HandledObject):
    """Earns time_step (lifted share - force_weight force) a step, and -1 for a crushed object, which ends it."""

    def __init__(self, station: LearningStation, config: GraspConfig, time_step: float):
        """`time_step` from a step to the next, s."""
        super().__init__(station)
        self._config, self._time_step = config, time_step

    def judge(self, context: Context) -> Judgement:
        seen = self.look(context)
        return _of_one(grasp_judgement(self._config, self._time_step, seen.place[2], seen.force, np.array(seen.peak)))


def _of_one(judged: Judgement) -> Judgement:
    """The judgement of one environment, with Python's own numbers."""
    info = {name: value if np.ndim(value) else np.asarray(value).item() for name, value in judged.info.items()}
    return Judgement(float(judged.reward), bool(judged.terminated), info)


_RESTING = 2e-3  # m, below which an object stands on the table


class PickPlace(HandledObject):
    """Earns time_step (share of the way - force_weight force) a step, and 1 when the object stands there alone.

    Either that or a crushed object, which earns -1, ends the episode. The way is at least as long as the tolerance.
    """

    def __init__(self, station: LearningStation, config: PickPlaceConfig, time_step: float):
        """`time_step` from a step to the next, s."""
        assert station.goal is not None
        super().__init__(station)
        self._config, self._time_step, self._goal = config, time_step, station.goal

    def begin(self, context: Context, rng: np.random.Generator) -> None:
        super().begin(context, rng)
        least, most = self._config.goal
        own = self._goal.GetMyMutableContextFromRoot(context)
        self._goal.get_mutable_source_value(own).SetFromVector([rng.uniform(least, most)])

    def judge(self, context: Context) -> Judgement:
        seen = self.look(context)
        goal = self._goal.get_output_port().Eval(self._goal.GetMyContextFromRoot(context))[0]
        way = goal - self.begins_at[0]
        judged = pick_place_judgement(self._config, self._time_step, way, seen.place, seen.force, np.array(seen.peak))
        return _of_one(judged)


def pick_place_judgement(
    config: PickPlaceConfig, time_step: float, way: Array, place: Array, force: Array, peak: Array
) -> Judgement:
    """The result of a step of `PickPlace`.

    Args:
        config: of the task.
        time_step: s.
        way: to the goal from the begin, (...) m along x.
        place: of the object from there, (..., 3) m.
        force: of F fingers, (..., F) N.
        peak: the largest so far, (...) N.
    """
    error, height = np.abs(way - place[..., 0]), place[..., 2]
    crushed = peak > config.crushing_force
    placed = (error < config.tolerance) & (np.abs(height) < _RESTING) & ~force.any(axis=-1)
    share = np.clip(1 - error / np.maximum(np.abs(way), config.tolerance), 0.0, 1.0)
    reward = time_step * (share - config.force_weight * force.max(axis=-1)) + placed - 1.0 * crushed
    info = {"error": error, "height": height, "force": force, "peak_force": peak}
    return Judgement(reward, placed | crushed, info | {"crushed": crushed, "success": placed})


class Reach:
    """Earns time_step / (1 + (error / scale)^2) a step: near 1 a second where the true tip is at the target."""

    def __init__(self, station: LearningStation, config: ReachConfig, time_step: float):
        """`time_step` from a step to the next, s."""
        assert station.target is not None
        self._station, self._config, self._time_step = station, config, time_step
        self._finger, self._target = station.parts.fingers[0], station.target
        self._tip, self._base = self._finger.frames[-1], self._finger.base.body_frame()

    def begin(self, context: Context, rng: np.random.Generator) -> None:
        least, most = self._config.pressure
        amplitude = rng.uniform(0.5, 1.0) * (most - least) / 2
        mean = rng.uniform(least + amplitude, most - amplitude)
        shortest, longest = self._config.period
        period, phase = rng.uniform(shortest, longest), rng.uniform(0.0, 2 * np.pi)
        own = self._target.GetMyMutableContextFromRoot(context)
        self._target.swing(own, mean, amplitude, period, phase)

    def judge(self, context: Context) -> Judgement:
        target = self._target.get_output_port().Eval(self._target.GetMyContextFromRoot(context))
        plant = self._station.parts.plant
        tip = self._tip.CalcPose(plant.GetMyContextFromRoot(context), self._base).translation()
        error = float(np.linalg.norm(tip - in_space(as_planar(target))))
        reward = self._time_step / (1 + (error / self._config.scale) ** 2)
        return Judgement(reward, False, {"tip_error": error})
