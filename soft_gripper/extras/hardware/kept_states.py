"""The states of a fit as a file keeps them: thinned out, and rounded."""

from collections.abc import Sequence

import numpy as np

from soft_gripper.arrays import Array
from soft_gripper.scenario.fitted_states_config import FittedStatesConfig
from soft_gripper.sensors.fitted_states import FittedStates, Widths

_MOST = 400  # states that are kept
_DIGITS = 6
_NOTHING = 1e-12  # smaller numbers are rounding


def kept_states(
    names: Sequence[str],
    fitted: FittedStates,
    widths: Widths,
    noise: float = 0.0,
    disagreement: float = float("inf"),
    sizes: Array | None = None,
    most: int = _MOST,
) -> FittedStatesConfig:
    """Fields of a file that keeps `most` states; an infinite disagreement is not known.

    Sizes, (n, K), are those of the errors in the states.
    """
    kept = fitted.thinned(most)
    growth, noise, apart = _rounded([widths.growth, noise, disagreement if np.isfinite(disagreement) else 0.0])
    return FittedStatesConfig(
        names=list(names),
        spread=_rounded(fitted.spread),
        states=[_rounded(state) for state in fitted.states[kept]],
        floor=_rounded(widths.floor),
        sizes=[] if sizes is None else [_rounded(size) for size in sizes[kept]],
        growth=growth,
        noise=noise,
        disagreement=apart if np.isfinite(disagreement) else None,
    )


def _rounded(values: Sequence[float] | np.ndarray) -> list[float]:
    return [0.0 if abs(value) < _NOTHING else float(f"{value:.{_DIGITS}g}") for value in values]
