"""Runs a design study: the search, and the test of the best design with new draws and unseen objects.

The best design is compared with the unchanged fingers under their best drive: the fields of the drive that the study
varies are searched for these fingers too, with as many designs and the same draws.

Every simulation is a row of one table, by which an interrupted study is resumed. Designs are proposed in batches, and
the search learns the scores of a batch in their order, so that the table depends neither on the number of processes nor
on interruptions.
"""

from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import asdict, dataclass
from math import inf
from pathlib import Path
from typing import Any

import numpy as np
from scipy.stats import qmc

from soft_gripper.errors import InputError
from soft_gripper.extras.design.measures import OWN
from soft_gripper.extras.design.mould import least_wall
from soft_gripper.extras.design.ranking import Design, DesignScore, Row, costs, find_best, pareto_front, score
from soft_gripper.extras.design.search import Designs, searched_designs
from soft_gripper.extras.design.study_file import DesignStudy, fix_ranges
from soft_gripper.extras.sweeps.axes import Axis, Range
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
# Number of the design that changes nothing. Those of the search are counted from 1, and those that differ in their
# drive alone from -1 down.
SHIPPED = 0
_DRIVE_PARTS = ("pressure", "tendons", "control")  # parts of a scenario that drive fingers


SEARCH, TEST = "search", "test"  # stages


Cases = Mapping[tuple[str, str], Mapping[str, Any]]  # changes of the scenario, by the cells of object and draw


def cases(stage: str, objects: Mapping[str, Mapping[str, Any]], draws: int, seed: int) -> Cases:
    """Cases of every object and draw; one draw if nothing is random.

    Those of the search are spread by a Latin hypercube, so that few cover the ranges; those of the test are
    independent, so that a proportion has a confidence interval. Neither depends on the other objects.
    """
    case_changes = {}
    for name, changes in objects.items():
        range_count = sum(isinstance(value, Range) for value in changes.values())
        rng = np.random.default_rng([seed, *f"{stage} {name}".encode()])
        fractions = rng.random((draws, range_count))
        if range_count and stage == SEARCH:
            fractions = qmc.LatinHypercube(range_count, rng=rng).random(draws)
        for draw, row in enumerate(fractions.tolist() if range_count else [[]]):
            case_changes[name, str(draw)] = fix_ranges(changes, row)
    return case_changes


@dataclass(frozen=True)
class DesignResult:
    """Result of a design study: all designs, the best one, and its test.

    designs: the scenario as it is, then all that were tried, in order.
    reference: the fingers as they are, with the best drive; the scenario as it is, if nothing of the drive is varied.
    front: indices of the allowed designs on the Pareto front.
    best: index of the best design; None if no design is allowed.
    tests: table cells and scenario changes of the test runs, those of the reference first, then of the best design.
    """

    study: DesignStudy
    designs: Sequence[Design]
    reference: Design
    front: Sequence[int]
    best: int | None
    tests: Sequence[tuple[Row, Mapping[str, Any]]]


def run_design(
    study: DesignStudy,
    out: Path,
    executor: Executor,
    resume: bool = False,
    report: Callable[[bool], Any] = lambda is_held: None,
) -> DesignResult:
    """Searches the best design, and tests it beside the reference, with new draws and unseen objects.

    Args:
        study: its variables and ends.
        out: a folder, created if needed; its table gets a row as each run ends.
        executor: makes the runs.
        resume: keep existing rows.
        report: called after each run, with whether the object is held.

    Raises:
        InputError: if a measure does not exist, the scenario or an object cannot be built, every run of the scenario as
            it is fails, `out` cannot be written to, or the study to resume is a different one.
    """
    config = study.config
    runs = _Runs(study, out, executor, resume, report)
    first = Design(SHIPPED, {}, runs.scores({SHIPPED: {}})[0])
    errors = [runs.row(key)[ERROR] for key in runs.changes]
    if errors and all(errors):
        raise InputError(study.file, "scenario", study.scenario, f"every run of it fails: {errors[0]}")
    numbers = range(1, 1 + config.designs)
    drive_designs = [first, *searched_designs(_drive_axes(study), config, [-number for number in numbers], runs.scores)]
    results = [*searched_designs(study.axes, config, numbers, runs.scores)]
    reference = drive_designs[find_best(costs(drive_designs, config.ends)) or 0]
    cost = costs(results, config.ends)
    best_index = find_best(cost)
    finalists = [reference] if best_index is None else [reference, results[best_index]]
    tests = runs.tests({design.number: design.values for design in finalists})
    runs.finish(runs.changes)
    front_numbers = [i + 1 for i in pareto_front(cost)]
    best_number = None if best_index is None else best_index + 1
    return DesignResult(study, [first, *results], reference, front_numbers, best_number, tests)


def _drive_axes(study: DesignStudy) -> list[Axis]:
    """Variables of the search that drive the fingers."""
    return [axis for axis in study.axes if axis.key.partition(".")[0] in _DRIVE_PARTS]


