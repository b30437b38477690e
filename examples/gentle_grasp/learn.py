"""Learns the gentle grasp with CMA-ES over its few parameters, and stores the result in a file."""

from collections.abc import Iterator, Sequence
from dataclasses import asdict
from itertools import count
from pathlib import Path
from typing import NamedTuple

import cma
import numpy as np
import yaml
from gymnasium.utils.seeding import np_random

from gentle_grasp.episodes import Environments, Episode, run_episodes
from gentle_grasp.policies import NUMBER, Array, GentleGrasp, GentleParameters
from soft_gripper.extras.learning.config import VariationConfig, load_environment
from soft_gripper.extras.learning.episode_variation import draw

SHIPPED = Path(__file__).with_name("learned.yaml")

FAILURE = 20.0  # N, the cost of an object that is not held up
MAX_FORCE = 2.0  # N, larger forces are capped, so that one accident does not hide everything else
INITIAL_STD = 0.2  # of the logarithm of each parameter
FIRST_SEED = 1_000_000  # of the objects that are learned from; those that are compared have smaller ones
OBJECTS = 100  # to choose from


class Generation(NamedTuple):
    """Results of a generation of candidates."""

    number: int
    episodes: int  # so far
    cost: float  # N, mean of its candidates
    best_cost: float  # N, of the best one
    peak_force: float  # N, mean over the episodes of all, but for those that diverged
    success: float  # share of these


def cost(episodes: Sequence[Episode]) -> float:
    """Mean peak force, N, failures counting as much more; a diverged episode (NaN) counts as MAX_FORCE."""
    return float(np.mean([np.fmin(e.peak_force, MAX_FORCE) + FAILURE * (not e.success) for e in episodes]))


def learn(
    environments: Environments, population: int, episodes: int, seed: int
) -> Iterator[tuple[GentleParameters, Generation]]:
    """Yields the mean of the distribution and the results of every generation, for as long as it is iterated.

    All candidates meet the same objects: with other objects in every generation, one without hard objects would
    reward candidates that drop them.

    Args:
        environments: of SoftGrasp-v0.
        population, episodes: candidates in a generation, and objects that each of them meets.
        seed: of the search, 1 or more.
    """
    search = cma.CMAEvolutionStrategy(
        np.zeros(NUMBER), INITIAL_STD, {"seed": seed, "popsize": population, "verbose": -9}
    )
    seeds = training_seeds(episodes)
    for number in count():
        factors: list[Array] = search.ask()
        policies = [GentleGrasp(GentleParameters.scaled(factor)) for factor in factors for _ in seeds]
        flat = run_episodes(environments, policies, seeds * population)
        costs = [cost(flat[i : i + episodes]) for i in range(0, len(flat), episodes)]
        search.tell(factors, costs)
        force, share = (float(np.nanmean([getattr(e, name) for e in flat])) for name in ("peak_force", "success"))
        so_far = (number + 1) * len(flat)
        generation = Generation(number, so_far, float(np.mean(costs)), min(costs), force, share)
        yield GentleParameters.scaled(search.result.xfavorite), generation


def training_seeds(number: int) -> list[int]:
    """Seeds of `number` objects: half of them random, and half the hardest to hold of a hundred."""
    common = number // 2
    others = range(FIRST_SEED, FIRST_SEED + OBJECTS)
    variation = load_environment("soft_grasp").config.variation
    hardest = sorted(others[common:], key=lambda seed: holding_difficulty(seed, variation))[common - number :]
    return [*others[:common], *hardest]


def holding_difficulty(seed: int, variation: VariationConfig) -> float:
    """Difficulty of holding the object of a seed: its mass over its friction, kg."""
    drawn = draw(np_random(seed)[0], variation)
    assert drawn.mass is not None
    assert drawn.friction is not None
    return drawn.mass / drawn.friction


def save_learned(path: Path, parameters: GentleParameters, curve: list[Generation]) -> None:
    """Writes the parameters and the history of the search."""
    document = {"parameters": asdict(parameters), "curve": [generation._asdict() for generation in curve]}
    path.write_text(yaml.safe_dump(document), encoding="utf-8")


def load_learned(path: Path = SHIPPED) -> tuple[GentleParameters, list[Generation]]:
    """Reads a file written by `save_learned`; by default, the result shown in the docs."""
    document = yaml.safe_load(path.read_text(encoding="utf-8"))
    return GentleParameters(**document["parameters"]), [Generation(**row) for row in document["curve"]]
