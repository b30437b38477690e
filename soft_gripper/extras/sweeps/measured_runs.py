"""Runs of a scenario with changes, and their measures."""

import math
from collections.abc import Iterator, Mapping, Sequence
from concurrent.futures import Executor
from typing import Any

from soft_gripper.diagrams.simulation import Run, run_many
from soft_gripper.errors import InputError
from soft_gripper.extras.sweeps.own_measures import own_measures
from soft_gripper.extras.sweeps.study import describe
from soft_gripper.registry import registered
from soft_gripper.runs.measures import measure
from soft_gripper.scenario.scenario_file import changed_scenario
from soft_gripper.scenario.schema import DRAKE, Scenario

DEPENDS, ERROR = "depends_on_step", "error"  # what a run tells beside its measures
GRASP = "grasp"  # the measure that tells whether an object is held
STEP, ENGINE_STEP = "plant_config.time_step", "engine_step"
_DIFFERENT, _NEGLIGIBLE = 0.05, 0.01  # share of a measure, and in its unit, that a time step may change


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
    (measures,) = _measured(scenario, [changes], own, check_step)
    if isinstance(measures, Exception):
        raise measures
    return measures


def measured_runs(
    scenario: str, changes: Sequence[Mapping[str, Any]], own: Sequence[str] = (), check_step: bool = False
) -> list[dict[str, Any]]:
    """The measures of many runs, which an engine may make together; of a run that fails the "error" alone.

    Arguments as of `run_and_measure`, `changes` for each run.
    """
    runs = _measured(scenario, changes, own, check_step)
    return [{ERROR: describe(run)} if isinstance(run, Exception) else run for run in runs]


def _measured(
    scenario: str, changes: Sequence[Mapping[str, Any]], own: Sequence[str], check_step: bool
) -> Sequence[dict[str, Any] | Exception]:
    scenarios = [_changed(scenario, change) for change in changes]
    measures = list(_all_measures(scenarios, own))
    if not check_step:
        return measures
    steps = [_half_steps(changed) if isinstance(changed, Scenario) else {} for changed in scenarios]
    halves = [_changed(scenario, {**change, **step}) for change, step in zip(changes, steps, strict=True)]
    return [_compared(*pair) for pair in zip(measures, _all_measures(halves, own), strict=True)]


def _half_steps(scenario: Scenario) -> dict[str, float]:
    """Changes of a scenario that halve all time steps."""
    changes = {STEP: scenario.plant_config.time_step / 2}
    return changes if scenario.engine_step is None else changes | {ENGINE_STEP: scenario.engine_step / 2}


def _changed(scenario: str, changes: Mapping[str, Any]) -> Scenario | Exception:
    try:
        return changed_scenario(scenario, changes)
    except InputError as error:
        return error


def _all_measures(
    scenarios: Sequence[Scenario | Exception], own: Sequence[str]
) -> Iterator[dict[str, Any] | Exception]:
    """The measures of a run of each scenario that could be read, or the error."""
    runs = run_many([scenario for scenario in scenarios if isinstance(scenario, Scenario)], described=bool(own))
    for scenario in scenarios:
        run = scenario if isinstance(scenario, Exception) else next(runs)
        try:
            yield run if isinstance(run, Exception) else _measures(run, own)
        except InputError as error:  # of a user's measure
            yield error


def _measures(run: Run, own: Sequence[str]) -> dict[str, Any]:
    """The measures of a run; users may read whatever there is."""
    if not run.station.fingers:
        models = [model.file for model in run.station.scenario.models]
        raise InputError("sweep", "models", models, "there is no <finger> in them")
    return measure(run.station, run.recording) | own_measures(own, run.station, run.recording)


def _compared(measures: dict[str, Any] | Exception, halved: dict[str, Any] | Exception) -> dict[str, Any] | Exception:
    """The measures of a run, with the names of those that depend on its time step."""
    if isinstance(measures, Exception) or isinstance(halved, Exception):
        return measures if isinstance(measures, Exception) else halved
    return measures | {DEPENDS: " ".join(depends_on_step(measures, halved))}


def depends_on_step(measures: Mapping[str, Any], halved: Mapping[str, Any]) -> list[str]:
    """The measures of a run that differ by more than 5 % and 0.01 of their units with half the time step."""
    return [name for name, value in measures.items() if _differ(value, halved[name])]


def _differ(x: Any, y: Any) -> bool:
    if not isinstance(x, float) or not isinstance(y, float) or math.isnan(x) or math.isnan(y):
        return str(x) != str(y)
    return not abs(x - y) <= max(_DIFFERENT * max(abs(x), abs(y)), _NEGLIGIBLE)


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


def engine_step(scenario: Scenario) -> float | None:
    """The longest step, s, of the engine that simulates a scenario, for runs of it with changes; None: there is none,
    or it cannot be run itself.

    Raises:
        InputError: if the engine cannot simulate the scenario.
    """
    if scenario.engine == DRAKE or scenario.engine_step is not None:
        return scenario.engine_step
    steps = registered("ENGINE_STEPS")
    return steps[scenario.engine](scenario) if scenario.engine in steps else None
