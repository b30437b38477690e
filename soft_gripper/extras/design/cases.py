"""The runs of one design: every object with a number of random draws, the same for every design."""

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
from scipy.stats import qmc

from soft_gripper.extras.design.study_file import with_shares
from soft_gripper.runs.sweep.run_sweep import Range


class Case(NamedTuple):
    """An object and a draw, as changes of the scenario."""

    object: str
    draw: int
    changes: Mapping[str, Any]

    @property
    def key(self) -> tuple[str, str]:
        """The cells that name it in tables."""
        return self.object, str(self.draw)


SEARCH, TEST = "search", "test"


def cases(stage: str, objects: Mapping[str, Mapping[str, Any]], draws: int, seed: int) -> list[Case]:
    """The draws with every object; one only, if nothing is random.

    Those of the search are spread by a Latin hypercube, so that few cover the ranges; those of the test are
    independent, so that a proportion has a confidence interval. Neither depends on the other objects.
    """
    found = []
    for name, changes in objects.items():
        count = sum(isinstance(value, Range) for value in changes.values())
        rng = np.random.default_rng([seed, *f"{stage} {name}".encode()])
        shares = rng.random((draws, count))
        if count and stage == SEARCH:
            shares = qmc.LatinHypercube(count, rng=rng).random(draws)
        for draw, row in enumerate(shares.tolist() if count else [[]]):
            found.append(Case(name, draw, with_shares(changes, row)))
    return found
