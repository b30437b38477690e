"""Defines the tasks of the benchmark: simulated contacts and grasps, whose files are here, and recordings."""

import csv
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import astuple, fields
from io import StringIO
from pathlib import Path

import numpy as np

from soft_gripper.errors import InputError
from soft_gripper.extras.hardware.identification.simulated_motion import (
    MeasuredMotion,
    marker_rotation,
    measured_motion,
)
from soft_gripper.extras.hardware.recording_schema import load_description
from soft_gripper.extras.hardware.recordings import read_recording
from soft_gripper.files.row_table import read_csv
from soft_gripper.files.text import MAX_BYTES, read_text
from soft_gripper.fingers.kinematics import as_points
from studies.benchmark import grasps
from studies.benchmark.benchmark_task import BenchmarkTask, Channel, Part, Recorded
from studies.benchmark.contacts import FOLDER, ContactMeasurements, ContactSample, TransverseSample
from studies.benchmark.random_objects import SHAPES
from studies.hardware.published import BEAM, SEGMENT, recording_file

_SHA256_FILE = Path(__file__).with_name("sha256.txt")  # as written by sha256sum


def _files(prefix: str) -> dict[str, str]:
    """Files of tasks whose names begin with a text, and their checksums."""
    lines = (line.split() for line in _SHA256_FILE.read_text(encoding="ascii").splitlines())
    return {file: checksum for checksum, file in lines if file.startswith(prefix)}


def _channels(unit: str, names: str) -> tuple[Channel, ...]:
    return tuple(Channel(name, unit) for name in names.split())


def _read_contacts(kind: type[ContactMeasurements], outputs: Sequence[str]) -> Callable[[Path], Recorded]:
    def read(path: Path) -> Recorded:
        names = [field_.name for field_ in fields(kind)]
        values = np.array([astuple(row) for row in read_csv(path, kind)])
        return Recorded(
            values[:, : len(fields(ContactMeasurements))], values[:, [names.index(name) for name in outputs]]
        )

    return read


_CONTACT_FILES = _files("contacts")
_CONTACT_INPUTS = _channels("1", "reading_0 reading_1 reading_2 reading_3")
_CONTACT_INPUTS += _channels("Pa", "pressure") + _channels("m/s^2", "gravity_x gravity_z")
_REGION_FRACTIONS = {
    "near base": (0, 1 / 3),
    "middle": (1 / 3, 2 / 3),
    "near tip": (2 / 3, 1),
}  # of the contacts, by place


_TRANSVERSE_FILES = _files("transverse")


def _contacts(
    name: str,
    unit: str,
    outputs: Sequence[str],
    kind: type[ContactMeasurements] = ContactSample,
    sha256: Mapping[str, str] = _CONTACT_FILES,
) -> BenchmarkTask:
    train, test = sha256
    return BenchmarkTask(
        name,
        "simulated by python -m studies.benchmark.contacts",
        sha256,
        _CONTACT_INPUTS,
        _channels(unit, " ".join(outputs)),
        (Part(train),),
        {region: (Part(test, *share),) for region, share in _REGION_FRACTIONS.items()},
        _read_contacts(kind, outputs),
        FOLDER,
    )


def _read_grasps(known_shapes: Sequence[str]) -> Callable[[Path], Recorded]:
    """Makes a reader of readings and of a 1 for the grasped shape, or zeros if the shape is not known."""

    def read(path: Path) -> Recorded:
        _, *rows = csv.reader(StringIO(read_text(path, MAX_BYTES)))
        is_held = [[float(row[0] == shape) for shape in known_shapes] for row in rows]
        return Recorded(np.array([row[1:] for row in rows], dtype=float), np.array(is_held))

    return read


_GRASP_FILES = _files("grasps")


