"""Makes tasks of measured contact forces: one for every folder with logs of a finger that presses on an instrument.

A folder has `bench.yaml`, which describes the logs, `finger.yaml`, a scenario, and logs: `train*.csv`, and `test*.csv`
of other days. Every press is a sample. Its force is the median reading of the instrument while the pressure rests,
less its readings in the free holds before and after, at the lowest pressure of the run: neither its zero,
nor drift or delay count, and no estimate is used.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import compress
from pathlib import Path

import numpy as np

from soft_gripper.arrays import Array
from soft_gripper.errors import InputError
from soft_gripper.estimators.contact import ContactShape
from soft_gripper.estimators.plane import planar_gravity
from soft_gripper.extras.hardware.bench_schema import BenchConfig
from soft_gripper.extras.hardware.finger_logs import FingerLog, Log, load_log, nominal_layout, read_finger_logs, steady
from soft_gripper.extras.hardware.scoring import NORMAL_95
from soft_gripper.files.document import require
from soft_gripper.fingers.statics import resting_angles
from soft_gripper.scenario.sensor_presets import uncertainty
from studies.benchmark.benchmark_task import BenchmarkTask, Channel, Part, Predict, Question, Recorded, digest

FORCE_FOLDER = "measured_force"  # below the data folder: a folder for every task
BENCH, SCENARIO = "bench.yaml", "finger.yaml"
LOG_PATTERNS = "train*.csv", "test*.csv"
_REST_TIME = 1.0  # s, rest of a pressure before readings count
_REST_PRESSURE_SHARE = 0.02  # of the range of the pressure in a run: its variation in that time
_FREE_PRESSURE_SHARE = 0.05  # of that range above the lowest pressure; the finger is free below


def force_tasks(data: Path) -> list[BenchmarkTask]:
    """Makes the tasks of a data folder.

    Raises:
        InputError: if a folder has no logs to train on and to test, or its description does not fit.
    """
    return [_task(folder) for folder in sorted((data / FORCE_FOLDER).glob("*")) if folder.is_dir()]


def _task(folder: Path) -> BenchmarkTask:
    train_files, test_files = (sorted(file.name for file in folder.glob(pattern)) for pattern in LOG_PATTERNS)
    for pattern, names in zip(LOG_PATTERNS, (train_files, test_files), strict=True):
        require(len(names) > 0, folder, pattern, None, "give logs of presses, to train on and of other days to test")
    log = _load_log(folder)
    assert isinstance(log.described, BenchConfig)
    ((_, finger),) = log.described.fingers.items()
    readings = " ".join(f"reading_{i}" for i in range(len(finger.readings)))
    free_names = " ".join(f"free_{name}" for name in readings.split())
    channels = [Channel(name, "1") for name in readings.split()], [Channel(name, "1") for name in free_names.split()]
    return BenchmarkTask(
        f"force_{folder.name}",
        str(folder),
        {name: digest(folder / name) for name in (*train_files, *test_files, BENCH, SCENARIO)},
        (*channels[0], Channel("pressure", "Pa"), *channels[1], Channel("free_pressure", "Pa")),
        (Channel("force", "N"),),
        tuple(map(Part, train_files)),
        {Path(name).stem: (Part(name),) for name in test_files},
        partial(_read_presses, log),
        folder,
        given=tuple(sorted(file.name for file in folder.iterdir() if file.is_file() and file.name not in test_files)),
    )


def _load_log(folder: Path) -> Log:
    log = load_log(str(folder / SCENARIO), folder / BENCH, None, "benchmark")
    assert log is not None
    assert isinstance(log.described, BenchConfig)
    fingers = log.described.fingers
    names = [name for name, finger in fingers.items() if finger.measured_force is not None]
    require(len(fingers) == len(names) == 1, folder / BENCH, "fingers", [*fingers], "give one, with `measured_force`")
    pose = fingers[names[0]].base_pose
    require(pose is None, folder / BENCH, f"fingers.{names[0]}.base_pose", pose, "leave it out: the base is clamped")
    return log


@dataclass(frozen=True)
class _Hold:
    """Medians of the readings while a pressure rests."""

    time: float  # s
    readings: Array  # (R,)
    pressure: float  # Pa
    value: float  # N, of the instrument


def _read_presses(log: Log, path: Path) -> Recorded:
    """Reads readings and pressure in every press and the free hold before it, (T, 2 R + 2), and the force, (T, 1) N."""
    rows = [row for run in read_finger_logs(path, log) for row in _press_rows(path, run)]
    expected = f"has no press: hold the pressure for more than {_REST_TIME:g} s, free and pressing in turn"
    require(len(rows) > 0, path, "presses", 0, expected)
    table = np.array(rows)
    return Recorded(table[:, :-1], table[:, -1:])


def _press_rows(path: Path, run: FingerLog) -> Iterator[Array]:
    holds = list(_holds(run))
    pressures = np.array([hold.pressure for hold in holds])
    is_free = pressures <= run.pressure.min() + _FREE_PRESSURE_SHARE * np.ptp(run.pressure)
    free_holds = list(compress(holds, is_free))
    if holds and not free_holds:
        raise InputError(path, run.name, "no free hold", "begin with the finger free, at its lowest pressure")
    for hold, hold_is_free in zip(holds, is_free, strict=True):
        if not hold_is_free:
            zero = np.interp(hold.time, [free.time for free in free_holds], [free.value for free in free_holds])
            last_free = ([free for free in free_holds if free.time < hold.time] or free_holds[:1])[-1]
            inputs = *hold.readings, hold.pressure, *last_free.readings, last_free.pressure
            yield np.array([*inputs, hold.value - zero])


def _holds(run: FingerLog) -> Iterator[_Hold]:
    """Yields the holds of constant pressure with readings of the instrument."""
    window = round(_REST_TIME / float(np.median(np.diff(run.time))))
    resting_rows = np.flatnonzero(steady(run.pressure, window, _REST_PRESSURE_SHARE * float(np.ptp(run.pressure))))
    value: Array = run.measured["force"].value
    for rows in np.split(resting_rows, np.flatnonzero(np.diff(resting_rows) > 1) + 1):
        if len(rows) and np.isfinite(value[rows]).any():
            medians = np.nanmedian(run.readings[rows], axis=0), float(np.median(run.pressure[rows]))
            yield _Hold(float(run.time[rows].mean()), *medians, float(np.nanmedian(value[rows])))


def measured_force(task: Question, train: Sequence[Recorded]) -> Predict:
    """Estimates the force by `contact`, as the scenario configures it, with sensors zeroed in the free hold."""
    path = train[0].path
    assert path is not None
    log = _load_log(path.parent)
    run = read_finger_logs(path, log)[0]
    layout = nominal_layout(log.scenario, run.finger)
    finger, instrument = layout.finger, run.measured["force"]
    estimate = ContactShape(layout, uncertainty(log.scenario.estimator, log.scenario.sensor, layout.calibrated))
    gravity = run.X_WB[0].reshape(3, 4)[:, :3].T @ run.gravity
    weight = planar_gravity(run.X_WB[0], run.gravity)

    def predict(inputs: Array) -> tuple[Array, Array]:
        touched, free = np.split(inputs, 2, axis=-1)
        zero = free[:, :-1] - layout.read(resting_angles(finger, free[:, -1], weight)).reshape(len(free), -1)
        pressed_inputs = touched[:, :-1] - zero, finger.pressure_torque(touched[:, -1]), gravity
        contact = estimate(*pressed_inputs).contact
        assert contact is not None
        assert contact.vector is not None
        low, _, high = np.nan_to_num(estimate.posterior(*pressed_inputs).force_interval, nan=0.0).T
        force = np.nan_to_num(contact.force)
        std = np.maximum(high - np.abs(force), np.abs(force) - low) / NORMAL_95
        if instrument.along is None:
            return force[:, None], std[:, None]
        axis = np.array(instrument.along) / np.hypot(*instrument.along)
        return np.nan_to_num(contact.vector[:, ::2] @ axis)[:, None], std[:, None]

    return predict
