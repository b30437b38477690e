"""Episodes of a grasp: environments, and what came of each seed."""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

from soft_gripper.learning.environment import SoftGripperEnv
from soft_gripper.learning.gentle_grasp.policies import Policy

# The control of the shipped scenario pick_and_place_delicate, with its estimator, at its rate.
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


@dataclass(frozen=True)
class Episode:
    """What came of one."""

    seed: int
    success: bool  # at its end the object was held up
    peak_force: float  # N, the largest of a finger; NaN if the simulation diverged


def learner_environment() -> SoftGripperEnv:
    """SoftGrasp-v0 as it is."""
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
