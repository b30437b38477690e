"""Runs a design study: the search, and the test of the best design with new draws and unseen objects.

The best design is compared with the unchanged fingers under their best drive: the fields of the drive that the study
varies are searched for these fingers too, with as many designs and the same draws.

Every simulation is a row of one table, by which an interrupted study is resumed. Designs are proposed in batches by a
tree-structured Parzen estimator (TPE: J. Bergstra et al., *Algorithms for Hyper-Parameter Optimization*, 2011; with
several ends Y. Ozaki et al., 2022; with limits S. Watanabe and F. Hutter, *c-TPE*, 2023), which learns the scores of a
batch in their order: the table depends on the seed, but neither on the number of processes nor on interruptions.

A design is first of all allowed or not: every run has to hold its object and to stay within the limits. By how much it
is not, each as a number above 0, leads the search back. Allowed designs are then compared by their ends.
"""

from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import asdict, dataclass, field
from math import inf, isnan, nan
from pathlib import Path
from typing import Any

import numpy as np
from scipy.stats import qmc

from soft_gripper.arrays import Array
from soft_gripper.errors import InputError
from soft_gripper.extras.design.measures import OWN
from soft_gripper.extras.design.mould import least_wall
from soft_gripper.extras.design.study_file import (
    LEAST,
    MEAN,
    DesignConfig,
    DesignStudy,
    EndConfig,
    LimitConfig,
    fix_ranges,
)
from soft_gripper.extras.sweeps.axes import Axis, Range
from soft_gripper.extras.sweeps.cells import numbers_in
from soft_gripper.extras.sweeps.measured_runs import ERROR, GRASP, engine_step_of
from soft_gripper.extras.sweeps.own_measures import column_of, columns_of
from soft_gripper.extras.sweeps.scenario_runs import ScenarioRuns
from soft_gripper.registry import Registry
from soft_gripper.runs.measures import kind_of, names_of
from soft_gripper.runs.scores.grasp import HELD
from soft_gripper.scenario.model_files import mounted_fingers
from soft_gripper.scenario.scenario_file import changed_scenario

TABLE, ABOUT = "runs.csv", "study.json"
STAGE, DESIGN, OBJECT, DRAW = "stage", "design", "object", "draw"
SEARCH, TEST = "search", "test"  # stages
# Number of the design that changes nothing. Those of the search are counted from 1, and those that differ in their
# drive alone from -1 down.
SHIPPED = 0
STARTS = 4  # random designs for each variable, before the search learns
_DRIVE_PARTS = ("pressure", "tendons", "control")  # parts of a scenario that drive fingers

Cases = Mapping[tuple[str, str], Mapping[str, Any]]  # changes of the scenario, by the cells of object and draw
Row = Mapping[str, str]  # cells of a run by column
Designs = Mapping[int, Mapping[str, Any]]  # values by dotted keys, by the numbers of designs


@dataclass(frozen=True)
class Design:
    """A design and the summary of its runs in the search.

    values: by dotted keys; empty for the unchanged scenario.
    held: runs in which the object is held, of `runs`.
    ends: the value of each end; NaN if it is not known in a run that holds.
    excess: excess over each limit, by its name; 0 or less: it is kept.
    refused: reason for which it was not simulated; empty if it was.
    """

    number: int
    values: Mapping[str, Any]
    held: int = 0
    runs: int = 0
    ends: tuple[float, ...] = ()
    excess: Mapping[str, float] = field(default_factory=dict)
    refused: str = ""

    @property
    def is_allowed(self) -> bool:
        """Whether it holds everything, within all limits."""
        return not self.refused and all(value <= 0 for value in self.excess.values())

    @property
    def reason(self) -> str:
        """Text that says why a design is not allowed; empty if it is."""
        if self.refused or self.held < self.runs:
            return self.refused or f"holds in {self.held} of {self.runs} runs"
        return "; ".join(f"not: {name}" for name, excess in self.excess.items() if excess > 0)


