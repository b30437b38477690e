"""Learns the gentle grasp with CMA-ES over its few parameters, and stores the result in a file."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict
from itertools import count
from pathlib import Path
from typing import Any, NamedTuple

import cma
import numpy as np
import yaml

from gentle_grasp.episodes import Episode, run_episodes
from gentle_grasp.policies import NUMBER, Array, GentleGrasp, GentleParameters
from soft_gripper.extras.learning import SoftGripperEnv

SHIPPED = Path(__file__).with_name("learned.yaml")

FAILURE = 20.0  # N, the cost of an object that is not held up
LARGEST = 2.0  # N, at which a force is capped, so that one accident does not hide everything else
SPREAD = 0.2  # initial one, of the logarithm of each parameter
FIRST_SEED = 1_000_000  # of the objects that are learned from; those that are compared have smaller ones
OBJECTS = 100  # of which some are chosen


class Generation(NamedTuple):
    """Results of a generation of candidates."""

    number: int
    episodes: int  # so far
    cost: float  # N, mean of its candidates
    best_cost: float  # N, of the best one
    peak_force: float  # N, mean over the episodes of all, but for those that diverged
    success: float  # share of these


def cost(episodes: Sequence[Episode]) -> float:
    """Mean peak force, N, failures counting as much more; of an episode that diverged it is not known, NaN: LARGEST."""
    return float(np.mean([np.fmin(e.peak_force, LARGEST) + FAILURE * (not e.success) for e in episodes]))


def learn(
    env: SoftGripperEnv, population: int, episodes: int, seed: int
) -> Iterator[tuple[GentleParameters, Generation]]:
    """Yields the mean of the distribution and the results of every generation, for as long as it is iterated.

    All candidates meet the same objects: with other objects in every generation, one without hard objects would
    reward candidates that drop them.

    Args:
        env: SoftGrasp-v0.
        population, episodes: candidates in a generation, and objects that each of them meets.
        seed: of the search, 1 or more.
    """
    search = cma.CMAEvolutionStrategy(np.zeros(NUMBER), SPREAD, {"seed": seed, "popsize": population, "verbose": -9})
    seeds = training_seeds(env, episodes)
    for number in count():
        factors: list[Array] = search.ask()
        runs = [run_episodes(env, GentleGrasp(GentleParameters.scaled(each)), seeds) for each in factors]
        costs = [*map(cost, runs)]
        search.tell(factors, costs)
        flat = [episode for run in runs for episode in run]
        force, share = (float(np.nanmean([getattr(e, name) for e in flat])) for name in ("peak_force", "success"))
        so_far = (number + 1) * len(flat)
        found = Generation(number, so_far, float(np.mean(costs)), min(costs), force, share)
        yield GentleParameters.scaled(search.result.xfavorite), found


def training_seeds(env: SoftGripperEnv, number: int) -> list[int]:
    """Seeds of `number` objects: half of them random, and half the hardest to hold of a hundred."""
    common, others = number // 2, range(FIRST_SEED, FIRST_SEED + OBJECTS)
    needed = {seed: _needed(env.reset(seed=seed)[1]) for seed in others}
    hardest = sorted(others[common:], key=needed.__getitem__)[common - number :]
    return [*others[:common], *hardest]


def _needed(info: Mapping[str, Any]) -> float:
    """How hard an object is to hold: its mass over its friction, kg."""
    return float(info["mass"] / info["friction"])


def save_learned(path: Path, parameters: GentleParameters, curve: list[Generation]) -> None:
    """Writes the parameters and the history of the search."""
    document = {"parameters": asdict(parameters), "curve": [each._asdict() for each in curve]}
    path.write_text(yaml.safe_dump(document), encoding="utf-8")


def load_learned(path: Path = SHIPPED) -> tuple[GentleParameters, list[Generation]]:
    """Reads a file written by `save_learned`; by default, the result shown in the docs."""
    document = yaml.safe_load(path.read_text(encoding="utf-8"))
    return GentleParameters(**document["parameters"]), [Generation(**each) for each in document["curve"]]
