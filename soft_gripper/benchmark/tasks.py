"""Tasks of the benchmark: recorded files, what is measured and estimated, and what is trained and tested on."""

import hashlib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import astuple, dataclass, fields
from pathlib import Path

import numpy as np

from soft_gripper.arrays import Array
from soft_gripper.benchmark.contacts import FOLDER, ContactSample
from soft_gripper.errors import InputError
from soft_gripper.files.csv_table import read_csv


@dataclass(frozen=True)
class Channel:
    """A quantity that is measured or estimated."""

    name: str
    unit: str


@dataclass(frozen=True)
class Recorded:
    """Samples in the order in which they were recorded."""

    inputs: Array  # (T, n)
    outputs: Array  # (T, m)


@dataclass(frozen=True)
class Part:
    """A contiguous share of a recorded file."""

    file: str
    begin: float = 0.0  # share of its samples
    end: float = 1.0


@dataclass(frozen=True)
class Task:
    """What an estimator is told. The test set is divided into regions, scored one by one."""

    name: str
    source: str  # public repository and folder of the files
    sha256: dict[str, str]  # of every file
    inputs: tuple[Channel, ...]
    outputs: tuple[Channel, ...]
    trained: tuple[Part, ...]
    tested: Mapping[str, tuple[Part, ...]]
    read: Callable[[Path], Recorded]
    folder: Path | None = None  # of files that ship with the package


def missing_files(task: Task, folder: Path) -> list[str]:
    """Files of a task that a data folder does not have."""
    return [file for file in task.sha256 if not (folder / file).is_file()]


def read_task(task: Task, folder: Path) -> tuple[list[Recorded], dict[str, list[Recorded]]]:
    """The training recordings, and the test recordings of every region.

    Raises an `InputError` if a file is not the one that the task was defined with.
    """
    files = {file: _read(task, folder, file) for file in task.sha256}
    tested = {region: [_part(files, part) for part in parts] for region, parts in task.tested.items()}
    return [_part(files, part) for part in task.trained], tested


def _read(task: Task, folder: Path, file: str) -> Recorded:
    found = hashlib.sha256((folder / file).read_bytes()).hexdigest()
    if found != task.sha256[file]:
        expected = f"must be {task.sha256[file]}, as in {task.source}"
        raise InputError(folder / file, "SHA-256", found, expected)
    return task.read(folder / file)


def _part(files: dict[str, Recorded], part: Part) -> Recorded:
    recorded = files[part.file]
    begin, end = (round(share * len(recorded.inputs)) for share in (part.begin, part.end))
    return Recorded(recorded.inputs[begin:end], recorded.outputs[begin:end])


def _channels(unit: str, names: str) -> tuple[Channel, ...]:
    return tuple(Channel(name, unit) for name in names.split())


_ENCODERS, _BASE, _TIP = slice(13, 17), [17, 19], [31, 33]  # columns; x and z of the positions


def _read_arm(path: Path) -> Recorded:
    """Wire encoders (V), and the tip relative to the base (m); incomplete rows are dropped."""
    lines = path.read_text().replace("[", "").replace("]", "").splitlines()
    table = np.array([row for row in map(_numbers, lines) if len(row) == 38 and np.isfinite(row).all()])
    return Recorded(table[:, _ENCODERS], table[:, _TIP] - table[:, _BASE])


def _numbers(line: str) -> list[float]:
    try:
        return [float(cell) for cell in line.split(",")]
    except ValueError:
        return []


_MOTORS, _DISKS = slice(10, 16), slice(1, 10)  # columns
_TRUNK_LOADS = {
    "soft_trunk/random_0g.csv": 0.0,
    "soft_trunk/random_100g.csv": 100.0,
    "soft_trunk/random_300g.csv": 300.0,
}


def _read_trunk_shape(path: Path) -> Recorded:
    table = np.loadtxt(path, delimiter=",", skiprows=1)
    return Recorded(table[:, _MOTORS], table[:, _DISKS])


def _read_trunk_load(path: Path) -> Recorded:
    table = np.loadtxt(path, delimiter=",", skiprows=1)
    mass = _TRUNK_LOADS[f"soft_trunk/{path.name}"]
    return Recorded(table[:, 1:16], np.full((len(table), 1), mass))


