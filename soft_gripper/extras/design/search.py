"""The search: a sampler of Optuna proposes designs, and learns from their scores.

The tree-structured Parzen estimator (TPE: J. Bergstra et al., *Algorithms for Hyper-Parameter Optimization*, 2011; with
several ends Y. Ozaki et al., 2022; with limits S. Watanabe and F. Hutter, *c-TPE*, 2023) takes numbers, whole numbers
and choices at once, and needs few designs. Proposals depend on the seed, and on the scores in their order, alone: the
same scores lead to the same search, so that an interrupted one goes on where it stopped.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any

from soft_gripper.errors import InputError
from soft_gripper.extras.design.ranking import Design, DesignScore
from soft_gripper.extras.design.study_file import LEAST, DesignConfig
from soft_gripper.extras.sweeps.axes import Axis, Range

STARTS = 4  # random designs for each variable, before the search learns
Designs = Mapping[int, Mapping[str, Any]]  # values by dotted keys, by the numbers of designs


def searched_designs(
    axes: Sequence[Axis],
    config: DesignConfig,
    numbers: Sequence[int],
    scores: Callable[[Designs], Sequence[DesignScore]],
) -> Iterator[Design]:
    """Yields designs with these numbers, proposed in batches from the scores before; none without axes.

    Raises:
        InputError: if Optuna is not installed.
    """
    try:
        import optuna
    except ImportError:
        raise InputError("design", "search", "optuna", "pip install 'soft-gripper[design]'") from None
    optuna.logging.set_verbosity(optuna.logging.WARNING)
    starts = min(max(10, STARTS * len(axes)), max(len(numbers) // 3, 1))
    sampler = optuna.samplers.TPESampler(n_startup_trials=starts, multivariate=True, seed=config.seed)
    directions = ["minimize" if end.towards == LEAST else "maximize" for end in config.ends]
    study = optuna.create_study(directions=directions, sampler=sampler)
    for begin in range(0, len(numbers) if axes else 0, config.batch):
        trials = {number: study.ask() for number in numbers[begin : begin + config.batch]}
        batch = {n: {axis.key: _suggest_value(trial, axis) for axis in axes} for n, trial in trials.items()}
        for (number, trial), score in zip(trials.items(), scores(batch), strict=True):
            for name, excess in (score.excess or {"refused": 1.0}).items():
                trial.set_constraint(name, excess)
            study.tell(trial, list(score.ends) if score.is_allowed else [0.0] * len(config.ends))  # not looked at
            yield Design(number, batch[number], score)


def _suggest_value(trial: Any, axis: Axis) -> Any:
    if not isinstance(axis, Range):
        return axis.values[trial.suggest_categorical(axis.key, list(range(len(axis.values))))]
    if axis.is_whole:
        return trial.suggest_int(axis.key, int(axis.least), int(axis.most))
    span = axis.most - axis.least
    return axis.at((trial.suggest_float(axis.key, axis.least, axis.most) - axis.least) / span)
