"""A design study from its file to its result: the search, and the test of the best design on what it was not given.

The best design is compared with the fingers as they are, driven as well as they can be: those fields of the drive that
the study varies are searched for them too, with as many designs and the same draws.

Every simulation is a row of one table, by which an interrupted study is resumed. Designs are proposed in batches, and
the search learns the scores of a batch in their order, so that the table depends neither on the number of processes nor
on interruptions.
"""

import json
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import asdict, dataclass
from importlib.metadata import version
from pathlib import Path
from typing import Any, NamedTuple

from soft_gripper.diagrams.simulation import check_closed
from soft_gripper.diagrams.station import make_station
from soft_gripper.errors import InputError
from soft_gripper.extras.design.cases import SEARCH, TEST, Case, cases
from soft_gripper.extras.design.measures import OWN
from soft_gripper.extras.design.ranking import GRASP, WALL, Score, best, costs, pareto_front, score
from soft_gripper.extras.design.search import DesignSearch
from soft_gripper.extras.design.study_file import DesignConfig, DesignStudy
from soft_gripper.extras.design.walls import least_wall
from soft_gripper.registry import Registry
from soft_gripper.runs.scores.grasp import HELD
from soft_gripper.runs.sweep.measures import column_of, kind_of, names_of
from soft_gripper.runs.sweep.run_sweep import ERROR, Axis, ScenarioRuns, Work, engine_step_of, measured_runs
from soft_gripper.scenario.model_files import mounted_fingers
from soft_gripper.scenario.scenario_file import changed_scenario, dump_scenario

TABLE, ABOUT = "runs.csv", "study.json"
STAGE, DESIGN, OBJECT, DRAW = "stage", "design", "object", "draw"
# Number of the design that changes nothing. Those of the search are counted from 1, and those that differ in their
# drive alone from -1 down.
SHIPPED = 0
_DRIVE = ("pressure", "tendons", "control")  # parts of a scenario that say how fingers are driven
Measures = Mapping[str, Any]


@dataclass(frozen=True)
class Design:
    """A design and its score in the search; values by dotted keys, none of the scenario as it is."""

    number: int
    values: Mapping[str, Any]
    score: Score


class DesignTest(NamedTuple):
    """A design in the test: the measures of its runs with each object."""

    number: int
    rows: Mapping[str, Sequence[Measures]]


@dataclass(frozen=True)
class Designed:
    """The result of a study.

    designs: the scenario as it is, then all that were tried, in order.
    reference: the fingers as they are, with the best drive; the scenario as it is, if nothing of the drive is varied.
    front: indices of allowed designs than which no other is better in every end.
    best: index of the best design; None if no design is allowed.
    tested: the reference, and the best design.
    """

    study: DesignStudy
    designs: Sequence[Design]
    reference: Design
    front: Sequence[int]
    best: int | None
    tested: Sequence[DesignTest]


def run_design(
    study: DesignStudy,
    out: Path,
    executor: Executor,
    resume: bool = False,
    report: Callable[[bool], Any] = lambda held: None,
    work: Work = measured_runs,
) -> Designed:
    """Searches the best design, and tests it beside the reference, with new draws and unseen objects.

    Args:
        study: what varies, and to which ends.
        out: a folder, created if needed; its table gets a row as each run ends.
        executor: makes the runs.
        resume: keep existing rows.
        report: called after each run, with whether the object is held.
        work: makes runs; see `measured_runs`.

    Raises:
        InputError: if a measure does not exist, the scenario or an object cannot be built, every run of the scenario as
            it is fails, `out` cannot be written to, or the study to resume is a different one.
    """
    config = study.config
    runs = _Runs(study, out, executor, resume, report, work)
    shipped = runs.shipped()
    numbers = range(1, 1 + config.designs)
    driven = [shipped, *_searched(config, _drive_axes(study), [-number for number in numbers], runs)]
    designs = [shipped, *_searched(config, study.axes, numbers, runs)]
    reference = driven[best(costs([design.score for design in driven], config.ends)) or 0]
    cost = costs([design.score for design in designs[1:]], config.ends)
    chosen = best(cost)
    best_index = None if chosen is None else chosen + 1
    compared = [reference] if best_index is None else [reference, designs[best_index]]
    tested = runs.tests({design.number: design.values for design in compared})
    runs.finish(runs.order)
    return Designed(study, designs, reference, [i + 1 for i in pareto_front(cost)], best_index, tested)


