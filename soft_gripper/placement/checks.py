"""What can be wrong with a search for a placement, found before any work is done."""

from collections.abc import Mapping, Sequence

import numpy as np

from soft_gripper.diagrams.station_parts import Station
from soft_gripper.errors import InputError
from soft_gripper.evaluation.contacts.dataset import Contacts
from soft_gripper.fingers.finger import Finger
from soft_gripper.placement.assumptions import Assumptions
from soft_gripper.placement.placements import equal_placement
from soft_gripper.runs.estimator_functions import estimator_function
from soft_gripper.runs.scores.recorded_run import RecordedRun
from soft_gripper.scenario.scenario import Scenario
from soft_gripper.sensors.sensor_layout import SensorLayout

_WHERE = "place-sensors"


def check_runs(count: int, runs: Mapping[str, Station | RecordedRun], others: Sequence[Finger] = ()) -> None:
    """Checks what sensors are to be placed by, before it is simulated or read.

    Raises:
        InputError: unless all runs, by name, have steps of pressure, and all their fingers and `others` as many
            segments, at least `count`.
    """
    for name, run in runs.items():
        _check_has_held_steps(name, run.scenario)
    fingers = [*others, *(finger.finger for run in runs.values() for finger in run.fingers)]
    for finger in fingers:
        equal_placement(finger, count)
    segments = sorted({finger.segments for finger in fingers})
    if len(segments) > 1:
        expected = "choose runs and contacts whose fingers have as many; borders lie where segments meet"
        raise InputError(_WHERE, "segments", segments, expected)


def _check_has_held_steps(name: str, scenario: Scenario) -> None:
    others = {"task": scenario.task, "control.set_points": scenario.control.set_points, "external": scenario.external}
    for field, value in others.items():
        if value:
            raise InputError(name, field, "given", "sensors are placed by scenarios with steps of pressure alone")


def check_contacts(contacts: Contacts, assumptions: Assumptions) -> None:
    """Raises an InputError if the estimator estimates no contact."""
    layout = SensorLayout(contacts.finger, 1)
    estimate = estimator_function(assumptions.estimator, layout, assumptions.uncertainty)
    if estimate(np.zeros(layout.readings), np.zeros(contacts.finger.segments), 0j).contact is None:
        expected = "estimates no contact; leave --contacts out, or give --estimator contact"
        raise InputError(_WHERE, "--estimator", assumptions.estimator, expected)
