"""Simulates single contacts of a finger for the benchmark; their files are in the repository.

The contacts are simulated in Drake: a peg on the inner or the outer side, with friction, anywhere from a tenth of the
length on, at random pressures and orientations. Sensors have realistic errors, drawn anew for every contact.

`python -m studies benchmark-data` writes the files again. Versions of the simulation differ in forces by about 0.1 %,
and in contacts that are left out; the files of transverse forces are of a later one.
"""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from tqdm import tqdm

from soft_gripper.arrays import Array
from soft_gripper.extras.sweeps.executor import open_executor
from soft_gripper.files.row_table import write_csv
from soft_gripper.fingers.kinematics import as_points, forward_kinematics
from soft_gripper.sensors.sensor_layout import SensorLayout
from studies.contacts.contacts import Contacts, read_finger
from studies.contacts.estimates import HELD, contact_readings
from studies.contacts.peg import contact_arrays, run_contacts
from studies.estimator_setup import EstimatorSetup

FILES = {"contacts_train.csv": 11, "contacts_test.csv": 12}  # seeds of the contacts by file
TRANSVERSE = {file: file.replace("contacts", "transverse") for file in FILES}  # files of the same draws
FOLDER = Path(__file__).parent / "data"
CONTACTS = 300  # of each
PLACE_RANGE = 0.1, 1.0  # shares of the length
BORDERS = (1 / 3,)  # of the two sections of the sensors


def layout() -> SensorLayout:
    """Sensors: two sections on both sides."""
    return SensorLayout(read_finger(), 2, borders=BORDERS)


@dataclass(frozen=True)
class ContactMeasurements:
    """Measurements of a contact, the first columns of every file."""

    reading_0: float
    reading_1: float
    reading_2: float
    reading_3: float
    pressure: float  # Pa
    gravity_x: float  # m/s^2, in B
    gravity_z: float


@dataclass(frozen=True)
class ContactSample(ContactMeasurements):
    """A row of `FILES`, and the truth."""

    tip_x: float  # m, in B
    tip_z: float
    force: float  # N, across the finger, positive on the inner side
    place: float  # m, arc length from the base


@dataclass(frozen=True)
class TransverseSample(ContactMeasurements):
    """A row of `TRANSVERSE`, and the truth."""

    transverse_force: float  # N, size of the part at right angles to the line from the base to the contact


def measured_columns(contacts: Contacts, readings: Array) -> Array:
    """Measurements of contacts, (M, 7); `readings` (M, 4)."""
    return np.column_stack([readings, contacts.pressure, contacts.gravity[:, ::2]])


def samples(contacts: Contacts, readings: Array) -> list[ContactSample]:
    """Rows of contacts, sorted by location; `readings` (M, 4)."""
    tips = as_points(forward_kinematics(contacts.q, contacts.finger.segment_length).points[:, -1])
    transverse_force = np.where(contacts.is_inside, contacts.normal_force, -contacts.normal_force)
    table = np.column_stack([measured_columns(contacts, readings), tips, transverse_force, contacts.arc_length])
    return [ContactSample(*row) for row in _rows(table, contacts)]


def transverse_samples(contacts: Contacts, readings: Array) -> list[TransverseSample]:
    """Rows of contacts with their transverse force, sorted by location; `readings` (M, 4)."""
    table = np.column_stack([measured_columns(contacts, readings), contacts.transverse_force])
    return [TransverseSample(*row) for row in _rows(table, contacts)]


def _rows(table: Array, contacts: Contacts) -> list[list[float]]:
    return [[float(f"{value:.7g}") for value in row] for row in table[contacts.arc_length.argsort()]]


def write_samples() -> None:
    """Simulates the contacts and writes the files."""
    for number, (file, seed) in enumerate(FILES.items()):
        with tqdm(total=CONTACTS, desc=f"contacts of seed {seed}", unit="contact") as bar, open_executor() as executor:
            contacts = contact_arrays(run_contacts(CONTACTS, seed, executor, bar.update, places=PLACE_RANGE))
        readings = contact_readings(layout(), contacts, EstimatorSetup(2, noise=1.0).errors, len(FILES), HELD).pressed[
            number
        ]
        write_csv(FOLDER / file, samples(contacts, readings))
        write_csv(FOLDER / TRANSVERSE[file], transverse_samples(contacts, readings))
