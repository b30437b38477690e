"""What an agent is rewarded for, as the simulation knows it: tasks of a station."""

from typing import Any, NamedTuple, Protocol

import numpy as np
from pydrake.systems.framework import Context

from soft_gripper.arrays import Array
from soft_gripper.learning.station.learning_station import LearningStation


class Judgement(NamedTuple):
    """What a step came to."""

    reward: float
    terminated: bool
    info: dict[str, Any]  # the truth, which no observation holds


class Task(Protocol):
    """A task of a station; contexts are those of the station's whole diagram."""

    def begin(self, context: Context, rng: np.random.Generator) -> None:
        """Draws what is random about the task, and puts it into a context in which an episode begins."""

    def judge(self, context: Context) -> Judgement:
        """Judges the state to which a step has led."""


class Handled(NamedTuple):
    """The object of a task and the forces on it, as they are."""

    place: Array  # (3,) m, of its frame, from where the episode began
    force: Array  # (F,) N, normal, of each finger
    peak: float  # N, the largest of any finger in the episode

    @property
    def strongest(self) -> float:
        return float(self.force.max())


class HandledObject:
    """Looks at the object of a station."""

    def __init__(self, station: LearningStation):
        assert station.object is not None
        self._station, self._body = station, station.object
        self._begin: Array = np.zeros(3)

    def begin(self, context: Context) -> None:
        """Remembers where an episode begins."""
        self._begin = self._place(context)

    @property
    def begins_at(self) -> Array:
        """Where the frame of the object stands as an episode begins, (3,) m in the world."""
        return self._begin

    def look(self, context: Context) -> Handled:
        """The object in a context of the whole diagram."""
        forces = self._station.forces
        own = forces.GetMyContextFromRoot(context)
        force, peak = (forces.GetOutputPort(name).Eval(own) for name in ("force", "peak"))
        return Handled(self._place(context) - self._begin, force, float(max(peak.max(), force.max())))

    def _place(self, context: Context) -> Array:
        place: Array = self._body.EvalPoseInWorld(self._station.parts.plant.GetMyContextFromRoot(context)).translation()
        return place
