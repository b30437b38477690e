"""Grasp: an object is lifted and held, with little force."""

import numpy as np
from pydrake.systems.framework import Context

from soft_gripper.learning.schema.config import GraspConfig
from soft_gripper.learning.station.learning_station import LearningStation
from soft_gripper.learning.tasks.task import HandledObject, Judgement

_HELD = 0.8  # share of the height from which an object that is touched counts as held up


class Grasp:
    """Earns time_step (lifted share - force_weight force) a step, and -1 for a crushed object, which ends it."""

    def __init__(self, station: LearningStation, config: GraspConfig, time_step: float):
        """`time_step` from a step to the next, s."""
        self._object, self._config, self._time_step = HandledObject(station), config, time_step

    def begin(self, context: Context, rng: np.random.Generator) -> None:
        self._object.begin(context)

    def judge(self, context: Context) -> Judgement:
        seen, config = self._object.look(context), self._config
        height = float(seen.place[2])
        lifted = float(np.clip(height / config.height, 0.0, 1.0))
        crushed = seen.peak > config.crushing_force
        reward = self._time_step * (lifted - config.force_weight * seen.strongest) - float(crushed)
        held = lifted >= _HELD and bool((seen.force > 0).all()) and not crushed
        info = {"height": height, "force": seen.force, "peak_force": seen.peak, "crushed": crushed, "success": held}
        return Judgement(reward, crushed, info)