def _drive_axes(study: DesignStudy) -> list[Axis]:
    """Variables of the search that drive the fingers."""
    return [axis for axis in study.axes if axis.key.partition(".")[0] in _DRIVE]


def _searched(config: DesignConfig, axes: Sequence[Axis], numbers: Sequence[int], runs: "_Runs") -> Iterator[Design]:
    """Designs with these numbers; none if nothing is searched."""
    search = DesignSearch(axes, config.ends, len(numbers), config.seed)
    for begin in range(0, len(numbers) if axes else 0, config.batch):
        among = numbers[begin : begin + config.batch]
        batch = dict(zip(among, search.ask(len(among)), strict=True))
        scores = runs.scores(batch)
        search.tell(scores)
        yield from (Design(*each, score) for each, score in zip(batch.items(), scores, strict=True))


def most_runs(study: DesignStudy) -> int:
    """The runs of a study of which no design is refused."""
    searched, tested = _all_cases(study)
    tried = 1 + study.config.designs * (1 + bool(_drive_axes(study)))
    return tried * len(searched) + 2 * len(tested)


def _all_cases(study: DesignStudy) -> tuple[list[Case], list[Case]]:
    """Cases of the search and of the test."""
    config = study.config
    searched = cases(SEARCH, study.objects, config.draws, config.seed)
    return searched, cases(TEST, {**study.objects, **study.unseen}, config.test_draws, config.seed)


def tested_runs(found: Designed) -> list[tuple[Measures, dict[str, Any]]]:
    """The runs of the test: the row of each, and its changes of the scenario."""
    study, (_, tested) = found.study, _all_cases(found.study)
    values = {design.number: design.values for design in (*found.designs, found.reference)}
    return [
        (row, {**study.fixed, **case.changes, **values[test.number]})
        for test in found.tested
        for case in tested
        for row in test.rows[case.object]
        if row[DRAW] == case.key[1]
    ]


class _Runs(ScenarioRuns):
    """The runs of a study, in a table."""

    def __init__(
        self,
        study: DesignStudy,
        out: Path,
        executor: Executor,
        resume: bool,
        report: Callable[[bool], Any],
        work: Work,
    ):
        self._study, self._executor, self._report, self._work = study, executor, report, work
        self._searched, self._tested = _all_cases(study)
        self._own = own_measures(study)
        _check(study, [*self._searched, *self._tested])
        measures = names_of(kind_of(changed_scenario(study.scenario, study.fixed)), list(self._own.values()))
        _check_measures(study, measures)
        drawn = dict.fromkeys(key for case in (*self._searched, *self._tested) for key in case.changes)
        varied = dict.fromkeys((*(axis.key for axis in study.axes), *drawn))
        super().__init__(out, TABLE, ABOUT, [STAGE, DESIGN, OBJECT, DRAW], [*varied, *measures])
        first = {**study.fixed, **self._searched[0].changes}
        self._fixed = {**study.fixed, **engine_step_of(study.scenario, first, executor)}
        self._scenario = scenario = changed_scenario(study.scenario, self._fixed)
        self.begin(_about(study, dump_scenario(scenario)), resume)
        self.order: list[tuple[str, ...]] = []

    def shipped(self) -> Design:
        """The scenario as it is.

        Raises:
            InputError: if every run of it fails.
        """
        (score,) = self.scores({SHIPPED: {}})
        errors = [self.row(key)[ERROR] for key in self.order]
        if errors and all(errors):
            raise InputError(self._study.file, "scenario", self._study.scenario, f"every run of it fails: {errors[0]}")
        return Design(SHIPPED, {}, score)

    def scores(self, designs: Mapping[int, Mapping[str, Any]]) -> list[Score]:
        """The scores of designs in the search; those that cannot be moulded are not run."""
        config = self._study.config
        refused = {number: refusal(self._study, values) for number, values in designs.items()}
        rows = self._rows(SEARCH, {n: designs[n] for n, each in refused.items() if each is None}, self._searched)
        return [
            each if each is not None else score(rows[number], config.ends, config.limits)
            for number, each in refused.items()
        ]

    def tests(self, designs: Mapping[int, Mapping[str, Any]]) -> list[DesignTest]:
        """The test of designs."""
        names = dict.fromkeys(case.object for case in self._tested)
        return [
            DesignTest(number, {name: [row for row in rows if row[OBJECT] == name] for name in names})
            for number, rows in self._rows(TEST, designs, self._tested).items()
        ]

    def _rows(
        self, stage: str, designs: Mapping[int, Mapping[str, Any]], in_cases: Sequence[Case]
    ) -> dict[int, list[dict[str, str]]]:
        """The rows of each design in some cases: those that the table has, and those of new runs."""
        own = list(self._own.values())
        changes: dict[tuple[str, ...], Mapping[str, Any]] = {
            (stage, str(number), *in_case.key): {**self._fixed, **in_case.changes, **values}
            for number, values in designs.items()
            for in_case in in_cases
        }
        given = self._study.scenario, changes
        self.run_changed(
            self._executor, self._work, self._scenario, given, (own,), lambda row: self._report(row[GRASP] == HELD)
        )
        self.order += changes
        return {n: [self.row((stage, str(n), *in_case.key)) for in_case in in_cases] for n in designs}

    def row(self, key: tuple[str, ...]) -> dict[str, str]:
        """The cells of a row by column; own measures by the names that the study gives them."""
        row = super().row(key)
        return row | {name: row[column_of(own)] for name, own in self._own.items()}


