"""Reach: the tip of a finger follows a point."""

import numpy as np
from pydrake.systems.framework import Context

from soft_gripper.arrays import Array
from soft_gripper.fingers.kinematics import as_points, forward_kinematics
from soft_gripper.learning.schema.config import ReachConfig
from soft_gripper.learning.station.learning_station import LearningStation
from soft_gripper.learning.tasks.task import Judgement


class Reach:
    """Earns time_step / (1 + (error / scale)^2) a step: near 1 a second where the true tip is at the target."""

    def __init__(self, station: LearningStation, config: ReachConfig, time_step: float):
        """`time_step` from a step to the next, s."""
        assert station.target is not None
        self._station, self._config, self._time_step = station, config, time_step
        self._finger, self._target = station.parts.fingers[0], station.target
        self._selector = self._finger.position_selector()

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
        error = float(np.linalg.norm(self._tip(context) - target))
        reward = self._time_step / (1 + (error / self._config.scale) ** 2)
        return Judgement(reward, False, {"tip_error": error})

    def _tip(self, context: Context) -> Array:
        """The true tip, (2,) x, z in B, m."""
        plant, finger = self._station.parts.plant, self._finger.finger
        state = plant.GetPositionsAndVelocities(plant.GetMyContextFromRoot(context))
        tip: Array = as_points(forward_kinematics(self._selector @ state, finger.segment_length).tip)
        return tip
