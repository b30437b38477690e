"""Measures the cost of learning: a reset, a step in one process, in two, and of many in MuJoCo; medians of rounds.

One environment, and those in MuJoCo, are measured in CPU time; box_grasp is timed in the same run, since the machine
may be busy. Two processes are measured in wall-clock time, as a ratio of steps per second to one, which a busy machine
distorts.
"""

import argparse
import time
from collections.abc import Callable
from functools import partial
from typing import Any

import gymnasium
import numpy as np
from gymnasium.vector import VectorEnv

from soft_gripper import load_scenario, make_simulator
from soft_gripper.diagrams.station import make_private_station
from soft_gripper.extras.learning.environment import SoftGripperEnv

ROUNDS, STEPS = 7, 50
ENVIRONMENTS = 64  # environments in MuJoCo
GRIP, LIFT = 0.1, 20  # action that grips, and the step at which it begins to lift


def action(step: int) -> np.ndarray:
    """Action of a grasp that holds, at a step."""
    return np.array([GRIP, -1.0 if step < LIFT else 1.0], np.float32)


def measure_duration(work: Callable[[], object], clock: Callable[[], float]) -> float:
    """Duration of a piece of work, s."""
    begin = clock()
    work()
    return clock() - begin


def episode(env: SoftGripperEnv | VectorEnv[Any, Any, Any], number: int) -> None:
    """Makes all steps of an episode, of `number` environments at once."""
    for step in range(STEPS):
        env.step(action(step) if number == 0 else np.tile(action(step), (number, 1)))


def run(options: argparse.Namespace) -> None:
    """Prints the figures."""
    env = SoftGripperEnv("soft_grasp")
    box = make_private_station(load_scenario("box_grasp", ["pressure.steps={all: [60e3]}"]))
    vectors = {number: gymnasium.make_vec("SoftGrasp-v0", number, "async") for number in (1, 2)}
    rounds: dict[str, list[float]] = {name: [] for name in ("reset", "episode", "box", "one", "two", "many")}
    vector_env = gymnasium.make_vec("SoftGrasp-v0", ENVIRONMENTS, "vector_entry_point")
    for seed in range(ROUNDS):
        rounds["reset"].append(measure_duration(partial(env.reset, seed=seed), time.process_time))
        rounds["episode"].append(measure_duration(lambda: episode(env, 0), time.process_time))
        rounds["box"].append(measure_duration(partial(make_simulator(box).AdvanceTo, 2.0), time.process_time))
        vector_env.reset(seed=seed)
        rounds["many"].append(measure_duration(lambda: episode(vector_env, ENVIRONMENTS), time.process_time))
        for name, number in (("one", 1), ("two", 2)):
            vectors[number].reset(seed=seed)
            rounds[name].append(measure_duration(partial(episode, vectors[number], number), time.perf_counter))
    median = {name: float(np.median(durations)) for name, durations in rounds.items()}
    simulated = STEPS * env.environment.config.time_step
    print(f"reset: {1e3 * median['reset']:.1f} ms")
    print(f"SoftGrasp-v0: {simulated / median['episode']:.1f} times real time")
    print(f"box_grasp, no signal read: {2.0 / median['box']:.1f} times real time")
    gains = [2 * one / two for one, two in zip(rounds["one"], rounds["two"], strict=True)]
    steps = [ENVIRONMENTS * one / many for one, many in zip(rounds["episode"], rounds["many"], strict=True)]
    print(f"{ENVIRONMENTS} environments in MuJoCo: {np.median(steps):.1f} times the steps a second of computing time")
    print(f"two processes: {np.median(gains):.2f} times the steps of one")
    for vector in vectors.values():
        vector.close()
