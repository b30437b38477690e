"""Additions of this extra to scenarios: the random draws of trials of a task."""

import math
from dataclasses import dataclass, field

from soft_gripper.quantity import quantity


@dataclass
class TrialsConfig:
    """Random variations in trials of a task, uniformly distributed, symmetric or from least to most."""

    offset: float = quantity(0.03, "m", least=0)  # of the initial position of the object, along x and y
    yaw: float = quantity(math.radians(45), "rad", least=0)  # of the object about its own z axis
    mass: list[float] = quantity([0.02, 0.06], "kg", least=1e-9, span=True)
    friction: list[float] = quantity([0.5, 0.9], least=0, span=True)
    size: float = quantity(0.1, least=0, below=1)  # fraction of the object size
    # Of the reported position along x and y: typical of a depth camera.
    offset_error: float = quantity(3e-3, "m", least=0)
    yaw_error: float = quantity(math.radians(3), "rad", least=0)  # of the reported pose about the vertical


@dataclass
class Varied:
    """A task with settings of its trials."""

    trials: TrialsConfig = field(default_factory=TrialsConfig)  # of `soft-gripper study grasp-trials`


FIELDS = {"TaskConfig": Varied}