def _grasps(name: str, known_shapes: Sequence[str]) -> BenchmarkTask:
    quarters = {shape: (i / len(SHAPES), (i + 1) / len(SHAPES)) for i, shape in enumerate(SHAPES)}  # of each file
    regions = {shape if shape in known_shapes else f"{shape} (new)": quarters[shape] for shape in SHAPES}
    return BenchmarkTask(
        name,
        "simulated by python -m studies.benchmark.grasps",
        _GRASP_FILES,
        _channels("1", " ".join(grasps.columns())),
        _channels("1", " ".join(known_shapes)),
        tuple(Part("grasps_train.csv", *quarters[shape]) for shape in known_shapes),
        {region: (Part("grasps_test.csv", *share),) for region, share in regions.items()},
        _read_grasps(known_shapes),
        FOLDER,
        recognition=True,
    )


_ENCODERS = slice(13, 17)  # columns
_PRESSURES = [10, 11, 12, 4, 5, 6]  # columns, with the chambers of the upper segment first
_BASE, _TIP = [17, 19], [31, 33]  # x and z of the positions


def _read_arm(path: Path) -> Recorded:
    """Wire encoders (V), pressures (psi), and the tip relative to the base (m); incomplete rows are dropped."""
    lines = read_text(path, MAX_BYTES).replace("[", "").replace("]", "").splitlines()
    table = np.array([row for row in map(_numbers, lines) if len(row) == 38 and np.isfinite(row).all()])
    inputs = np.hstack([table[:, _ENCODERS], table[:, _PRESSURES]])
    return Recorded(inputs, table[:, _TIP] - table[:, _BASE])


def _numbers(line: str) -> list[float]:
    try:
        return [float(cell) for cell in line.split(",")]
    except ValueError:
        return []


_ARM_FILES = _files("two_segment_arm")
_TRIALS = tuple(_ARM_FILES)[:6]
_CAPTURE_PERIOD = 0.01  # s, between two samples of the motion capture of beam, segment and trunk
_SRL = "https://github.com/srl-ethz/diffPD_sim2real, python/"


def tip_motion(description: str, path: Path) -> tuple[MeasuredMotion, np.ndarray]:
    """The markers at the tip of a recording; displacement of their middle from its place before the event, (T, 2) m."""
    motion = measured_motion(read_recording(path, load_description(description)))
    return motion, as_points((motion.markers - motion.reference).mean(axis=1))


def _beam_turn(path: Path) -> tuple[MeasuredMotion, np.ndarray, np.ndarray]:
    motion, displacement = tip_motion("clamped_beam", path)
    return motion, marker_rotation(motion.markers, motion.reference)[:, None], displacement


def _read_beam_tip(path: Path) -> Recorded:
    _, turn, displacement = _beam_turn(path)
    return Recorded(turn, displacement)


def _read_beam_load(path: Path) -> Recorded:
    motion, turn, displacement = _beam_turn(path)
    mass = 0.0 if motion.load is None else 1e3 * motion.load.mass
    return Recorded(np.hstack([turn, displacement]), np.full((len(displacement), 1), mass))


_BEAM_FILES = _files("clamped_beam")
_BEAM = _SRL + "realbeam_experiments/Measurement_data (markers as CSV, see docs/studies/benchmark.md)"
_LIGHTER = tuple(recording_file("clamped_beam", name) for name in BEAM.fitted)
(_HEAVIEST,) = (recording_file("clamped_beam", name) for name in BEAM.tested)
_FITTED_PRESSURES = tuple(recording_file("pneumatic_segment", name) for name in SEGMENT.fitted)
_SWINGING_SHARE = 0.4  # share of a recording after which the beam hardly swings


def _read_segment(path: Path) -> Recorded:
    """Pressure (kPa) from the valve's opening to its closing, which are detected in the motion, and the tip."""
    motion, displacement = tip_motion("pneumatic_segment", path)
    assert motion.pressure is not None
    is_open = (motion.time >= motion.events[0]) & (motion.time < motion.events[1])
    return Recorded(1e-3 * motion.pressure * is_open[:, None], displacement)


_SEGMENT_FILES = _files("pneumatic_segment")


def _read_tendons(path: Path) -> Recorded:
    """Lengths of nine tendons that are pulled in (mm), and the tip (m)."""
    _, *rows = csv.reader(StringIO(read_text(path, MAX_BYTES)))
    table = np.array([row[2:] for row in rows], dtype=float)
    return Recorded(table[:, :9], 1e-3 * table[:, 9:])


