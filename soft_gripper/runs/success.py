"""Whether a run is a success, by the criteria of its scenario and, of a task that holds an object, of its judge."""

from dataclasses import dataclass
from typing import Any

from soft_gripper.diagrams.recording import Recording
from soft_gripper.diagrams.station_parts import Station
from soft_gripper.errors import InputError
from soft_gripper.runs.scores.recorded_task import Judged, TaskCriterion, TaskRun, task_criteria
from soft_gripper.runs.sweep.measures import kind_of, measure, names_of
from soft_gripper.scenario.criterion import Criterion, read_criterion
from soft_gripper.scenario.schema import Scenario


@dataclass(frozen=True)
class CriterionRow:
    """A criterion of success, whether a run meets it, and what was measured or went wrong."""

    criterion: str
    met: bool
    measured: str


def success_criteria(scenario: Scenario) -> list[str]:
    """The criteria by which a run of a scenario is a success, as text.

    Raises:
        InputError: if a criterion names a measure that runs of the scenario do not have.
    """
    of_task = [criterion.text for criterion in _of_task(scenario)]
    return of_task + [criterion.text for criterion in _of_scenario(scenario)]


def success_rows(station: Station, recording: Recording) -> list[CriterionRow]:
    """Compares a run with each criterion.

    Raises:
        InputError: if a criterion names a measure that runs of the scenario do not have.
    """
    of_task, own, rows = _of_task(station.scenario), _of_scenario(station.scenario), []
    if of_task:
        run = TaskRun(station, recording)
        failures = [(criterion.text, criterion.failure(run)) for criterion in of_task]
        rows = [CriterionRow(text, not cause, cause) for text, cause in failures]
    measured = measure(station, recording) if own else {}
    for criterion in own:
        value = measured[criterion.measure]
        rows.append(CriterionRow(criterion.text, criterion.is_met(value), _shown(value)))
    return rows


def _shown(value: Any) -> str:
    """A measure in three digits or more."""
    return str(value) if not isinstance(value, float) else f"{value:.0f}" if abs(value) >= 1000 else f"{value:.3g}"


def _of_task(scenario: Scenario) -> list[TaskCriterion]:
    """Criteria of the task, if it is one of those that are judged."""
    return task_criteria(scenario.task) if scenario.task is not None and Judged in kind_of(scenario) else []


def _of_scenario(scenario: Scenario) -> list[Criterion]:
    known = names_of(kind_of(scenario), ())
    found = [criterion for text in scenario.success if (criterion := read_criterion(text)) is not None]
    for i, criterion in enumerate(found):
        if criterion.measure not in known:
            raise InputError("scenario", f"success[{i}]", criterion.text, f"measures are {', '.join(known)}")
    return found