def most_runs(study: DesignStudy) -> int:
    """Number of runs of a study if no design is refused."""
    search_cases, test_cases = _all_cases(study)
    design_count = 1 + study.config.designs * (1 + bool(_drive_axes(study)))
    return design_count * len(search_cases) + 2 * len(test_cases)


def _all_cases(study: DesignStudy) -> tuple[Cases, Cases]:
    """Cases of the search and of the test."""
    config = study.config
    search_cases = cases(SEARCH, study.objects, config.draws, config.seed)
    return search_cases, cases(TEST, {**study.objects, **study.unseen}, config.test_draws, config.seed)


class _Runs(ScenarioRuns):
    """Runs of a study in a table; `changes` has the changes to the scenario in each run, in row order."""

    def __init__(self, study: DesignStudy, out: Path, executor: Executor, resume: bool, report: Callable[[bool], Any]):
        self._study, self._executor, self._report = study, executor, report
        self._searched, self._tested = _all_cases(study)
        self._own = own_measures(study)
        kind = kind_of(changed_scenario(study.scenario, study.fixed))
        measures = [*names_of(kind), *columns_of(list(self._own.values()))]
        _check_measures(study, measures)
        drawn_keys = (key for changes in (*self._searched.values(), *self._tested.values()) for key in changes)
        varied_keys = dict.fromkeys((*(axis.key for axis in study.axes), *drawn_keys))
        super().__init__(out, TABLE, ABOUT, [STAGE, DESIGN, OBJECT, DRAW], [*varied_keys, *measures])
        first_changes = {**study.fixed, **next(iter(self._searched.values()))}
        self._fixed = {**study.fixed, **engine_step_of(study.scenario, first_changes, executor)}
        self._scenario = changed_scenario(study.scenario, self._fixed)
        self.begin_runs(self._scenario, resume, "optuna", study=asdict(study.config))
        self.changes: dict[tuple[str, ...], Mapping[str, Any]] = {}

    def scores(self, designs: Designs) -> list[DesignScore]:
        """Scores designs in the search, without running designs that cannot be moulded."""
        config = self._study.config
        refusals = {number: refusal(self._study, values) for number, values in designs.items()}
        keys = self._run(
            SEARCH, {n: designs[n] for n, refused_score in refusals.items() if refused_score is None}, self._searched
        )
        return [
            refused_score or score([self.row(key) for key in keys if key[1] == str(number)], config.ends, config.limits)
            for number, refused_score in refusals.items()
        ]

    def tests(self, designs: Designs) -> list[tuple[Row, Mapping[str, Any]]]:
        """Runs the test of designs."""
        return [(self.row(key), self.changes[key]) for key in self._run(TEST, designs, self._tested)]

    def _run(self, stage: str, designs: Designs, in_cases: Cases) -> list[tuple[str, ...]]:
        """Makes the runs of each design that are missing in the table; returns the keys of all."""
        changes: dict[tuple[str, ...], Mapping[str, Any]] = {
            (stage, str(number), *case): {**self._fixed, **draw, **values}
            for number, values in designs.items()
            for case, draw in in_cases.items()
        }
        self.run_changed(
            self._executor,
            self._scenario,
            (self._study.scenario, changes),
            (list(self._own.values()),),
            lambda row: self._report(row[GRASP] == HELD),
        )
        self.changes |= changes
        return list(changes)

    def row(self, key: tuple[str, ...]) -> dict[str, str]:
        """The cells of a row by column; own measures by the names that the study gives them."""
        row = super().row(key)
        return row | {name: row[column_of(measure)] for name, measure in self._own.items()}


def own_measures(study: DesignStudy) -> dict[str, str]:
    """Measures of a study beyond those of a sweep, as "module:function", by their names in the study."""
    names = [*(end.measure for end in study.config.ends), *study.config.limits]
    return {name: OWN.get(name, name) for name in names if ":" in name or name in OWN}


def _check_measures(study: DesignStudy, available: Sequence[str]) -> None:
    config = study.config
    if GRASP not in available:
        expected = "has no free object to hold, or does not record its contact (record.truth)"
        raise InputError(study.file, "scenario", study.scenario, expected)
    measures = Registry[Any]("measure", dict.fromkeys(available[1:]) | OWN)
    places = {f"ends[{i}].measure": end.measure for i, end in enumerate(config.ends)}
    for place, name in (places | {f"limits.{name}": name for name in config.limits}).items():
        measures.find(name, place, study.file)


def refusal(study: DesignStudy, values: Mapping[str, Any]) -> DesignScore | None:
    """Refuses a design before its simulation if its fingers cannot be built or their walls are too thin; else None."""
    try:
        scenario = changed_scenario(study.scenario, {**study.fixed, **values})
        fingers = [mounted.finger for model in scenario.models for mounted in mounted_fingers(model, model.name)]
    except InputError as error:
        return DesignScore(refused=str(error))
    wall = study.config.wall
    min_wall = min(map(least_wall, fingers), default=inf)
    if wall is None or min_wall >= wall:
        return None
    reason = f"a wall of {1e3 * min_wall:.2f} mm, below {1e3 * wall:g} mm"
    return DesignScore(refused=reason, excess={"wall": 1 - min_wall / wall})