@dataclass(frozen=True)
class DesignResult:
    """Result of a design study: all designs, the best one, and its test.

    designs: the scenario as it is, then all that were tried, in the order of their numbers.
    reference: the fingers as they are, with the best drive; the scenario as it is, if nothing of the drive is varied.
    front: numbers of the designs on the Pareto front.
    best: None if no design is allowed.
    tests: table cells and scenario changes of the test runs, those of the reference first, then of the best design.
    """

    study: DesignStudy
    designs: Sequence[Design]
    reference: Design
    front: Sequence[int]
    best: Design | None
    tests: Sequence[tuple[Row, Mapping[str, Any]]]


def run_design(
    study: DesignStudy,
    out: Path,
    executor: Executor,
    resume: bool = False,
    report: Callable[[], Any] = lambda: None,
) -> DesignResult:
    """Searches the best design, and tests it beside the reference, with new draws and unseen objects.

    `out` is created if needed; its table gets a row as each run ends, then `report` is called.

    Raises:
        InputError: if a measure does not exist, the scenario or an object cannot be built, every run of the scenario as
            it is fails, `out` cannot be written to, or the study to resume is a different one.
    """
    config = study.config
    runs = _Runs(study, out, executor, resume, report)
    (first,) = runs.search({SHIPPED: {}})
    errors = [runs.row(key)[ERROR] for key in runs.changes]
    if errors and all(errors):
        raise InputError(study.file, "scenario", study.scenario, f"every run of it fails: {errors[0]}")
    numbers = range(1, 1 + config.designs)
    drive_designs = [first]
    if drive_axes := _drive_axes(study):
        drive_designs += _search(runs, drive_axes, [-number for number in numbers])[0]
    designs, front = _search(runs, study.axes, numbers)
    reference, best = find_best(drive_designs, config.ends) or first, find_best(designs, config.ends)
    finalists = [reference] if best is None else [reference, best]
    tests = runs.run_designs(TEST, {design.number: design.values for design in finalists})
    runs.finish(runs.changes)
    return DesignResult(study, [first, *designs], reference, front, best, tests)


def _drive_axes(study: DesignStudy) -> list[Axis]:
    """Variables of the search that drive the fingers."""
    return [axis for axis in study.axes if axis.key.partition(".")[0] in _DRIVE_PARTS]


def most_runs(study: DesignStudy) -> int:
    """Number of runs of a study if no design is refused."""
    design_count = 1 + study.config.designs * (1 + bool(_drive_axes(study)))
    return design_count * len(_cases(study, SEARCH)) + 2 * len(_cases(study, TEST))


def _cases(study: DesignStudy, stage: str) -> Cases:
    """Cases of every object and draw; one draw if nothing is random.

    Those of the search are spread by a Latin hypercube, so that few cover the ranges; those of the test are
    independent, so that a proportion has a confidence interval. Neither depends on the other objects.
    """
    is_search = stage == SEARCH
    draws = study.config.draws if is_search else study.config.test_draws
    cases = {}
    for name, changes in (study.objects if is_search else {**study.objects, **study.unseen}).items():
        range_count = sum(isinstance(value, Range) for value in changes.values())
        rng = np.random.default_rng([study.config.seed, *f"{stage} {name}".encode()])
        fractions = rng.random((draws if range_count else 1, range_count))
        if range_count and is_search:
            fractions = qmc.LatinHypercube(range_count, rng=rng).random(draws)
        for draw, row in enumerate(fractions.tolist()):
            cases[name, str(draw)] = fix_ranges(changes, row)
    return cases


