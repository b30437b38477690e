"""A sweep: a scenario run with many values of its fields by an executor, with a folder from which it can be resumed."""

import itertools
import json
import math
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import Executor
from contextlib import suppress
from dataclasses import dataclass
from importlib.metadata import version
from numbers import Integral, Real
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.figure import Figure
from scipy.stats import qmc

from soft_gripper.arrays import Array
from soft_gripper.diagrams.simulation import Run, check_closed, engine_step, run_many, runs_at_once
from soft_gripper.diagrams.station import make_station
from soft_gripper.errors import InputError
from soft_gripper.files.number import number
from soft_gripper.files.output import lock_folder
from soft_gripper.files.yaml_text import parse_yaml
from soft_gripper.pictures.style import STYLE
from soft_gripper.runs.agreement import Agreement, agreement, chosen
from soft_gripper.runs.scores.grasp import HELD
from soft_gripper.runs.study import StudyTables, describe, results
from soft_gripper.runs.sweep.measures import OPTION, column_of, kind_of, measure, names_of
from soft_gripper.scenario.scenario_file import changed_scenario, dump_scenario
from soft_gripper.scenario.schema import DRAKE, Scenario

PANELS = 4  # maximum number of measures drawn
GRASP = "grasp"  # the measure that tells whether an object is held
_MOST_TICKS = 9  # values of a key that each have a tick
Column = Sequence[str]


def sweep_figure(varied: Mapping[str, Column], measured: Mapping[str, Column], title: str) -> Figure | None:
    """Plots measures over one key as lines, over two keys as maps; None for more keys, or if no measure is numeric.

    The first few measures that vary are drawn; runs whose object is not held are crossed out.

    Args:
        varied: cells of the varied keys.
        measured: cells of the measures; empty if a run failed.
        title: title of the figure.
    """
    numbers = {name: numbers_in(cells) for name, cells in measured.items()}
    drawn = {name: values for name, values in numbers.items() if np.isfinite(values).any()}
    drawn = {name: values for name, values in drawn.items() if _varies(values)} or drawn
    if len(varied) not in (1, 2) or not drawn:
        return None
    with mpl.rc_context(STYLE):
        drawn = dict(list(drawn.items())[:PANELS])
        lost = np.array([cell not in ("", HELD) for cell in measured.get(GRASP, ())], bool)
        title += ", crosses: not held" if lost.any() else ""
        figure = Figure(figsize=(4.2 * len(drawn), 3.6), layout="constrained")
        figure.suptitle(title, x=0.01, ha="left")
        for axes, (name, values) in zip(figure.subplots(1, len(drawn), squeeze=False)[0], drawn.items(), strict=True):
            places = [_place(axes, axis, cells) for axis, cells in zip("xy", varied.values(), strict=False)]
            for axis, (key, cells) in zip("xy", varied.items(), strict=False):
                axes.set(**{f"{axis}label": f"{key} [%]" if cells[0].endswith("%") else key})
            if len(places) == 1:
                _draw_line(axes, places[0], values, name)
            else:
                _draw_map(figure, axes, places, values, name)
            if lost.any():
                y = places[1] if len(places) > 1 else values
                axes.plot(places[0][lost], y[lost], "x", color="#b2182b", ms=7)
    return figure


def _varies(values: Array) -> bool:
    """Whether numbers, of which some may be NaN, differ by more than a thousandth."""
    return bool(np.ptp(values[np.isfinite(values)]) > 1e-3 * np.nanmax(np.abs(values)))


def numbers_in(cells: Column) -> Array:
    """Cells as numbers, true as 1 and percentages without their sign; NaN for those that are not numbers."""
    found = np.full(len(cells), np.nan)
    for i, text in enumerate(cells):
        with suppress(ValueError):
            found[i] = _TRUTH[text] if text in _TRUTH else number(text.removesuffix("%"))
    return found


_TRUTH = {"True": 1.0, "False": 0.0}


def _place(axes: Axes, axis: str, cells: Column) -> Array:
    """Positions of cells along an axis, with a tick at each if there are few; numbers, or in order of appearance."""
    numbers = numbers_in(cells)
    if np.isfinite(numbers).all():
        if len(values := np.unique(numbers)) <= _MOST_TICKS:
            axes.set(**{f"{axis}ticks": values})
        return numbers
    labels = list(dict.fromkeys(cells))
    axes.set(**{f"{axis}ticks": range(len(labels)), f"{axis}ticklabels": labels})
    return np.array([float(labels.index(text)) for text in cells])


