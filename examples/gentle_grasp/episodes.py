"""Episodes of a grasp: environments, the result of each seed, and policies compared over the same objects."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import gymnasium
import numpy as np
from gymnasium.vector import VectorEnv

from gentle_grasp.policies import Array, Policy
from soft_gripper.extras import learning  # noqa: F401  registers the environments

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
_NORMAL_QUANTILE = 1.959964  # of the standard normal distribution, for 95 %
_BOOTSTRAP_RESAMPLES = 10_000


@dataclass(frozen=True)
class Episode:
    """Result of one episode."""

    seed: int
    success: bool  # at its end the object was held up
    peak_force: float  # N, the largest of a finger; NaN if the simulation diverged


Environments = VectorEnv[Any, Any, Any]


def learner_environments(engine: str = "drake") -> Environments:
    """SoftGrasp-v0, unchanged: one in Drake, or 64 that MuJoCo steps at once."""
    if engine == "drake":
        return gymnasium.make_vec("SoftGrasp-v0", num_envs=1, vectorization_mode="sync")
    return gymnasium.make_vec("SoftGrasp-v0", num_envs=64, vectorization_mode="vector_entry_point")


def hand_tuned_environments() -> Environments:
    """SoftGrasp-v0 with the control of the hand-tuned grasp, and the same objects, grippers and sensors."""
    return gymnasium.make_vec("SoftGrasp-v0", num_envs=1, vectorization_mode="sync", changes=_HAND_TUNED)


def run_episodes(environments: Environments, policies: Sequence[Policy], seeds: Sequence[int]) -> list[Episode]:
    """Runs an episode of each policy from its seed, in batches of as many as there are environments."""
    pairs = list(zip(policies, seeds, strict=True))
    count = environments.num_envs
    return [episode for i in range(0, len(pairs), count) for episode in _run_batch(environments, pairs[i : i + count])]


def _run_batch(environments: Environments, pairs: Sequence[tuple[Policy, int]]) -> list[Episode]:
    """Runs an episode per environment, or fewer; environments left over repeat the last seed."""
    seeds = [seed for _, seed in pairs]
    observations, _ = environments.reset(seed=seeds + seeds[-1:] * (environments.num_envs - len(seeds)))
    actions = np.zeros(environments.action_space.shape or (), np.float32)
    ended: dict[int, Episode] = {}
    while len(ended) < len(pairs):
        for i, (policy, _) in enumerate(pairs):
            if i not in ended:
                actions[i] = policy.act(observations[i])
        observations, _, terminated, truncated, info = environments.step(actions)
        for i in np.flatnonzero((terminated | truncated)[: len(pairs)]):
            ended.setdefault(
                int(i),
                Episode(seeds[i], bool(_info_value(info, "success", i)), float(_info_value(info, "peak_force", i))),
            )
    return [ended[i] for i in range(len(pairs))]


def _info_value(info: Mapping[str, Any], name: str, environment: int) -> Any:
    """Reads a value of an environment from `info`; False or NaN if missing, as after a diverged simulation."""
    has_value = name in info and info[f"_{name}"][environment]
    return info[name][environment] if has_value else {"success": False}.get(name, np.nan)


class Interval(NamedTuple):
    """A value with the limits of its 95 % interval."""

    value: float
    low: float
    high: float

    def __str__(self) -> str:
        return f"{self.value:.3f} ({self.low:.3f} to {self.high:.3f})"


def share(successes: int, number: int) -> Interval:
    """The fraction of successes, with Wilson's score interval (J. Am. Stat. Assoc. 22, 1927, 209-212)."""
    fraction = successes / number
    square = _NORMAL_QUANTILE**2 / number
    middle = (fraction + square / 2) / (1 + square)
    half = _NORMAL_QUANTILE * np.sqrt(fraction * (1 - fraction) / number + square / (4 * number)) / (1 + square)
    return Interval(fraction, float(middle - half), float(middle + half))


def mean(values: Array, seed: int = 0) -> Interval:
    """The mean of values, (n), with the percentile interval of the bootstrap (Efron, Ann. Stat. 7, 1979, 1-26)."""
    rng = np.random.default_rng(seed)
    means = values[rng.integers(len(values), size=(_BOOTSTRAP_RESAMPLES, len(values)))].mean(axis=1)
    low, high = np.quantile(means, [0.025, 0.975])
    return Interval(float(values.mean()), float(low), float(high))


class Summary(NamedTuple):
    """Results of the episodes of a policy."""

    policy: str
    success: Interval  # share of the objects that were held up at the end
    peak_force: Interval  # N, mean over all objects, dropped ones too

    def __str__(self) -> str:
        intervals = {"success": self.success, "peak force [N]": self.peak_force}
        parts = (f"{name} {interval}" for name, interval in intervals.items())
        return f"{self.policy}: {', '.join(parts)}"


def summary(policy: str, episodes: Sequence[Episode]) -> Summary:
    """The episodes of one policy."""
    forces = np.array([episode.peak_force for episode in episodes])
    return Summary(policy, share(sum(episode.success for episode in episodes), len(episodes)), mean(forces))


def saved_force(first: Sequence[Episode], second: Sequence[Episode]) -> Interval:
    """Force that the second saves against the first, N: the mean over the same objects.

    Raises:
        ValueError: if they are not the same.
    """
    if [one.seed for one in first] != [other.seed for other in second]:
        raise ValueError("forces are compared over the same objects")
    return mean(np.array([one.peak_force - other.peak_force for one, other in zip(first, second, strict=True)]))
