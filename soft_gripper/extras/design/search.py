"""The search: a sampler of Optuna proposes designs, and learns from their scores.

The tree-structured Parzen estimator (TPE: J. Bergstra et al., *Algorithms for Hyper-Parameter Optimization*, 2011; with
several ends Y. Ozaki et al., 2022; with limits S. Watanabe and F. Hutter, *c-TPE*, 2023) takes numbers, whole numbers
and choices at once, and needs few designs. Proposals depend on the seed, and on the scores in their order, alone: the
same scores lead to the same search, so that an interrupted one goes on where it stopped.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np

from soft_gripper.errors import InputError
from soft_gripper.extras.design.ranking import Score
from soft_gripper.extras.design.study_file import LEAST, EndConfig
from soft_gripper.runs.sweep.run_sweep import Axis, Range

STARTS = 4  # random designs for each variable, before the search learns


class DesignSearch:
    """Proposes designs, and learns from their scores.

    Raises:
        InputError: if Optuna is not installed.
    """

    def __init__(self, axes: Sequence[Axis], ends: Sequence[EndConfig], designs: int, seed: int):
        try:
            import optuna
        except ImportError:
            raise InputError("design", "search", "optuna", "pip install 'soft-gripper[design]'") from None
        optuna.logging.set_verbosity(optuna.logging.WARNING)
        starts = min(max(10, STARTS * len(axes)), max(designs // 3, 1))
        sampler = optuna.samplers.TPESampler(n_startup_trials=starts, multivariate=True, seed=seed)
        directions = ["minimize" if end.towards == LEAST else "maximize" for end in ends]
        self._study = optuna.create_study(directions=directions, sampler=sampler)
        self._axes, self._count, self._asked = axes, len(ends), list[Any]()

    def ask(self, count: int) -> list[dict[str, Any]]:
        """Proposes a number of designs, as values by dotted keys."""
        self._asked = [self._study.ask() for _ in range(count)]
        return [{axis.key: _value(trial, axis) for axis in self._axes} for trial in self._asked]

    def tell(self, scores: Sequence[Score]) -> None:
        """Learns the scores of the designs last proposed, in their order."""
        for trial, score in zip(self._asked, scores, strict=True):
            for name, excess in (score.excess or {"refused": 1.0}).items():
                trial.set_constraint(name, excess)
            ends = np.array(score.ends) if score.is_allowed else np.zeros(self._count)  # not looked at
            self._study.tell(trial, ends.tolist())


def _value(trial: Any, axis: Axis) -> Any:
    if not isinstance(axis, Range):
        return axis.values[trial.suggest_categorical(axis.key, list(range(len(axis.values))))]
    if axis.is_whole:
        return trial.suggest_int(axis.key, int(axis.least), int(axis.most))
    span = axis.most - axis.least
    return axis.at((trial.suggest_float(axis.key, axis.least, axis.most) - axis.least) / span)