def own_measures(study: DesignStudy) -> dict[str, str]:
    """Measures that a sweep does not have, as "module:function", by their names in the study."""
    named = [*(end.measure for end in study.config.ends), *study.config.limits]
    return {name: OWN.get(name, name) for name in named if ":" in name or name in OWN}


def _check_measures(study: DesignStudy, known: Sequence[str]) -> None:
    config = study.config
    if GRASP not in known:
        expected = "has no free object to hold, or does not record its contact (record.truth)"
        raise InputError(study.file, "scenario", study.scenario, expected)
    measures = Registry[Any]("measure", dict.fromkeys(known[1:]) | OWN)
    named = {f"ends[{i}].measure": end.measure for i, end in enumerate(config.ends)}
    for place, name in (named | {f"limits.{name}": name for name in config.limits}).items():
        measures.find(name, place, study.file)


def _check(study: DesignStudy, in_cases: Sequence[Case]) -> None:
    """Checks that the first run with every object can be built.

    Raises:
        InputError: if it cannot.
    """
    first = {case.object: case for case in reversed(in_cases)}
    for case in first.values():
        place = f"{study.file}: {'objects' if case.object in study.objects else 'unseen'}.{case.object}"
        try:
            check_closed(make_station(changed_scenario(study.scenario, {**study.fixed, **case.changes})))
        except InputError as error:
            raise error.inside(place) from error.__cause__


def refusal(study: DesignStudy, values: Mapping[str, Any]) -> Score | None:
    """Why a design is not worth a simulation: its fingers cannot be built, or their walls are too thin."""
    wall = study.config.wall
    try:
        scenario = changed_scenario(study.scenario, {**study.fixed, **values})
        fingers = [mounted.finger for model in scenario.models for mounted in mounted_fingers(model, model.name)]
    except InputError as error:
        return Score(refused=str(error))
    least = min(map(least_wall, fingers), default=float("inf"))
    if wall is None or least >= wall:
        return None
    reason = f"a wall of {1e3 * least:.2f} mm, below {1e3 * wall:g} mm"
    return Score(refused=reason, excess={WALL: 1 - least / wall})


def _about(study: DesignStudy, scenario: str) -> str:
    """A description of a study, by which another one is told from it."""
    versions = {name: version(name) for name in ("soft-gripper", "drake", "numpy", "optuna")}
    parts = {"versions": versions, "study": asdict(study.config), "resolved": scenario.splitlines()}
    return json.dumps(parts, indent=1, default=str) + "\n"