def _draw_line(axes: Axes, place: Array, values: Array, name: str) -> None:
    order = np.argsort(place, kind="stable")
    axes.plot(place[order], values[order], "o-", ms=4)
    axes.set_ylabel(name)
    axes.grid(alpha=0.3)


def _draw_map(figure: Figure, axes: Axes, places: Sequence[Array], values: Array, name: str) -> None:
    """Draws coloured cells if the points form a grid, otherwise dots; failed runs are crosses."""
    (x, y), failed = places, ~np.isfinite(values)
    columns, rows = np.unique(x), np.unique(y)
    if len(columns) * len(rows) == len(x) and min(len(columns), len(rows)) > 1:
        grid = np.full((len(rows), len(columns)), np.nan)
        grid[np.searchsorted(rows, y), np.searchsorted(columns, x)] = values
        drawn: ScalarMappable = axes.pcolormesh(columns, rows, grid, shading="nearest")
    else:
        drawn = axes.scatter(x[~failed], y[~failed], c=values[~failed], s=20)
    axes.grid(False)
    axes.plot(x[failed], y[failed], "x", color="#b2182b")
    figure.colorbar(drawn, ax=axes, label=name)


MOST_RUNS = 10_000  # in a sweep: more than anyone would wait for
METHODS = ("grid", "latin", "sobol")
SweepPoint = dict[str, Any]  # values by dotted keys, see `changed_scenario`

_NUMBER = r"([-+]?[0-9.]{1,400}(?:[eE][-+]?[0-9]+)?)"
_RANGE = re.compile(rf"\s*+{_NUMBER}\s*+\.\.\s*+{_NUMBER}\s*+(%?)\s*+(?::\s*+([0-9]++))?\s*+")
_SPAN = re.compile(rf"\s*+{_NUMBER}\s*+(?:[-:\u2013]|\.{{3}}|to)\s*+{_NUMBER}\s*+(%?)\s*+")  # in other notations
_ENDS = "give the lower limit, the upper limit, and 2 or more values"
_EXPECTED = "write KEY=1,2,3 or KEY=0.5..0.9:5 (five values) or, with --sample, KEY=0.5..0.9"


@dataclass(frozen=True)
class Values:
    """A key takes each value of a list."""

    key: str
    values: tuple[Any, ...]

    def __post_init__(self) -> None:
        listed = isinstance(self.values, Sequence | np.ndarray) and not isinstance(self.values, str)
        if not listed or not len(self.values):
            raise InputError("sweep", self.key, self.values, "give at least one value, in a tuple")

    def at(self, share: float) -> Any:
        """The value at a fraction, 0 to 1, of the list."""
        return self.values[min(int(share * len(self.values)), len(self.values) - 1)]


@dataclass(frozen=True)
class Range:
    """A key takes any value in a range: integers if both limits are integers, percentages if they are percentages."""

    key: str
    least: float
    most: float
    is_whole: bool = False
    is_relative: bool = False

    def __post_init__(self) -> None:
        fine = isinstance(self.least, Real) and isinstance(self.most, Real)
        if not fine or not -math.inf < self.least < self.most < math.inf:
            raise InputError("sweep", self.key, [self.least, self.most], "give the lower limit, then the upper limit")

    def at(self, share: float) -> Any:
        """The value at a fraction, 0 to 1, of the range."""
        if self.is_whole:
            return min(int(self.least + math.floor(share * (self.most - self.least + 1))), int(self.most))
        value = self.least + share * (self.most - self.least)
        return f"{value:+.9g} %" if self.is_relative else float(f"{value:.12g}")

    def spread(self, count: int) -> Values:
        """A number of equally spaced values, at least two, including both limits."""
        if not isinstance(count, Integral) or count < 2:
            raise InputError("sweep", self.key, count, "give a whole number of values, 2 or more")
        shares = [i / (count - 1) for i in range(count)]
        exact = [self.least + share * (self.most - self.least) for share in shares]
        if self.is_whole and all(value.is_integer() for value in map(float, exact)):
            return Values(self.key, tuple(int(value) for value in exact))
        continuous = Range(self.key, self.least, self.most, False, self.is_relative)
        return Values(self.key, tuple(continuous.at(share) for share in shares))


Axis = Values | Range


