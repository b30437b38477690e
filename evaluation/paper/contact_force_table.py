"""Contact forces of a run and where they press, estimated and true, for several layouts of sensors."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from soft_gripper.arrays import Array
from soft_gripper.diagrams.recording.recording import Recording
from soft_gripper.diagrams.station_parts import Station
from soft_gripper.diagrams.wiring.belief import describe_belief
from soft_gripper.diagrams.wiring.pressure_steps import pressure_steps
from soft_gripper.evaluation.contact_sensors import describe_borders
from soft_gripper.evaluation.paper.held_steps import HeldStep, held_samples
from soft_gripper.evaluation.paper.readings_again import ReadAgain, read_again
from soft_gripper.fingers.plant_finger import PlantFinger

ESTIMATOR = "contact"
_TRUTH = ("true_contact_force", "true_contact_total", "normal_force")


@dataclass(frozen=True)
class ContactForceRow(HeldStep):
    """Averages over one held step; see `ContactForce` and `TrueContact`. Places are NaN where nothing presses."""

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
            again = read_again(station, recording, finger, sections, borders)
            rows += _rows(name, station, recording, finger, again)
    return rows


def _rows(
    name: str, station: Station, recording: Recording, finger: PlantFinger, again: ReadAgain
) -> Iterator[ContactForceRow]:
    scenario, layout = station.scenario, again.layout
    contact = again.shape(ESTIMATOR).contact
    assert contact is not None
    force, s = (held_samples(scenario, recording, part) for part in (contact.force, contact.arc_length))
    forces = (held_samples(scenario, recording, f"{finger.name}.{signal}") for signal in _TRUTH)
    place = held_samples(scenario, recording, f"{finger.name}.true_contact_arc_length")
    columns = [each.mean(axis=-1) for each in (force, *forces)]
    columns += [1e3 * _mean_place(each) for each in (s, place)]
    steps, belief = pressure_steps(scenario.pressure, finger.name) / 1e3, describe_belief(scenario.believed)
    for pressure, *values in zip(steps, *columns, strict=True):
        which = name, finger.name, ESTIMATOR, belief, layout.sections, float(pressure), describe_borders(layout)
        yield ContactForceRow(*which, *map(float, values))


def _mean_place(place: Array) -> Array:
    """The mean over the samples of a step, (steps, samples) -> (steps), in which something presses; else NaN."""
    presses = np.isfinite(place)
    return np.where(presses, place, 0).sum(axis=-1) / np.where(presses.any(axis=-1), presses.sum(axis=-1), np.nan)
