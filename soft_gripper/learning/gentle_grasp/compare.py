"""The learned grasp beside the hand-tuned one, over objects that neither was made for."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from soft_gripper.learning.gentle_grasp.episodes import Episode
from soft_gripper.learning.gentle_grasp.intervals import Interval, mean, share


class Summary(NamedTuple):
    """What the episodes of a policy came to."""

    policy: str
    success: Interval  # share of the objects that were held up at the end
    peak_force: Interval  # N, mean over all objects, dropped ones too

    def __str__(self) -> str:
        of = {"success": self.success, "peak force [N]": self.peak_force}
        parts = (f"{name} {interval}" for name, interval in of.items())
        return f"{self.policy}: {', '.join(parts)}"


def summary(policy: str, episodes: Sequence[Episode]) -> Summary:
    """The episodes of one policy."""
    forces = np.array([episode.peak_force for episode in episodes])
    return Summary(policy, share(sum(episode.success for episode in episodes), len(episodes)), mean(forces))


def saved_force(first: Sequence[Episode], second: Sequence[Episode]) -> Interval:
    """By how much the second presses less than the first, N: the mean over the same objects.

    Raises:
        ValueError: if they are not the same.
    """
    if [one.seed for one in first] != [other.seed for other in second]:
        raise ValueError("forces are compared over the same objects")
    return mean(np.array([one.peak_force - other.peak_force for one, other in zip(first, second, strict=True)]))