_GAP_ROWS = 10  # between training and tests: 6 s
# The first row of every family of patterns in which two segments move together: 1 and 2, 1 and 3, 2 and 3.
_FAMILY_ROWS = {"v4": (1620, 717, 866, 989, 1141, 1300, 1481), "v6": (1019, 529, 556, 648, 729, 827, 920)}


def _tendons(robot: str) -> BenchmarkTask:
    """Trained on one tendon or one segment at a time; tested on two segments together, bent alike or oppositely."""
    file, (rows, *begins) = f"tendon_robots/{robot}_train.csv", _FAMILY_ROWS[robot]
    pairs = [Part(file, begin / rows, end / rows) for begin, end in zip(begins, [*begins[1:], rows], strict=True)]
    return BenchmarkTask(
        f"tendons_{robot}_tip",
        "https://github.com/ContinuumRoboticsLab/opencr-mujoco, data/sysid",
        _files(file),
        _channels("mm", " ".join(f"tendon_{i + 1}" for i in range(9))),
        _channels("m", "tip_x tip_y tip_z"),
        (Part(file, end=(begins[0] - _GAP_ROWS) / rows),),
        {"two alike": tuple(pairs[::2]), "two opposite": tuple(pairs[1::2])},
        _read_tendons,
        period=0.6,
        kept_back=Part(f"tendon_robots/{robot}_val*.csv"),
    )


_MOTORS, _DISKS = slice(10, 16), slice(1, 10)  # columns
_TRUNK_LOAD_PATTERN = re.compile(r"_(\d+)g")  # in the name of a file, g


def _read_trunk_shape(path: Path) -> Recorded:
    table = np.loadtxt(path, delimiter=",", skiprows=1)
    return Recorded(table[:, _MOTORS], table[:, _DISKS])


def _read_trunk_load(path: Path) -> Recorded:
    table, match = np.loadtxt(path, delimiter=",", skiprows=1), _TRUNK_LOAD_PATTERN.search(path.name)
    if match is None:
        raise InputError(path, "name", path.name, "must have the load in g, such as random_200g.csv")
    return Recorded(table[:, 1:16], np.full((len(table), 1), float(match[1])))


def _read_trunk_dc(path: Path) -> Recorded:
    """Commands of the motors (deg) come first here."""
    table = np.loadtxt(path, delimiter=",", skiprows=1)
    return Recorded(table[:, 1:7], table[:, 7:16])


_TRUNK_FILES = _files("soft_trunk")
_TRUNK_DC_FILES = _files("trunk_dc")
_TRUNK = "https://github.com/StanfordASL/trunk-stack, stack/main/data/trajectories/dynamic/"
_DISK_NAMES = " ".join(f"{axis}{disk}" for disk in (1, 2, 3) for axis in "xyz")
# The same commands were run with every load. Training and tests use different fractions of the files,
# with some seconds between them.
_TRAINED_SHARE, _TESTED_SHARE = 0.8, 0.85
_LIGHT, _MIDDLE, _HEAVY = _TRUNK_FILES
_DC_LIGHT, _DC_HEAVY = _TRUNK_DC_FILES