def read_axis(text: str) -> Axis:
    """Parses "KEY=VALUES", where VALUES is "1,2,3", "0.5..0.9:5", "0.5..0.9", or "-10..10 %:5".

    Raises:
        InputError: if it cannot be parsed.
    """
    key, equals, values = text.partition("=")
    if not equals or not key or not values.strip():
        raise InputError("sweep", "--vary", text, _EXPECTED)
    if match := _RANGE.fullmatch(values):
        return _read_range(key, text, *match.groups())
    if span := next(filter(None, map(_SPAN.fullmatch, values.strip(" []").split(","))), None):
        ends = f"{span[1]}..{span[2]} {span[3]}".rstrip()
        raise InputError("sweep", "--vary", text, f"write {ends}:N, with N values, or list them")
    try:
        listed = parse_yaml("sweep", f"values: {values if values.lstrip().startswith('[') else f'[{values}]'}")
    except InputError:
        raise InputError("sweep", "--vary", text, _EXPECTED) from None
    found = listed["values"]
    if not isinstance(found, list) or not found:
        raise InputError("sweep", "--vary", text, _EXPECTED)
    return Values(key, tuple(found))


def _read_range(key: str, text: str, least: str, most: str, percent: str, count: str | None) -> Axis:
    if count in ("0", "1"):
        raise InputError("sweep", "--vary", text, _ENDS)
    try:
        is_whole = not percent and all(end.lstrip("+-").isdecimal() for end in (least, most))
        ends = float(least), float(most)
    except ValueError:
        raise InputError("sweep", "--vary", text, _EXPECTED) from None
    number = 2.0 if count is None else float(count)
    if not -math.inf < ends[0] < ends[1] < math.inf or number > MOST_RUNS:
        raise InputError("sweep", "--vary", text, f"{_ENDS}, {MOST_RUNS} at most")
    found = Range(key, *ends, is_whole, bool(percent))
    return found if count is None else found.spread(int(number))


def sweep_points(axes: Sequence[Axis], method: str = "grid", number: int = 0, seed: int = 0) -> list[SweepPoint]:
    """The points of a sweep, in numerical order.

    Args:
        axes: the varied keys, each once.
        method: "grid": all combinations of the values, the last key fastest; "latin" (Latin hypercube) or "sobol"
            (scrambled) sample them and ranges (scipy.stats.qmc).
        number: number of samples.
        seed: seed of the samples.

    Raises:
        InputError: if keys repeat, a range has no values on a grid, the number does not suit the method, or there
            would be more than MOST_RUNS.
    """
    if not isinstance(axes, Sequence) or not axes or not all(isinstance(axis, Axis) for axis in axes):
        raise InputError("sweep", "axes", axes, "give a list of at least one Values or Range")
    if method not in METHODS:
        raise InputError("sweep", "method", method, f"known: {', '.join(METHODS)}")
    for name, value in (("number", number), ("seed", seed)):
        if not isinstance(value, Integral) or value < 0:
            raise InputError("sweep", name, value, "give a whole number, 0 or more")
    keys = [axis.key for axis in axes]
    for key in keys:
        if keys.count(key) > 1:
            raise InputError("sweep", "--vary", key, "appears more than once")
    if method == "grid":
        number = math.prod(len(_listed(axis)) for axis in axes)
    if number > MOST_RUNS:
        expected = f"would be {number} runs, above the limit of {MOST_RUNS}: give fewer values, or a smaller --sample"
        raise InputError("sweep", "--vary", ", ".join(keys), expected)
    if method == "grid":
        return [dict(zip(keys, values, strict=True)) for values in itertools.product(*map(_listed, axes))]
    if number < 1 or (method == "sobol" and number & (number - 1)):
        expected = "give a power of 2, so that the Sobol sequence is balanced" if number else "give a number"
        raise InputError("sweep", "--sample", number, expected)
    engine = {"latin": qmc.LatinHypercube, "sobol": qmc.Sobol}[method]
    shares = engine(len(axes), rng=np.random.default_rng(seed)).random(number)
    return [{axis.key: axis.at(float(share)) for axis, share in zip(axes, row, strict=True)} for row in shares]


def _listed(axis: Axis) -> tuple[Any, ...]:
    if isinstance(axis, Range):
        expected = "give the number of values, such as 0.5..0.9:5, or give --sample"
        raise InputError("sweep", "--vary", axis.key, expected)
    return axis.values


