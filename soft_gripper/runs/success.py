"""Success of a run, by the criteria of its scenario and, for a task that holds an object, of its judge."""

from dataclasses import dataclass
from typing import Any

from soft_gripper.diagrams.recording import Recording
from soft_gripper.diagrams.station_parts import Station
from soft_gripper.errors import InputError
from soft_gripper.runs.measures import kind_of, measure, names_of
from soft_gripper.runs.scores.recorded_task import Judged, TaskCriterion, TaskRun, task_criteria
from soft_gripper.scenario.schema import Criterion, Scenario, read_criterion


@dataclass(frozen=True)
class CriterionRow:
    """A criterion of success, whether a run meets it, and the measured value or the failure."""

    criterion: str
    met: bool
    measured: str


def success_criteria(scenario: Scenario) -> list[str]:
    """Success criteria of a scenario, as text.

    Raises:
        InputError: if a criterion names a measure that runs of the scenario do not have.
    """
    judged = [criterion.text for criterion in _judged_criteria(scenario)]
    return judged + [criterion.text for criterion in _own_criteria(scenario)]


def success_rows(station: Station, recording: Recording) -> list[CriterionRow]:
    """Compares a run with each criterion.

    Raises:
        InputError: if a criterion names a measure that runs of the scenario do not have.
    """
    judged = _judged_criteria(station.scenario)
    own_criteria = _own_criteria(station.scenario)
    rows = []
    if judged:
        run = TaskRun(station, recording)
        failures = [(criterion.text, criterion.failure(run)) for criterion in judged]
        rows = [CriterionRow(text, not cause, cause) for text, cause in failures]
    measures = measure(station, recording) if own_criteria else {}
    for criterion in own_criteria:
        value = measures[criterion.measure]
        rows.append(CriterionRow(criterion.text, criterion.is_met(value), _measure_text(value)))
    return rows


def _measure_text(value: Any) -> str:
    """Text of a measure, in three digits or more."""
    return str(value) if not isinstance(value, float) else f"{value:.0f}" if abs(value) >= 1000 else f"{value:.3g}"


def _judged_criteria(scenario: Scenario) -> list[TaskCriterion]:
    """Criteria of the task, if runs of the scenario are judged."""
    return task_criteria(scenario.task) if scenario.task is not None and Judged in kind_of(scenario) else []


def _own_criteria(scenario: Scenario) -> list[Criterion]:
    measures = names_of(kind_of(scenario))
    criteria = [criterion for text in scenario.success if (criterion := read_criterion(text)) is not None]
    for i, criterion in enumerate(criteria):
        if criterion.measure not in measures:
            raise InputError("scenario", f"success[{i}]", criterion.text, f"measures are {', '.join(measures)}")
    return criteria
