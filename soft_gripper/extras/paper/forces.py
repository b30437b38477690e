"""Tables contact forces of a run, estimated and true, for several numbers of sensor sections."""

from collections.abc import Iterator, Sequence
from dataclasses import astuple, dataclass

import numpy as np

from soft_gripper.arrays import Array
from soft_gripper.diagrams.recording import Recording
from soft_gripper.diagrams.station_parts import Station
from soft_gripper.fingers.plant_finger import PlantFinger
from soft_gripper.runs.scores.poses import HeldStep, held_rows, held_samples, held_steps
from soft_gripper.runs.scores.readings import ReadAgain, read_again
from soft_gripper.sensors.measurement import MeasurementModel

# Sections and where they meet, as shares of the length. A force near the base bends only the first of two sections,
# and one reading cannot separate force from location; so there is a layout whose first section is shorter.
LAYOUTS: tuple[tuple[int, tuple[float, ...] | None], ...] = ((2, None), (2, (1 / 3,)), (4, None))


def describe_borders(layout: MeasurementModel) -> str:
    """Borders of the sections, in mm from the base, for tables."""
    return " ".join(f"{1e3 * end:g}" for end in layout.rest_lengths.cumsum()[:-1])


ESTIMATOR = "contact"
_TRUE_SIGNALS = ("true_contact_force", "true_contact_total", "normal_force")


@dataclass(frozen=True)
class ContactForceRow(HeldStep):
    """Contact forces and locations of a finger, averaged over a held step; locations are NaN without contact."""

    borders: str  # mm from the base, where the sections meet
    estimated_n: float  # across the finger, positive on the inner side
    true_n: float
    total_n: float  # true, friction included
    normal_n: float  # true, along the normals of what is touched
    estimated_mm: float  # from the base
    true_mm: float


def contact_force_table(
    name: str, station: Station, recording: Recording, layouts: Sequence[tuple[int, tuple[float, ...] | None]]
) -> list[ContactForceRow]:
    """A row for every finger, layout (sections and borders) and held step, in this order."""
    rows: list[ContactForceRow] = []
    for finger in station.fingers:
        for sections, borders in layouts:
            readings = read_again(station, recording, finger, sections, borders)
            rows += _contact_rows(name, station, recording, finger, readings)
    return rows


def _contact_rows(
    name: str, station: Station, recording: Recording, finger: PlantFinger, readings: ReadAgain
) -> Iterator[ContactForceRow]:
    scenario = station.scenario
    layout = readings.layout
    rows = held_rows(scenario, recording)
    contact = readings.shape(ESTIMATOR, rows.ravel()).contact
    assert contact is not None
    force, arc_length = (component.reshape(rows.shape) for component in (contact.force, contact.arc_length))
    forces = (held_samples(scenario, recording, f"{finger.name}.{signal}") for signal in _TRUE_SIGNALS)
    place = held_samples(scenario, recording, f"{finger.name}.true_contact_arc_length")
    columns = [samples.mean(axis=-1) for samples in (force, *forces)]
    columns += [1e3 * _mean_location(samples) for samples in (arc_length, place)]
    for step, *values in zip(held_steps(name, station, finger, ESTIMATOR, layout.sections), *columns, strict=True):
        yield ContactForceRow(*astuple(step), *[describe_borders(layout), *map(float, values)])


def _mean_location(place: Array) -> Array:
    """Mean location over the samples of a step with contact, (steps, samples) m -> (steps) m; NaN without contact."""
    presses = np.isfinite(place)
    return np.where(presses, place, 0).sum(axis=-1) / np.where(presses.any(axis=-1), presses.sum(axis=-1), np.nan)