def run_and_measure(
    scenario: str, changes: Mapping[str, Any], own: Sequence[str] = (), check_step: bool = False
) -> dict[str, Any]:
    """Runs a scenario with changes, and computes its measures.

    Args:
        scenario: name of a shipped one, or path of a file.
        changes: values by dotted keys, see `changed_scenario`.
        own: user measures, each as "module:function".
        check_step: run it again with half the time step.

    Returns:
        measures by name, see `measures`; which ones depends on the kind of scenario. With `check_step`, also
        "depends_on_step": the names of those that change, see `depends_on_step`, separated by spaces.

    Raises:
        InputError: if the scenario cannot be built with the changes, or a user measure fails.
        SimulationDivergedError: if the state is no longer finite.
    """
    (found,) = _measured(scenario, [changes], own, check_step)
    if isinstance(found, Exception):
        raise found
    return found


def measured_runs(
    scenario: str, changes: Sequence[Mapping[str, Any]], own: Sequence[str] = (), check_step: bool = False
) -> list[dict[str, Any]]:
    """The measures of many runs, which an engine may make together; of a run that fails the "error" alone.

    Arguments as of `run_and_measure`, `changes` for each run.
    """
    found = _measured(scenario, changes, own, check_step)
    return [{ERROR: describe(each)} if isinstance(each, Exception) else each for each in found]


def _measured(
    scenario: str, changes: Sequence[Mapping[str, Any]], own: Sequence[str], check_step: bool
) -> Sequence[dict[str, Any] | Exception]:
    read = [_changed(scenario, each) for each in changes]
    found = list(_all_measures(read, own))
    if not check_step:
        return found
    steps = [_half_steps(each) if isinstance(each, Scenario) else {} for each in read]
    halves = [_changed(scenario, {**each, **half}) for each, half in zip(changes, steps, strict=True)]
    return [_compared(*both) for both in zip(found, _all_measures(halves, own), strict=True)]


def _half_steps(scenario: Scenario) -> dict[str, float]:
    """Changes of a scenario by which all steps are half as long."""
    halved = {STEP: scenario.plant_config.time_step / 2}
    return halved if scenario.engine_step is None else halved | {ENGINE_STEP: scenario.engine_step / 2}


def _changed(scenario: str, changes: Mapping[str, Any]) -> Scenario | Exception:
    try:
        return changed_scenario(scenario, changes)
    except InputError as error:
        return error


def _all_measures(
    scenarios: Sequence[Scenario | Exception], own: Sequence[str]
) -> Iterator[dict[str, Any] | Exception]:
    """The measures of a run of each scenario that could be read, or the error."""
    runs = run_many([each for each in scenarios if isinstance(each, Scenario)], described=bool(own))
    for each in scenarios:
        run = each if isinstance(each, Exception) else next(runs)
        try:
            yield run if isinstance(run, Exception) else _measures(run, own)
        except InputError as error:  # of a user's measure
            yield error


def _measures(run: Run, own: Sequence[str]) -> dict[str, Any]:
    """The measures of a run; users may read whatever there is."""
    if not run.station.fingers:
        models = [model.file for model in run.station.scenario.models]
        raise InputError("sweep", "models", models, "there is no <finger> in them")
    return measure(run.station, run.recording, own)


def _compared(measured: dict[str, Any] | Exception, halved: dict[str, Any] | Exception) -> dict[str, Any] | Exception:
    """The measures of a run, with those that depend on its time step."""
    if isinstance(measured, Exception) or isinstance(halved, Exception):
        return measured if isinstance(measured, Exception) else halved
    return measured | {DEPENDS: " ".join(depends_on_step(measured, halved))}


def depends_on_step(measured: Mapping[str, Any], halved: Mapping[str, Any]) -> list[str]:
    """The measures of a run that differ by more than 5 % and 0.01 of their units with half the time step."""
    return [name for name, value in measured.items() if _differ(value, halved[name])]


def _differ(one: Any, other: Any) -> bool:
    if not isinstance(one, float) or not isinstance(other, float) or math.isnan(one) or math.isnan(other):
        return str(one) != str(other)
    return not abs(one - other) <= max(_DIFFERENT * max(abs(one), abs(other)), _NEGLIGIBLE)


TABLE, ABOUT = "sweep.csv", "sweep.json"
NUMBER, DEPENDS, ERROR = "run", "depends_on_step", "error"  # the first and the last columns
STEP, ENGINE_STEP = "plant_config.time_step", "engine_step"
_DIFFERENT, _NEGLIGIBLE = 0.05, 0.01  # share of a measure, and in its unit, that a time step may change
_DESCRIBES = ("description",)  # keys that have no effect on a run


