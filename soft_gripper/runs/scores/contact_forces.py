"""The contact forces of a run, over time or where they count: at the end of each step of pressure or phase of a task.

Where the estimator of the scenario gives no contact force, `contact` estimates it from the readings that were recorded.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from soft_gripper.arrays import Array
from soft_gripper.diagrams.contact_forces import ContactForces, FingerForce, contact_forces
from soft_gripper.diagrams.recording import Recording, phase_spans
from soft_gripper.diagrams.station_parts import Station
from soft_gripper.estimators.contact import ContactShape
from soft_gripper.fingers.plant_finger import PlantFinger
from soft_gripper.runs.scores.narrower_bands import narrower_bands
from soft_gripper.runs.scores.readings import read_recorded
from soft_gripper.runs.scores.recorded_object import precedes_put_down
from soft_gripper.scenario.nominal_model import read_nominal_model
from soft_gripper.scenario.sensor_presets import uncertainty
from soft_gripper.truth.contact import touches

if TYPE_CHECKING:  # imported when a signal is read
    import xarray as xr

ESTIMATOR = "contact"
DRAWN_FORCES = "contact_forces_over_time"  # table of the forces that the picture of a task shows
_DRAWN = 200


def has_forces(station: Station, recording: Recording) -> bool:
    """Whether there are contact forces to report: a finger touches something or, without truth, they are estimated."""
    names = [f"{finger.name}.true_contact_force" for finger in station.fingers]
    true = [recording[name].values for name in names if name in recording.data]
    is_estimated = bool(station.fingers) and not _unestimated_fingers(station, recording)
    return any(touches(np.abs(force)).any() for force in true) if true else is_estimated


def contact_rows(station: Station, recording: Recording) -> list[FingerForce]:
    """A row for each step or phase, at its end, and finger."""
    rows = np.searchsorted(recording["time"].values, _ends(station, recording) + station.scenario.sensor.period / 2) - 1
    return forces_at(station, recording, rows).rows()


def forces_at(station: Station, recording: Recording, rows: NDArray[np.int_]) -> ContactForces:
    """The contact forces of all fingers at some samples of a recording, (M)."""
    data = recording.data.isel(time=rows)
    estimates = [_estimated(station, recording, finger, rows) for finger in _unestimated_fingers(station, recording)]
    return contact_forces(data.assign({name: column for estimate in estimates for name, column in estimate.items()}))


def drawn_forces(station: Station, recording: Recording) -> ContactForces | None:
    """The contact forces at as many samples as a plot shows, evenly spaced; None if there are none to report."""
    rows = np.linspace(0, recording.data.sizes["time"] - 1, _DRAWN).astype(int)
    return forces_at(station, recording, rows) if has_forces(station, recording) else None


def estimator_of_forces(station: Station, recording: Recording) -> str:
    """The estimator of the forces of `forces_at`."""
    return ESTIMATOR if _unestimated_fingers(station, recording) else station.parts.estimator


def end_of_hold(rows: Sequence[FingerForce], station: Station, recording: Recording) -> float:
    """Time of the last of these rows before an object is put down, s; of the last if there is no task that holds one.

    Like the grasp, contact forces are judged there.
    """
    end = np.inf
    if station.task is not None:
        phases = precedes_put_down(recording["task.phase"].values.ravel(), station.task.phases)
        end = recording["time"].values[phases][-1] + 1.5 * station.scenario.sensor.period
    return max(row.time_s for row in rows if row.time_s <= end)


def _ends(station: Station, recording: Recording) -> Array:
    """Ends of the steps or phases, s."""
    if station.task is not None:
        return np.array([span.end for span in phase_spans(recording, station.task.phases)])
    return (np.arange(station.scenario.steps) + 1) * station.scenario.step_duration


def _unestimated_fingers(station: Station, recording: Recording) -> list[PlantFinger]:
    """The fingers without an estimated contact force."""
    return [finger for finger in station.fingers if f"{finger.name}.transverse_force" not in recording.data]


def _estimated(
    station: Station, recording: Recording, finger: PlantFinger, rows: NDArray[np.int_]
) -> "Mapping[str, xr.Variable]":
    """The signals of a contact that `contact` estimates at some samples (M), by their names in a recording.

    None if sensors of the user's own give no readings as the scenario's sensors would.
    """
    import xarray as xr

    inputs = _contact_inputs(station, recording, finger, rows)
    if inputs is None:
        return {}
    function, arguments = inputs
    contact, posterior = function(*arguments).contact, function.posterior(*arguments)
    assert contact is not None
    assert contact.vector is not None
    assert contact.transverse_force is not None
    variables = {
        "contact_force": contact.force,
        "contact_force_std": contact.force_std,
        "contact_arc_length": contact.arc_length,
        "contact_force_vector": contact.vector,
        "transverse_force": contact.transverse_force,
        "transverse_force_interval": posterior.transverse_force_interval,
        "contact_answer": posterior.answer,
    }
    return {
        f"{finger.name}.{name}": xr.Variable(["time", f"{name}_entry"][: values.ndim], values)
        for name, values in variables.items()
    }


def _contact_inputs(
    station: Station, recording: Recording, finger: PlantFinger, rows: NDArray[np.int_]
) -> tuple[ContactShape, tuple[Any, ...]] | None:
    """Estimator `contact` of a finger, and its arguments at samples (M) of a recording; None without readings."""
    recorded = read_recorded(station, recording, finger)
    if recorded is None:
        return None
    function = recorded.function(ESTIMATOR)
    assert isinstance(function, ContactShape)
    return function, recorded.arguments(function, rows)


def band_widths(station: Station, recording: Recording, row: FingerForce) -> dict[str, float]:
    """Widths of a band over the force, now and after each improvement, see `narrower_bands`.

    Empty where no contact is detected, or another estimator than `contact` or sensors of the user's own are in use.
    """
    scenario = station.scenario
    finger = next(candidate for candidate in station.fingers if candidate.name == row.finger)
    sample = np.array([np.abs(recording["time"].values - row.time_s).argmin()])
    inputs = None
    if estimator_of_forces(station, recording) == ESTIMATOR and row.least_n > 0:
        inputs = _contact_inputs(station, recording, finger, sample)
    if inputs is None:
        return {}
    sensor, nominal = scenario.sensor, read_nominal_model(scenario.nominal)
    changes: dict[str, dict[str, Any]] = {}
    if scenario.nominal.calibration is None and not sensor.paths:
        if sensor.sections < finger.finger.segments:
            changes[f"{sensor.sections + 1} sections"] = {"sections": sensor.sections + 1, "borders": None}
        if sensor.sections == 2 and sensor.borders is None:
            changes["its border at a third"] = {"borders": [1 / 3]}
    other_layouts = {name: nominal.layout(finger.finger, replace(sensor, **change)) for name, change in changes.items()}
    function, (_, driving, gravity, *_) = inputs
    q = function(*inputs[1]).q[0]
    declared = uncertainty(scenario.estimator, sensor, function.layout.calibrated)
    return narrower_bands(function.layout, declared, sensor.period, q, driving[0], gravity[0], other_layouts)
