"""Thins out and rounds the states of a fit for the file that keeps them."""

from collections.abc import Sequence

import numpy as np

from soft_gripper.arrays import Array
from soft_gripper.scenario.fitted_states_config import FittedStatesConfig
from soft_gripper.sensors.fitted_states import FittedStates, Widths

_MAX_STATES = 400  # states that are kept
_DIGITS = 6
_MIN_NUMBER = 1e-12  # smaller numbers are rounding


def kept_states(
    names: Sequence[str],
    fitted: FittedStates,
    widths: Widths,
    noise: float = 0.0,
    disagreement: float = float("inf"),
    sizes: Array | None = None,
    most: int = _MAX_STATES,
) -> FittedStatesConfig:
    """Fields of a file that keeps `most` states; an infinite disagreement is unknown.

    `sizes` are those of the errors in the states, (n, K).
    """
    chosen = fitted.thinned(most)
    growth, noise, limit = _rounded([widths.growth, noise, disagreement if np.isfinite(disagreement) else 0.0])
    return FittedStatesConfig(
        names=list(names),
        spread=_rounded(fitted.spread),
        states=[_rounded(state) for state in fitted.states[chosen]],
        floor=_rounded(widths.floor),
        sizes=[] if sizes is None else [_rounded(size) for size in sizes[chosen]],
        growth=growth,
        noise=noise,
        disagreement=limit if np.isfinite(disagreement) else None,
    )


def _rounded(values: Sequence[float] | np.ndarray) -> list[float]:
    return [0.0 if abs(value) < _MIN_NUMBER else float(f"{value:.{_DIGITS}g}") for value in values]