def check_keys(scenario: str, fixed: Mapping[str, Any], points: Sequence[SweepPoint]) -> None:
    """Checks the scenario, and the first and last value of each key, before any work is done.

    Raises:
        InputError: if the scenario itself cannot be built, or a key cannot be varied.
    """
    base = changed_scenario(scenario, fixed)
    try:
        check_closed(make_station(base))
    except InputError as error:
        raise error.inside(scenario) from error.__cause__
    for key in points[0]:
        if key in _DESCRIBES:
            raise InputError("sweep", "--vary", key, "cannot be varied: it has no effect on a run")
        for point in (points[0], points[-1]):
            try:
                changed = changed_scenario(scenario, {**fixed, key: point[key]})
            except InputError as error:
                raise error.inside(f"sweep: --vary {key}") from error.__cause__
            if kind_of(changed) != kind_of(base):
                raise InputError("sweep", "--vary", key, "cannot be varied: other kinds of runs have other measures")


def run_sweep(
    scenario: str,
    points: Sequence[SweepPoint],
    out: Path,
    executor: Executor,
    *,
    fixed: Mapping[str, Any] | None = None,
    own: Sequence[str] = (),
    check_step: bool = False,
    resume: bool = False,
    report: Callable[[bool], Any] = lambda fine: None,
) -> list[dict[str, str]]:
    """Runs a scenario at many points, and adds a row to the table in `out` as each ends, including failed ones.

    Args:
        scenario: name of a shipped one, or path of a file.
        points: each with the same keys, see `changed_scenario`.
        out: a folder, created if needed.
        executor: makes the runs.
        fixed: changes applied to every run.
        own: user measures, each as "module:function"; see `measures`.
        check_step: repeat each run with half the time step; one more column names the measures that depend on it.
        resume: keep existing rows.
        report: called after each run, with True if it succeeded.

    Returns:
        the rows of the table, cells by column: the run number, the varied keys, the measures, and an error message,
        empty if the run succeeded.

    Raises:
        InputError: if a key cannot be varied, a measure does not exist, `out` cannot be written to, another process
            writes to it, or the sweep to resume is a different one.
    """
    fixed, keys = dict(fixed or {}), list(points[0])
    check_keys(scenario, fixed, points)
    if scenario.endswith((".yaml", ".yml")):
        scenario = str(Path(scenario).resolve())  # workers may have other working folders
    base = changed_scenario(scenario, fixed)
    names = names_of(kind_of(base), own)
    if check_step and base.plant_config.time_step == 0:
        raise InputError("sweep", STEP, 0.0, "give a time step above 0, which --check-step can halve")
    checked = [DEPENDS] if check_step else []
    columns = [*keys, *names, *checked]
    for name in own:
        if [NUMBER, *columns, ERROR].count(column := column_of(name)) > 1:
            raise InputError("sweep", OPTION, name, f"there is already a column '{column}'; rename the function")
    runs = ScenarioRuns(out, TABLE, ABOUT, [NUMBER], columns)
    if ENGINE_STEP not in keys:
        others = [point for point in points if point.get("engine", DRAKE) != DRAKE]
        engine = {"engine": others[0]["engine"]} if others else {}
        fixed |= engine_step_of(scenario, fixed | engine, executor)
        base = changed_scenario(scenario, fixed)
    runs.begin_runs(base, resume, scenario=scenario, measures=[*own, *checked], runs=list(points))
    changes: dict[tuple[str, ...], Mapping[str, Any]] = {
        (str(number),): fixed | point for number, point in enumerate(points)
    }
    runs.run_changed(executor, base, (scenario, changes), (own, check_step), lambda row: report(row[ERROR] == ""))
    runs.finish(changes)
    return [runs.row(key) for key in changes]


def engine_step_of(scenario: str, changes: Mapping[str, Any], executor: Executor) -> dict[str, float]:
    """The change that gives all runs of a study the step that suits a scenario with changes; none in Drake.

    Nor is there one if the scenario has a step, or cannot be run itself: runs choose their own then.

    Raises:
        InputError: as `engine_step`.
    """
    base = changed_scenario(scenario, changes)
    if base.engine == DRAKE or base.engine_step is not None:
        return {}
    step = executor.submit(_engine_step, scenario, changes).result()
    return {} if step is None else {ENGINE_STEP: step}


