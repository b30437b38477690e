"""Episodes of a grasp: environments, the result of each seed, and policies compared over the same objects."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from gentle_grasp.policies import Array, Policy
from soft_gripper.extras.learning import SoftGripperEnv

# The control of the shipped scenario pick_and_place_delicate, with its estimator, at its rate; the force is limited by
# its mean estimate.
_HAND_TUNED: dict[str, Any] = {
    "action.grip": "opening",
    "action.range": [0.0, 0.1],
    "action.rest": 0.07,
    "observation": [{"signal": "grip.opening", "scale": 0.1}, {"signal": "grip.torque", "scale": 0.1}],
    "duration": 3.0,  # s: it is quicker
    "scenario.sensor.period": 0.01,
    "scenario.pressure.time_constant": 0.05,
    "scenario.control": {
        "force_limit": 0.65,
        "force_gains": {"kp": 2.0e4, "ki": 4.0e5},
        "gains": {"kp": 1.0e5, "ki": 5.7e6, "kd": 17},
    },
    "scenario.estimator": {
        "type": "recursive",
        "uncertainty": {
            **{"reading": 2.0e-3, "bend_per_pressure": 0.03, "pressure": 500.0},
            **{"gain": 0.01, "offset": 1.0e-3, "drift": 3.0e-4},
        },
    },
}
_Z = 1.959964  # of the standard normal distribution, for 95 %
_RESAMPLES = 10_000


@dataclass(frozen=True)
class Episode:
    """Result of one episode."""

    seed: int
    success: bool  # at its end the object was held up
    peak_force: float  # N, the largest of a finger; NaN if the simulation diverged


def learner_environment() -> SoftGripperEnv:
    """SoftGrasp-v0, unchanged."""
    return SoftGripperEnv("soft_grasp")


def hand_tuned_environment() -> SoftGripperEnv:
    """The same objects, grippers and sensors for the hand-tuned grasp."""
    return SoftGripperEnv("soft_grasp", _HAND_TUNED)


def run_episode(env: SoftGripperEnv, policy: Policy, seed: int) -> Episode:
    """One episode from a seed, to its end."""
    policy.begin()
    observation, info = env.reset(seed=seed)
    over = False
    while not over:
        observation, _, terminated, truncated, info = env.step(policy.act(observation))
        over = terminated or truncated
    return Episode(seed, bool(info.get("success", False)), float(info.get("peak_force", float("nan"))))


def run_episodes(env: SoftGripperEnv, policy: Policy, seeds: Iterable[int]) -> list[Episode]:
    """Episodes one after the other."""
    return [run_episode(env, policy, seed) for seed in seeds]


class Interval(NamedTuple):
    """A value with the limits of its 95 % interval."""

    value: float
    low: float
    high: float

    def __str__(self) -> str:
        return f"{self.value:.3f} ({self.low:.3f} to {self.high:.3f})"


def share(successes: int, number: int) -> Interval:
    """The share of successes, with Wilson's score interval (J. Am. Stat. Assoc. 22, 1927, 209-212)."""
    found, square = successes / number, _Z**2 / number
    middle = (found + square / 2) / (1 + square)
    half = _Z * np.sqrt(found * (1 - found) / number + square / (4 * number)) / (1 + square)
    return Interval(found, float(middle - half), float(middle + half))


def mean(values: Array, seed: int = 0) -> Interval:
    """The mean of values, (n), with the percentile interval of the bootstrap (Efron, Ann. Stat. 7, 1979, 1-26)."""
    rng = np.random.default_rng(seed)
    means = values[rng.integers(len(values), size=(_RESAMPLES, len(values)))].mean(axis=1)
    low, high = np.quantile(means, [0.025, 0.975])
    return Interval(float(values.mean()), float(low), float(high))


class Summary(NamedTuple):
    """Results of the episodes of a policy."""

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
    """How much less force the second applies than the first, N: the mean over the same objects.

    Raises:
        ValueError: if they are not the same.
    """
    if [one.seed for one in first] != [other.seed for other in second]:
        raise ValueError("forces are compared over the same objects")
    return mean(np.array([one.peak_force - other.peak_force for one, other in zip(first, second, strict=True)]))