def _search(runs: "_Runs", axes: Sequence[Axis], numbers: Sequence[int]) -> tuple[list[Design], list[int]]:
    """Designs with these numbers, each batch proposed from the scores before, and the numbers of the Pareto front."""
    try:
        import optuna
    except ImportError:
        raise InputError("design", "search", "optuna", "pip install 'soft-gripper[design]'") from None
    optuna.logging.set_verbosity(optuna.logging.WARNING)
    config = runs.study.config
    starts = min(max(10, STARTS * len(axes)), max(len(numbers) // 3, 1))
    sampler = optuna.samplers.TPESampler(n_startup_trials=starts, multivariate=True, seed=config.seed)
    directions = ["minimize" if end.towards == LEAST else "maximize" for end in config.ends]
    study = optuna.create_study(directions=directions, sampler=sampler)
    designs = list[Design]()
    for begin in range(0, len(numbers), config.batch):
        trials = {number: study.ask() for number in numbers[begin : begin + config.batch]}
        batch = {n: {axis.key: _suggest_value(trial, axis) for axis in axes} for n, trial in trials.items()}
        designs += runs.search(batch)
        for trial, design in zip(trials.values(), designs[begin:], strict=True):
            for name, excess in (design.excess or {"refused": 1.0}).items():
                trial.set_constraint(name, excess)
            study.tell(trial, list(design.ends) if design.is_allowed else [0.0] * len(config.ends))  # not looked at
    return designs, [numbers[trial.number] for trial in study.best_trials]


def _suggest_value(trial: Any, axis: Axis) -> Any:
    if not isinstance(axis, Range):
        return axis.values[trial.suggest_categorical(axis.key, list(range(len(axis.values))))]
    if axis.is_whole:
        return trial.suggest_int(axis.key, int(axis.least), int(axis.most))
    return axis.at((trial.suggest_float(axis.key, axis.least, axis.most) - axis.least) / (axis.most - axis.least))


class _Runs(ScenarioRuns):
    """Runs of a study in a table; `changes` has the changes to the scenario in each run, in row order."""

    def __init__(self, study: DesignStudy, out: Path, executor: Executor, resume: bool, report: Callable[[], Any]):
        self.study, self._executor, self._report = study, executor, report
        self._cases = {stage: _cases(study, stage) for stage in (SEARCH, TEST)}
        measures = names_of(kind_of(changed_scenario(study.scenario, study.fixed)))
        measures = [*measures, *columns_of(own_measures(study))]
        _check_measures(study, measures)
        all_changes = [changes for cases in self._cases.values() for changes in cases.values()]
        keys = dict.fromkeys([*(axis.key for axis in study.axes), *(key for changes in all_changes for key in changes)])
        super().__init__(out, TABLE, ABOUT, [STAGE, DESIGN, OBJECT, DRAW], [*keys, *measures])
        self._fixed = {**study.fixed, **engine_step_of(study.scenario, {**study.fixed, **all_changes[0]}, executor)}
        self._scenario = changed_scenario(study.scenario, self._fixed)
        self.begin_runs(self._scenario, resume, "optuna", study=asdict(study.config))
        self.changes: dict[tuple[str, ...], Mapping[str, Any]] = {}

    def search(self, designs: Designs) -> list[Design]:
        """Scores designs, without running those that cannot be moulded."""
        refusals = {number: refuse(self.study, number, values) for number, values in designs.items()}
        runs = self.run_designs(SEARCH, {number: designs[number] for number in designs if refusals[number] is None})
        return [
            refusals[n] or score_design(n, values, [row for row, _ in runs if row[DESIGN] == str(n)], self.study.config)
            for n, values in designs.items()
        ]

    def run_designs(self, stage: str, designs: Designs) -> list[tuple[Row, Mapping[str, Any]]]:
        """Makes the runs of each design that are missing in the table; returns the cells and changes of all."""
        changes: dict[tuple[str, ...], Mapping[str, Any]] = {
            (stage, str(number), *case): {**self._fixed, **draw, **values}
            for number, values in designs.items()
            for case, draw in self._cases[stage].items()
        }
        given, measures = (self.study.scenario, changes), (own_measures(self.study),)
        self.run_changed(self._executor, self._scenario, given, measures, lambda row: self._report())
        self.changes |= changes
        return [(self.row(key), run_changes) for key, run_changes in changes.items()]


def own_measures(study: DesignStudy) -> list[str]:
    """Measures of a study beyond those of a sweep, as "module:function"."""
    names = dict.fromkeys([*(end.measure for end in study.config.ends), *study.config.limits])
    return [OWN.get(name, name) for name in names if ":" in name or name in OWN]


def _check_measures(study: DesignStudy, available: Sequence[str]) -> None:
    if GRASP not in available:
        expected = "has no free object to hold, or does not record its contact (record.truth)"
        raise InputError(study.file, "scenario", study.scenario, expected)
    measures = Registry[Any]("measure", dict.fromkeys(available[1:]) | OWN)
    for i, end in enumerate(study.config.ends):
        measures.find(end.measure, f"ends[{i}].measure", study.file)
    for name in study.config.limits:
        measures.find(name, f"limits.{name}", study.file)


def refuse(study: DesignStudy, number: int, values: Mapping[str, Any]) -> Design | None:
    """Refuses a design before its simulation if its fingers cannot be built or their walls are too thin; else None."""
    try:
        scenario = changed_scenario(study.scenario, {**study.fixed, **values})
        fingers = [mounted.finger for model in scenario.models for mounted in mounted_fingers(model, model.name)]
    except InputError as error:
        return Design(number, values, refused=str(error))
    wall = study.config.wall
    min_wall = min(map(least_wall, fingers), default=inf)
    if wall is None or min_wall >= wall:
        return None
    reason = f"a wall of {1e3 * min_wall:.2f} mm, below {1e3 * wall:g} mm"
    return Design(number, values, refused=reason, excess={"wall": 1 - min_wall / wall})


def score_design(number: int, values: Mapping[str, Any], rows: Sequence[Row], config: DesignConfig) -> Design:
    """The score of a design from the measures of its runs; a run that failed has none."""
    held_rows, ends = summarize_runs(rows, config.ends)
    excess = {GRASP: 1 - len(held_rows) / len(rows)}
    for name, limit in config.limits.items():
        excess |= _excess(name, limit, numbers_in([row[column_of(name)] for row in held_rows]))
    excess |= {f"{end.measure} is known": 1.0 for end, value in zip(config.ends, ends, strict=True) if isnan(value)}
    return Design(number, values, len(held_rows), len(rows), ends, excess)


def summarize_runs(rows: Sequence[Row], ends: Sequence[EndConfig]) -> tuple[list[Row], tuple[float, ...]]:
    """The runs that hold their object, and the value of each end over them, NaN where a run lacks it or none holds."""
    held_rows = [row for row in rows if row[GRASP] == HELD]
    if not held_rows:
        return [], (nan,) * len(ends)
    end_values = []
    for end in ends:
        values = numbers_in([row[column_of(end.measure)] for row in held_rows])
        worst = np.max if end.towards == LEAST else np.min
        end_values.append(float(np.mean(values) if end.of == MEAN else worst(values)))
    return held_rows, tuple(end_values)


def _excess(name: str, limit: LimitConfig, values: Array) -> dict[str, float]:
    """Excess of the worst run over the limits of a measure, relative to them; 1 if unknown."""
    is_known = len(values) > 0 and not np.isnan(values).any()
    bounds = {"least": (limit.least, -1), "most": (limit.most, 1)}
    return {
        f"{name} at {kind} {bound:g}": float(np.max(sign * (values - bound)) / (abs(bound) or 1)) if is_known else 1.0
        for kind, (bound, sign) in bounds.items()
        if bound is not None
    }


def find_best(designs: Sequence[Design], ends: Sequence[EndConfig]) -> Design | None:
    """The allowed design that is best by the first end, among equals by the next; None if no one is allowed."""
    signs = [1.0 if end.towards == LEAST else -1.0 for end in ends]
    allowed = [design for design in designs if design.is_allowed]
    return min(allowed, key=lambda design: [*np.multiply(signs, design.ends)], default=None)