_ARM_FILES = {
    "two_segment_arm/trial_1.txt": "8cb4b2867ba8b06d193cd79c9e1c26703951f58d29ec8fc0410d8f66c57d7b86",
    "two_segment_arm/trial_2.txt": "2c5ff15c0f47ddc54602e7dc162c460a3fcc64c22d717caab7da8b6da71724be",
    "two_segment_arm/trial_3.txt": "664900e1497d4e9033e52ddbae39fe2a654556326b6a5b04fcdec47f6fafafec",
    "two_segment_arm/trial_4.txt": "cfd934284aa35fb84933e1f99f55cd7b9aecdeb2adabab5b7a8d236219156b9a",
    "two_segment_arm/trial_5.txt": "16da74aaae38c774eb0ece7033ebdaf4b5db6808047063a1bf5e6202bfd2e0bd",
    "two_segment_arm/trial_6.txt": "50cd39dcf61bdc3fbda9119e8fbcdaae71b2aa05f1bc182740780147596448d1",
}
_TRUNK_FILES = {
    "soft_trunk/random_0g.csv": "bc4c951556c971d8849e556f067bf041c6de359b630a88d70760738abb836541",
    "soft_trunk/random_100g.csv": "790953bd1c715a8d6ddafa3e8dbe5e7781727a164119311a0fec99c6e6e2ffc0",
    "soft_trunk/random_300g.csv": "7153b29b798170b9a4083dd1f7fa9de7ee709df883f272b4af5777f91b7fd9ce",
}
_TRUNK = "https://github.com/StanfordASL/trunk-stack, stack/main/data/trajectories/dynamic/servo_motor_archive"
_DISK_NAMES = " ".join(f"{axis}{disk}" for disk in (1, 2, 3) for axis in "xyz")
_MOTOR_NAMES = " ".join(f"phi{motor}" for motor in range(1, 7))
_SEEN = 0.8  # share trained on: the same commands were run with every load, so later ones are tested with all
_LIGHT, _MIDDLE, _HEAVY = _TRUNK_LOADS
_LATER = {f"{mass:.0f} g": (Part(file, _SEEN),) for file, mass in _TRUNK_LOADS.items()}


def _read_contacts(outputs: Sequence[str]) -> Callable[[Path], Recorded]:
    def read(path: Path) -> Recorded:
        table = read_csv(path, ContactSample)
        names = [each.name for each in fields(ContactSample)]
        values = np.array([astuple(row) for row in table])
        return Recorded(values[:, :_MEASURED], values[:, [names.index(name) for name in outputs]])

    return read


_MEASURED = 7  # columns of a contact: readings, pressure and gravity
_CONTACT_FILES = {
    "contacts_train.csv": "b173dc9c27a2f654d2851e987796a9438f8c5a7a8030e22bd2a3511717649246",
    "contacts_test.csv": "9cd9e4f2099c1491451a55d2f4ef1e35eab3d8a2ba7fe330b0dde706dc4c04cf",
}
_CONTACT_INPUTS = _channels("1", "reading_0 reading_1 reading_2 reading_3")
_CONTACT_INPUTS += _channels("Pa", "pressure") + _channels("m/s^2", "gravity_x gravity_z")
_SHARES = {"near base": (0, 1 / 3), "middle": (1 / 3, 2 / 3), "near tip": (2 / 3, 1)}  # of the contacts, by place


def _contacts(name: str, unit: str, outputs: Sequence[str]) -> Task:
    return Task(
        name,
        "simulated by python -m soft_gripper.benchmark.contacts",
        _CONTACT_FILES,
        _CONTACT_INPUTS,
        _channels(unit, " ".join(outputs)),
        (Part("contacts_train.csv"),),
        {region: (Part("contacts_test.csv", *share),) for region, share in _SHARES.items()},
        _read_contacts(outputs),
        FOLDER,
    )


TASKS = (
    _contacts("contact_tip", "m", ["tip_x", "tip_z"]),
    _contacts("contact_force", "N", ["force"]),
    _contacts("contact_place", "m", ["place"]),
    Task(
        "arm_tip",
        "https://github.com/ASU-RISE-Lab/4-chamber-softarm-control, data-collection/2023/apr 4",
        _ARM_FILES,
        _channels("V", "L1 R1 R_total L_total"),
        _channels("m", "tip_x tip_z"),
        tuple(Part(f"two_segment_arm/trial_{trial}.txt") for trial in (1, 3, 5)),
        {
            "S-shapes": tuple(Part(f"two_segment_arm/trial_{trial}.txt") for trial in (2, 4)),
            "stretched": (Part("two_segment_arm/trial_6.txt"),),
        },
        _read_arm,
    ),
    Task(
        "trunk_shape",
        _TRUNK,
        _TRUNK_FILES,
        _channels("deg", _MOTOR_NAMES),
        _channels("m", _DISK_NAMES),
        (Part(_LIGHT, end=_SEEN),),
        _LATER,
        _read_trunk_shape,
    ),
    Task(
        "trunk_load",
        _TRUNK,
        _TRUNK_FILES,
        _channels("m", _DISK_NAMES) + _channels("deg", _MOTOR_NAMES),
        _channels("g", "mass"),
        (Part(_LIGHT, end=_SEEN), Part(_HEAVY, end=_SEEN)),
        _LATER,
        _read_trunk_load,
    ),
)
