"""The states that a model was fitted to, in the file of a calibration or of an identified finger.

A state has D numbers, each named with its unit; (S, D) states give the half widths of the bands of K errors.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from soft_gripper.arrays import Array
from soft_gripper.quantity import Violation, quantity
from soft_gripper.sensors.fitted_states import FittedStates, Widths


@dataclass
class FittedStatesConfig:
    """States of drive and shape, thinned out, and how the errors of the model grow away from them."""

    names: list[str] = quantity([], filled=True)  # of the numbers of a state, with their units
    spread: list[float] = quantity([], above=0)  # unit of each number, in which distances are taken
    states: list[list[float]] = quantity([], filled=True)
    floor: list[float] = quantity([], least=0, filled=True)  # half width of the 95 % band of each error near them
    # Of every state, by which floor and growth of each error are multiplied there; empty: 1
    sizes: list[list[float]] = quantity([], least=0)
    growth: float = quantity(0.0, least=0)  # of these, by the root of the distance
    noise: float = quantity(0.0, least=0)  # spreads, by which single samples are away from states that are medians
    # Spreads, within which readings and drive agree; null: not known
    disagreement: float | None = quantity(None, least=0)

    def violations(self) -> Iterator[Violation]:
        count = len(self.names)
        if len(self.spread) != count:
            yield "spread", self.spread, f"must be {count} numbers, one for every name"
        for i, state in enumerate(self.states):
            if len(state) != count:
                yield f"states[{i}]", state, f"must be {count} numbers, one for every name"
        if self.sizes and [len(sizes) for sizes in self.sizes] != [len(self.floor)] * len(self.states):
            yield "sizes", f"{len(self.sizes)} rows", f"must be {len(self.floor)} numbers for each of the states"

    @property
    def fitted(self) -> FittedStates:
        return FittedStates(np.array(self.states), np.array(self.spread))

    @property
    def widths(self) -> Widths:
        return Widths(np.array(self.floor), self.growth)

    def sizes_near(self, states: Array) -> Array:
        """The sizes of the nearest state, (..., D) -> (..., K)."""
        if not self.sizes:
            return np.ones((*np.shape(states)[:-1], len(self.floor)))
        return np.array(self.sizes)[self.fitted.nearest(states)]