TASKS = (
    _contacts("contact_tip", "m", ["tip_x", "tip_z"]),
    _contacts("contact_force", "N", ["force"]),
    _contacts("contact_place", "m", ["place"]),
    _contacts("contact_transverse", "N", ["transverse_force"], TransverseSample, _TRANSVERSE_FILES),
    _grasps("grasp_shape", list(SHAPES)),
    _grasps("grasp_new", [shape for shape in SHAPES if shape != "sphere"]),
    BenchmarkTask(
        "arm_tip",
        "https://github.com/ASU-RISE-Lab/4-chamber-softarm-control, data-collection/2023/apr 4 and apr 5",
        _ARM_FILES,
        _channels("V", "L1 R1 R_total L_total") + _channels("psi", "upper_0 upper_1 upper_2 lower_0 lower_1 lower_2"),
        _channels("m", "tip_x tip_z"),
        tuple(map(Part, _TRIALS)),
        {
            "same day": (Part("two_segment_arm/trial_7.txt"),),
            "next day": (Part("two_segment_arm/trial_8.txt"),),
        },
        _read_arm,
        period=0.017,
        kept_back=Part("two_segment_arm/trial_*.txt"),
        given=_TRIALS,
    ),
    BenchmarkTask(
        "beam_tip",
        _BEAM,
        _BEAM_FILES,
        _channels("rad", "turn"),
        _channels("m", "tip_x tip_z"),
        tuple(Part(file) for file in _LIGHTER),
        {"swinging": (Part(_HEAVIEST, end=_SWINGING_SHARE),), "at rest": (Part(_HEAVIEST, _SWINGING_SHARE),)},
        _read_beam_tip,
        period=_CAPTURE_PERIOD,
        kept_back=Part("clamped_beam/*.csv"),
        given=_LIGHTER,
    ),
    BenchmarkTask(
        "beam_load",
        _BEAM,
        _BEAM_FILES,
        _channels("rad", "turn") + _channels("m", "tip_x tip_z"),
        _channels("g", "mass"),
        tuple(Part(file, _SWINGING_SHARE) for file in _LIGHTER),
        {"102 g": (Part(_HEAVIEST, _SWINGING_SHARE),)},
        _read_beam_load,
        period=_CAPTURE_PERIOD,
        kept_back=Part("clamped_beam/*.csv", _SWINGING_SHARE),
        given=_LIGHTER,
    ),
    BenchmarkTask(
        "segment_tip",
        _SRL + "1segment_arm/Measurement_data (markers as CSV, see docs/studies/benchmark.md)",
        _SEGMENT_FILES,
        _channels("kPa", "pressure"),
        _channels("m", "tip_x tip_z"),
        tuple(map(Part, _FITTED_PRESSURES)),
        {f"{pressure} kPa": (Part(f"pneumatic_segment/{pressure}kPa.csv"),) for pressure in (15, 20, 35, 40)},
        _read_segment,
        period=_CAPTURE_PERIOD,
        kept_back=Part("pneumatic_segment/*.csv"),
        given=_FITTED_PRESSURES,
    ),
    _tendons("v4"),
    _tendons("v6"),
    BenchmarkTask(
        "trunk_shape",
        _TRUNK + "servo_motor_archive",
        _TRUNK_FILES,
        _channels("deg", " ".join(f"phi{motor}" for motor in range(1, 7))),
        _channels("m", _DISK_NAMES),
        (Part(_LIGHT, end=_TRAINED_SHARE),),
        {"100 g": (Part(_MIDDLE, _TESTED_SHARE),), "300 g": (Part(_HEAVY, _TESTED_SHARE),)},
        _read_trunk_shape,
        period=_CAPTURE_PERIOD,
        kept_back=Part("soft_trunk/random_*.csv", _TESTED_SHARE),
    ),
    BenchmarkTask(
        "trunk_load",
        _TRUNK + "servo_motor_archive",
        _TRUNK_FILES,
        _channels("m", _DISK_NAMES) + _channels("deg", " ".join(f"phi{motor}" for motor in range(1, 7))),
        _channels("g", "mass"),
        (Part(_LIGHT, end=_TRAINED_SHARE), Part(_HEAVY, end=_TRAINED_SHARE)),
        {"100 g": (Part(_MIDDLE, _TESTED_SHARE),)},
        _read_trunk_load,
        period=_CAPTURE_PERIOD,
        kept_back=Part("soft_trunk/random_*.csv", _TESTED_SHARE),
    ),
    BenchmarkTask(
        "trunk_dc_shape",
        _TRUNK + "dc_motor_archive (commands 60 rows before the observations of the same number)",
        _TRUNK_DC_FILES,
        _channels("deg", " ".join(f"u{motor}" for motor in range(1, 7))),
        _channels("m", _DISK_NAMES),
        (Part(_DC_LIGHT, end=_TRAINED_SHARE),),
        {"400 g": (Part(_DC_HEAVY, _TESTED_SHARE),)},
        _read_trunk_dc,
        period=_CAPTURE_PERIOD,
        kept_back=Part("trunk_dc/*.csv", _TESTED_SHARE),
    ),
)
