"""Tasks of a finger in space: to bend freely under pressure, and to be pushed in its plane, sideways and at an edge.

Each is a shape at rest. A push is one of 0.3 N against the inner face, at the middle of the width or at an edge,
where it twists the finger, or across it; at half the length and near the tip.

T tasks, D joints, C pressures.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from soft_gripper.arrays import Array
from soft_gripper.extras.placement.pushed_finger import Push, PushedFinger
from soft_gripper.fingers.finger import Finger

FORCE = 0.3  # N
PLACES = (0.5, 0.9)  # shares of the length
FREE = "free"
# Where a push points, along the normal of the inner face and across, and its place from the middle to an edge.
PUSHES = {"in plane": (-1.0, 0.0, 0.0), "sideways": (0.0, 1.0, 0.0), "torsion": (-1.0, 0.0, 1.0)}


def leaves_its_plane(finger: Finger) -> bool:
    """Whether it twists, as all do that bend sideways."""
    return "twist" in finger.yields


@dataclass(frozen=True, eq=False)
class Tasks:
    """A finger at rest in all of its tasks."""

    statics: PushedFinger
    names: list[str]  # (T)
    pressures: Array  # (T, C) Pa
    push: Push  # (T); its force is zero where the finger is free
    driving: Array  # (T, D) N m
    q: Array  # (T, D) rad

    @property
    def is_pushed(self) -> NDArray[np.bool_]:
        """Which of the tasks have a push, (T,)."""
        return np.array([name != FREE for name in self.names])

    @property
    def pushed(self) -> "Tasks":
        """The tasks with a push alone."""
        chosen = self.is_pushed
        names = [name for name in self.names if name != FREE]
        push = Push(*(part[chosen] for part in self.push))
        return Tasks(self.statics, names, self.pressures[chosen], push, self.driving[chosen], self.q[chosen])


def tasks(statics: PushedFinger, pressures: Array) -> Tasks:
    """All tasks at pressures (L, C) Pa.

    Raises:
        SimulationDivergedError: if the finger finds no balance in one of them.
    """
    length, none = statics.finger.length, np.zeros(len(pressures))
    driving, no_push = statics.driving(pressures), Push(np.zeros((len(pressures), 3)), none, none)
    free = statics.at_rest(driving, no_push)
    names, pushes = [FREE] * len(pressures), [no_push]
    for name, (inward, across, edge) in PUSHES.items():
        for share in PLACES:
            s = none + share * length
            normal, left = np.moveaxis(statics.across(free, s), -2, 0)
            pushes.append(Push(FORCE * (inward * normal + across * left), s, none + edge * statics.half_width))
            names += [name] * len(pressures)
    push, count = Push(*(np.concatenate(parts) for parts in zip(*pushes, strict=True))), len(pushes)
    driving = np.tile(driving, (count, 1))
    return Tasks(statics, names, np.tile(pressures, (count, 1)), push, driving, statics.at_rest(driving, push))
