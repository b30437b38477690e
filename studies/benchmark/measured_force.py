"""Measured contact forces: a task of every folder with logs of a finger that presses on an instrument, such as a scale.

A folder has `bench.yaml`, which describes the logs, `finger.yaml`, a scenario, and logs: `train*.csv`, and `test*.csv`
of other days. Every press is a sample. Its force is the median of what the instrument reads while the pressure rests,
less what it reads in the free holds before and after, in which the pressure is the lowest of the run: neither its zero,
nor drift or delay count, and no estimate is used.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import partial
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
from studies.benchmark.benchmark_task import Channel, Part, Predict, Question, Recorded, Task, digest

FORCES = "measured_force"  # below the data folder: a folder for every task
BENCH, SCENARIO = "bench.yaml", "finger.yaml"
TRIALS = "train*.csv", "test*.csv"
_SETTLED = 1.0  # s for which a pressure has rested before what is read counts
_RESTING = 0.02  # of the range of the pressure in a run: what it may vary by in that time
_FREE = 0.05  # of that range above the lowest pressure, up to which the finger is free


def force_tasks(data: Path) -> list[Task]:
    """The tasks of a data folder.

    Raises:
        InputError: if a folder has no logs to train on and to test, or its description does not fit.
    """
    return [_task(folder) for folder in sorted((data / FORCES).glob("*")) if folder.is_dir()]


def _task(folder: Path) -> Task:
    train, tested = (sorted(file.name for file in folder.glob(pattern)) for pattern in TRIALS)
    for pattern, found in zip(TRIALS, (train, tested), strict=True):
        require(len(found) > 0, folder, pattern, None, "give logs of presses, to train on and of other days to test")
    log = _log(folder)
    assert isinstance(log.described, BenchConfig)
    ((_, finger),) = log.described.fingers.items()
    readings = " ".join(f"reading_{i}" for i in range(len(finger.readings)))
    free = " ".join(f"free_{name}" for name in readings.split())
    channels = [Channel(name, "1") for name in readings.split()], [Channel(name, "1") for name in free.split()]
    return Task(
        f"force_{folder.name}",
        str(folder),
        {name: digest(folder / name) for name in (*train, *tested, BENCH, SCENARIO)},
        (*channels[0], Channel("pressure", "Pa"), *channels[1], Channel("free_pressure", "Pa")),
        (Channel("force", "N"),),
        tuple(map(Part, train)),
        {Path(name).stem: (Part(name),) for name in tested},
        partial(_presses, log),
        folder,
        given=tuple(sorted(file.name for file in folder.iterdir() if file.is_file() and file.name not in tested)),
    )


def _log(folder: Path) -> Log:
    log = load_log(str(folder / SCENARIO), folder / BENCH, None, "benchmark")
    assert log is not None
    assert isinstance(log.described, BenchConfig)
    fingers = log.described.fingers
    measured = [name for name, finger in fingers.items() if finger.measured_force is not None]
    require(
        len(fingers) == len(measured) == 1, folder / BENCH, "fingers", [*fingers], "give one, with `measured_force`"
    )
    moves = fingers[measured[0]].base_pose
    require(
        moves is None, folder / BENCH, f"fingers.{measured[0]}.base_pose", moves, "leave it out: the base is clamped"
    )
    return log


@dataclass(frozen=True)
class _Hold:
    """Medians of what is read while a pressure rests."""

    time: float  # s
    readings: Array  # (R,)
    pressure: float  # Pa
    value: float  # N, of the instrument


def _presses(log: Log, path: Path) -> Recorded:
    """Readings and pressure in every press and in the free hold before it, (T, 2 R + 2), and the force, (T, 1) N."""
    rows = [row for run in read_finger_logs(path, log) for row in _of_run(path, run)]
    expected = f"has no press: hold the pressure for more than {_SETTLED:g} s, free and pressing in turn"
    require(len(rows) > 0, path, "presses", 0, expected)
    table = np.array(rows)
    return Recorded(table[:, :-1], table[:, -1:])


def _of_run(path: Path, run: FingerLog) -> Iterator[Array]:
    holds = list(_holds(run))
    pressures = np.array([hold.pressure for hold in holds])
    is_free = pressures <= run.pressure.min() + _FREE * np.ptp(run.pressure)
    free = [hold for hold, of in zip(holds, is_free, strict=True) if of]
    if holds and not free:
        raise InputError(path, run.name, "no free hold", "begin with the finger free, at its lowest pressure")
    for hold, of in zip(holds, is_free, strict=True):
        if not of:
            zero = np.interp(hold.time, [each.time for each in free], [each.value for each in free])
            before = [each for each in free if each.time < hold.time] or free[:1]
            known = *hold.readings, hold.pressure, *before[-1].readings, before[-1].pressure
            yield np.array([*known, hold.value - zero])


def _holds(run: FingerLog) -> Iterator[_Hold]:
    """Where the pressure rests, and the instrument was read."""
    window = round(_SETTLED / float(np.median(np.diff(run.time))))
    rest = np.flatnonzero(steady(run.pressure, window, _RESTING * float(np.ptp(run.pressure))))
    value: Array = run.measured["force"].value
    for rows in np.split(rest, np.flatnonzero(np.diff(rest) > 1) + 1):
        if len(rows) and np.isfinite(value[rows]).any():
            medians = np.nanmedian(run.readings[rows], axis=0), float(np.median(run.pressure[rows]))
            yield _Hold(float(run.time[rows].mean()), *medians, float(np.nanmedian(value[rows])))


def measured_force(task: Question, train: Sequence[Recorded]) -> Predict:
    """The force by `contact`, as the scenario states it, with sensors that are zeroed in the free hold."""
    path = train[0].path
    assert path is not None
    log = _log(path.parent)
    run = read_finger_logs(path, log)[0]
    layout = nominal_layout(log.scenario, run.finger)
    finger, instrument = layout.finger, run.measured["force"]
    estimate = ContactShape(layout, uncertainty(log.scenario.estimator, log.scenario.sensor, layout.calibrated))
    gravity = run.X_WB[0].reshape(3, 4)[:, :3].T @ run.gravity
    weight = planar_gravity(run.X_WB[0], run.gravity)

    def predict(inputs: Array) -> tuple[Array, Array]:
        pressed, free = np.split(inputs, 2, axis=-1)
        zero = free[:, :-1] - layout.read(resting_angles(finger, free[:, -1], weight)).reshape(len(free), -1)
        known = pressed[:, :-1] - zero, finger.pressure_torque(pressed[:, -1]), gravity
        found = estimate(*known).contact
        assert found is not None
        assert found.vector is not None
        low, _, high = np.nan_to_num(estimate.posterior(*known).force_interval, nan=0.0).T
        force = np.nan_to_num(found.force)
        wide = np.maximum(high - np.abs(force), np.abs(force) - low) / NORMAL_95
        if instrument.along is None:
            return force[:, None], wide[:, None]
        along = np.array(instrument.along) / np.hypot(*instrument.along)
        return np.nan_to_num(found.vector[:, ::2] @ along)[:, None], wide[:, None]

    return predict