def _engine_step(scenario: str, changes: Mapping[str, Any]) -> float | None:
    return engine_step(changed_scenario(scenario, changes))


def agreement_with_drake(
    scenario: str,
    runs: Sequence[tuple[Mapping[str, str], Mapping[str, Any]]],
    checked: int,
    seed: int,
    executor: Executor,
    own: Sequence[str] = (),
) -> list[Agreement]:
    """How the measures of runs in another engine agree with those of some of them in Drake.

    Args:
        scenario: name of a shipped one, or path of a file.
        runs: of the other engine: cells by column, and changes of the scenario; those that failed are left out.
        checked: number of runs to repeat.
        seed: of their choice.
        executor: makes the runs.
        own: user measures.
    """
    fine = [run for run in runs if run[0][ERROR] == ""]
    picked = chosen(len(fine), checked, seed)
    drake = {"engine": DRAKE, ENGINE_STEP: None}
    jobs = {i: (scenario, [{**fine[i][1], **drake}], own) for i in picked}
    repeated = results(executor, measured_runs, jobs)
    both = [(fine[i][0], {name: cell(v) for name, v in repeated[i][0].items()}) for i in picked]
    same = [(row, other) for row, other in both if ERROR not in other]
    return agreement([{name: row[name] for name in other} for row, other in same], [other for _, other in same])


class ScenarioRuns(StudyTables):
    """A table of runs of scenarios with changes: a row has the key of a run, changes, measures, and why it failed."""

    def __init__(self, out: Path, table: str, about: str, keys: Sequence[str], columns: Sequence[str]):
        """`keys` are the columns that identify a run; `columns` are the changed keys of scenarios and the measures.

        Raises:
            InputError: if the folder `out` cannot be written to, or another process writes to it.
        """
        self._names = [*keys, *columns, ERROR]
        super().__init__(lock_folder(out), about, {table: self._names}, len(keys))

    def begin_runs(self, base: Scenario, resume: bool, *packages: str, **parts: Any) -> None:
        """Starts or resumes the table, see `begin`; parts, the scenario and versions tell a study from others.

        `packages` are those that matter beside Drake and numpy.
        """
        versions = {name: version(name) for name in ("soft-gripper", "drake", "numpy", *packages)}
        described = {"versions": versions, "resolved": dump_scenario(base).splitlines()} | parts
        self.begin(json.dumps(described, indent=1, default=str) + "\n", resume)

    def run_changed(
        self,
        executor: Executor,
        base: Scenario,
        given: tuple[str, Mapping[tuple[str, ...], Mapping[str, Any]]],
        others: Sequence[Any],
        report: Callable[[dict[str, str]], Any],
    ) -> None:
        """Makes the runs whose rows do not exist, as many at once as the engine of the scenario is best at.

        Args:
            executor: makes the calls of `measured_runs`.
            base: the scenario, read.
            given: its name or file, and the changes of each run by its key.
            others: further arguments of them.
            report: called with the row of each run.
        """
        scenario, changes = given
        keys = list(changes)
        size = runs_at_once(base, len(keys))
        batches = [tuple(keys[i : i + size]) for i in range(0, len(keys), size)]
        jobs = {batch: (scenario, [changes[key] for key in batch], *others) for batch in batches}

        def keep(batch: tuple[tuple[str, ...], ...], found: Sequence[Mapping[str, Any]]) -> None:
            for key, measured in zip(batch, found, strict=True):
                given = {**dict(zip(self._names, key, strict=False)), **changes[key], **measured}
                if key not in self.rows:
                    self.add([cell(given.get(name)) for name in self._names])

        def failed(batch: tuple[tuple[str, ...], ...], error: str) -> list[dict[str, Any]]:
            return [{ERROR: error}] * len(batch)

        def ended(batch: tuple[tuple[str, ...], ...]) -> None:
            for key in batch:
                report(self.row(key))

        self.run(executor, measured_runs, jobs, keep, failed, ended, keys=lambda batch: batch)

    def row(self, key: tuple[str, ...]) -> dict[str, str]:
        """The cells of a run by column."""
        return dict(zip(self._names, self.rows[key][0], strict=True))


def cell(value: Any) -> str:
    """A value as text; numbers have nine significant digits."""
    if isinstance(value, float):
        return f"{value + 0.0:.9g}"
    return "" if value is None else str(value)
