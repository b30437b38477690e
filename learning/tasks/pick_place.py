"""PickPlace: an object is carried to a place, put down and let go."""

import numpy as np
from pydrake.systems.framework import Context

from soft_gripper.learning.schema.config import PickPlaceConfig
from soft_gripper.learning.station.learning_station import LearningStation
from soft_gripper.learning.tasks.task import HandledObject, Judgement

_RESTING = 2e-3  # m, below which an object stands on the table


class PickPlace:
    """Earns time_step (share of the way - force_weight force) a step, and 1 when the object stands there alone.

    That ends an episode, and so does a crushed object, which earns -1. A way is at least as long as the tolerance.
    """

    def __init__(self, station: LearningStation, config: PickPlaceConfig, time_step: float):
        """`time_step` from a step to the next, s."""
        assert station.goal is not None
        self._object, self._config, self._time_step = HandledObject(station), config, time_step
        self._goal = station.goal

    def begin(self, context: Context, rng: np.random.Generator) -> None:
        self._object.begin(context)
        least, most = self._config.goal
        own = self._goal.GetMyMutableContextFromRoot(context)
        self._goal.get_mutable_source_value(own).SetFromVector([rng.uniform(least, most)])

    def judge(self, context: Context) -> Judgement:
        seen, config = self._object.look(context), self._config
        goal = float(self._goal.get_output_port().Eval(self._goal.GetMyContextFromRoot(context))[0])
        way, height = goal - float(self._object.begins_at[0]), float(seen.place[2])
        error = abs(way - float(seen.place[0]))
        crushed = seen.peak > config.crushing_force
        placed = error < config.tolerance and abs(height) < _RESTING and not seen.force.any()
        share = float(np.clip(1 - error / max(abs(way), config.tolerance), 0.0, 1.0))
        reward = self._time_step * (share - config.force_weight * seen.strongest) + float(placed) - float(crushed)
        info = {"error": error, "height": height, "force": seen.force, "peak_force": seen.peak}
        return Judgement(reward, placed or crushed, info | {"crushed": crushed, "success": placed})
