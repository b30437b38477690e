"""True contacts of the fingers in each steady state: number of links, contact length, and bending."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Protocol, TypeVar

import numpy as np
from numpy.typing import NDArray

from soft_gripper.arrays import Array
from soft_gripper.diagrams.recording import Recording
from soft_gripper.diagrams.station_parts import Station
from soft_gripper.diagrams.wiring.drive import pressure_steps
from soft_gripper.fingers.finger import Finger
from soft_gripper.fingers.plant_finger import PlantFinger
from soft_gripper.runs.scores.poses import held_samples
from soft_gripper.truth.contact import touches

STRAIGHT = 0.1  # 1/m; a joint with less curvature (radius above 10 m) counts as straight


@dataclass(frozen=True)
class ContactRow:
    """One finger at one held step, from the means over its samples; see `contact_length` and `changes_sign`."""

    scenario: str
    finger: str
    pressure_kpa: float
    touching_links: int
    contact_length_mm: float
    sign_changes: int  # 1 if the curvature changes its sign along the finger, else 0


@dataclass(frozen=True)
class ContactSummary:
    """Maxima over all fingers and steps of a scenario."""

    scenario: str
    touching_links: int
    contact_length_mm: float
    sign_changes: int


class FingerRow(Protocol):
    """A row of any table that names its finger."""

    @property
    def scenario(self) -> str: ...
    @property
    def finger(self) -> str: ...


Row = TypeVar("Row", bound=FingerRow)


def contact_table(name: str, station: Station, recording: Recording) -> list[ContactRow]:
    """A row for every finger and held step, in this order."""
    return [row for finger in station.fingers for row in _rows(name, station, recording, finger)]


def _rows(name: str, station: Station, recording: Recording, finger: PlantFinger) -> Iterator[ContactRow]:
    scenario = station.scenario
    force, q = (
        held_samples(scenario, recording, f"{finger.name}.{signal}").mean(axis=1)
        for signal in ("link_contact_force", "sampled_joint_angles")
    )
    is_touching = touches(force)
    changes = changes_sign(finger.finger, q)
    lengths = 1e3 * contact_length(finger.finger, is_touching)
    pressures = pressure_steps(scenario.pressure, finger.name)
    for step, pressure in enumerate(pressures / 1e3):
        count = int(is_touching[step].sum())
        yield ContactRow(name, finger.name, float(pressure), count, float(lengths[step]), int(changes[step]))


def contact_summary(rows: Sequence[ContactRow]) -> list[ContactSummary]:
    """A row for every scenario, in the order of `rows`."""
    summary = []
    for name in dict.fromkeys(row.scenario for row in rows):
        steps = [row for row in rows if row.scenario == name]
        links = max(row.touching_links for row in steps)
        length = max(row.contact_length_mm for row in steps)
        summary.append(ContactSummary(name, links, length, max(row.sign_changes for row in steps)))
    return summary


def touched_finger_rows(rows: Sequence[Row], contacts: Sequence[ContactRow]) -> list[Row]:
    """Rows of fingers that touch something at any step; in scenarios without contact, all rows.

    A finger that stays free beside an obstructed one bends freely, and would halve the errors of contact.
    """
    touched_fingers = {(row.scenario, row.finger) for row in contacts if row.touching_links}
    with_contact = {scenario for scenario, _ in touched_fingers}
    return [row for row in rows if row.scenario not in with_contact or (row.scenario, row.finger) in touched_fingers]


def contact_length(finger: Finger, is_touching: NDArray[np.bool_]) -> Array:
    """Contact length of a finger, (..., N + 1) -> (...) m: the sum of the lengths of touching links."""
    return is_touching @ np.diff(finger.link_ends)


def changes_sign(finger: Finger, q: Array) -> NDArray[np.bool_]:
    """Whether the curvature of a finger changes its sign along it, joint angles (..., N) rad -> (...)."""
    curvature = q / finger.segment_length
    return (curvature.min(axis=-1) < -STRAIGHT) & (curvature.max(axis=-1) > STRAIGHT)
