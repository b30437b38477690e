"""Learning the gentle grasp: CMA-ES over its few parameters."""

from collections.abc import Callable, Sequence
from typing import NamedTuple

import cma
import numpy as np

from soft_gripper.arrays import Array
from soft_gripper.learning.environment import SoftGripperEnv
from soft_gripper.learning.gentle_grasp.episodes import Episode, run_episodes
from soft_gripper.learning.gentle_grasp.policies import NUMBER, GentleGrasp, GentleParameters

FAILURE = 20.0  # N, what an object that is not held up counts as
LARGEST = 2.0  # N, beyond which a force counts no more, lest one accident hide all else
SPREAD = 0.25  # of the logarithm of each parameter, at first
FIRST_SEED = 1_000_000  # of the episodes that are learned from; those that are compared have smaller ones


class Generation(NamedTuple):
    """What a generation of candidates came to."""

    number: int
    episodes: int  # so far
    cost: float  # N, mean of its candidates
    best_cost: float  # N, of the best one
    peak_force: float  # N, mean over the episodes of all
    success: float  # share of these


def cost(episodes: Sequence[Episode]) -> float:
    """Mean peak force, N, failures counting as much more."""
    return float(np.mean([min(e.peak_force, LARGEST) + FAILURE * (not e.success) for e in episodes]))


def learn(
    env: SoftGripperEnv,
    generations: int,
    population: int,
    episodes: int,
    seed: int,
    report: Callable[[Generation], None] = lambda _: None,
) -> tuple[GentleParameters, list[Generation]]:
    """Learns; returns the mean of the last generation's distribution, and how it went.

    All candidates of a generation meet the same objects, those of the next meet others.

    Args:
        env: SoftGrasp-v0.
        generations, population, episodes: how many, candidates in each, and objects that each of these meets.
        seed: of the search, 1 or more.
        report: called with every generation.
    """
    search = cma.CMAEvolutionStrategy(np.zeros(NUMBER), SPREAD, {"seed": seed, "popsize": population, "verbose": -9})
    curve: list[Generation] = []
    for number in range(generations):
        first = FIRST_SEED + number * episodes
        factors: list[Array] = search.ask()
        runs = [run_episodes(env, _policy(each), range(first, first + episodes)) for each in factors]
        costs = [*map(cost, runs)]
        search.tell(factors, costs)
        flat = [episode for run in runs for episode in run]
        force, share = (float(np.mean([each[i] for each in flat])) for i in (2, 1))
        curve.append(
            Generation(number, (number + 1) * len(flat), float(np.mean(costs)), min(costs), force, share)
        )
        report(curve[-1])
    return GentleParameters.scaled(search.result.xfavorite), curve


def _policy(factors: Array) -> GentleGrasp:
    return GentleGrasp(GentleParameters.scaled(factors))
