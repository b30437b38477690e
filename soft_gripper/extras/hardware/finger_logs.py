"""Reads logs of fingers with strain sensors, by a bench or a recording description: a file -> T samples a finger."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from pydrake.systems.framework import DiagramBuilder

from soft_gripper.arrays import Array, Planar
from soft_gripper.diagrams.scene import add_plant
from soft_gripper.errors import InputError
from soft_gripper.extras.hardware.bench_schema import BenchConfig, load_bench
from soft_gripper.extras.hardware.measured import Measured, check_places, read_instruments
from soft_gripper.extras.hardware.recording_schema import RecordingConfig, instrument_columns, load_description
from soft_gripper.extras.hardware.recordings import (
    HardwareRecording,
    check_interval,
    check_relative,
    note_stuck,
    read_recordings,
)
from soft_gripper.extras.hardware.table import Columns, Table, drop_zero_stamps, split_runs
from soft_gripper.extras.hardware.table_files import read_table
from soft_gripper.files.document import require, require_value
from soft_gripper.fingers.plant_finger import PlantFinger
from soft_gripper.scenario.nominal_model import read_nominal_model
from soft_gripper.scenario.scenario_file import load_scenario
from soft_gripper.scenario.schema import Scenario
from soft_gripper.sensors.measurement import MeasurementModel

_MIN_INTERVAL, _MAX_INTERVAL = 5e-4, 60.0  # s
_REST_TIME = 0.3  # s at the beginning, in which a pressure against vacuum is noticed


@dataclass(frozen=True)
class Log:
    """Description of a log of hardware: the fields of a bench, or the columns of a recording of one finger."""

    described: BenchConfig | RecordingConfig
    scenario: Scenario  # with its fingers and sensors


def load_log(
    scenario: str | None, bench: Path | None, described_as: str | None, command: str, changes: Sequence[str] = ()
) -> Log | None:
    """Log that the options --scenario, --bench, --as and --set of a command describe; None if none is given.

    Raises:
        InputError: if they do not go together, or a file does not fit.
    """
    option_values = {"--scenario": scenario, "--bench": bench, "--as": described_as}
    given_options = [name for name, value in option_values.items() if value is not None]
    if not given_options:
        return None
    if len(given_options) != 2 or "--scenario" not in given_options:
        expected = "logs need --scenario, which has the fingers, and either --bench or --as, which names the columns"
        raise InputError(command, "options", given_options, expected)
    assert scenario is not None
    description = load_bench(bench) if bench is not None else load_description(str(described_as))
    return Log(description, load_scenario(scenario, changes))


@dataclass(frozen=True)
class FingerLog:
    """T samples of a finger, from one run of a log."""

    name: str  # of the file, with the number of the run if it has several
    finger: PlantFinger
    time: Array  # (T) s, increasing
    pressure: Array  # (T) Pa
    X_WB: Array  # (T, 3, 4) of the base
    gravity: Array  # (3,) m/s^2, in the axes of the pose
    readings: Array  # (T, R) of the sensors
    tip: Planar | None = None  # (T) m, z + i x in B
    measured: Mapping[str, Measured] = field(default_factory=dict)  # by instruments: "force", "torque", "angle"


def read_finger_logs(file: Path, log: Log) -> list[FingerLog]:
    """Reads the runs of the fingers in a file.

    Raises:
        InputError: if it does not fit its description, or the scenario's fingers and sensors.
    """
    scenario = log.scenario
    scene = add_plant(DiagramBuilder(), scenario, visuals=False)
    fingers = {log_.name: log_ for log_ in scene.fingers}
    gravity = np.array(scenario.gravity)
    if isinstance(log.described, BenchConfig):
        finger_logs = [*_bench_logs(file, log.described, fingers, gravity, scenario.sensor.period)]
    else:
        finger_logs = [*_recording_logs(file, log.described, fingers, gravity)]
    for log_ in finger_logs:
        _check(file, log_, nominal_layout(scenario, log_.finger))
    return finger_logs


def steady(value: Array, window: int, max_range: float) -> NDArray[np.bool_]:
    """Mask of samples after a window in which a value, (T,), varied by at most `max_range`; False where it is NaN."""
    is_steady = np.zeros(len(value), dtype=bool)
    window = max(window, 1)
    if len(value) > window:
        spans = np.ptp(np.lib.stride_tricks.sliding_window_view(value, window + 1), axis=-1)
        is_steady[window:] = spans <= max_range
    return is_steady


def nominal_layout(scenario: Scenario, finger: PlantFinger) -> MeasurementModel:
    """Nominal sensors and finger of a scenario."""
    return read_nominal_model(scenario.nominal).layout(finger.finger, scenario.sensor)


def _check(file: Path, log: FingerLog, layout: MeasurementModel) -> None:
    name, readings = log.finger.name, log.readings.shape[1]
    if readings != layout.readings:
        expected = f"give {layout.readings}, as many as the scenario's sensors have"
        raise InputError(file, f"readings of {name}", readings, expected)
    unread = np.flatnonzero(np.isnan(log.pressure))
    if len(unread):
        loss = f"at {log.time[unread[0]]:g} s, and in {len(unread)} of {len(log.time)} samples"
        remedy = "give a pressure; `hold` in the description is the age, s, up to which the last one counts"
        raise InputError(file, f"pressure of {name}", np.nan, f"{loss}: {remedy}")
    for kind, measured in log.measured.items():
        check_places(file, f"measured_{kind}.place", measured.place, layout.finger.length)


def _bench_logs(
    file: Path, bench: BenchConfig, fingers: Mapping[str, PlantFinger], gravity: Array, period: float
) -> Iterator[FingerLog]:
    """Yields the fingers of a log with the fields of a bench; `period` of the scenario's sensors, s."""
    time_column = require_value(bench.time, file, "bench.time", "a log needs the time of every row")
    log_table = _table(file, bench, time_column)
    log_table = drop_zero_stamps(log_table, time_column, 1.0)
    runs = [log_table] if bench.pause is None else split_runs(log_table, time_column, bench.pause)
    for number, table in enumerate(runs, 1):
        time = table.columns([time_column])[:, 0]
        backward = np.flatnonzero(~(np.diff(time) > 0))
        if len(backward):
            raise InputError(file, time_column, float(time[backward[0] + 1]), "times must increase from row to row")
        require(len(time) > 1, file, time_column, len(time), "needs at least 2 samples")
        limits = min(_MIN_INTERVAL, 0.5 * period), max(_MAX_INTERVAL, 2 * period)
        check_interval(file, time_column, time, *limits, "is the time in s?")
        run_name = file.stem if len(runs) == 1 else f"{file.stem}_{number}"
        for name, config in bench.fingers.items():
            field = f"bench.fingers.{name}"
            if name not in fingers:
                finger_names = ", ".join(fingers)
                raise InputError(file, "bench.fingers", name, f"the scenario has no such finger; it has {finger_names}")
            _check_one_pressure(file, f"{field}.pressures", config.pressures)
            pressure = bench.relative(table.columns(config.pressures)[:, 0])
            if bench.pressure_ambient is None:
                remedy = "give `pressure_ambient`, what it has in open air; if it is not, `pressure_ambient: 0`"
                check_relative(file, f"{field}.pressures", pressure, time <= time[0] + _REST_TIME, remedy)
            X_WB = np.tile(fingers[name].X_WB.GetAsMatrix34(), (len(time), 1, 1))
            if config.base_pose is not None:
                X_WB = table.columns(config.base_pose).reshape(-1, 3, 4)
            readings = table.columns(config.readings)
            note_stuck(file, {f"reading {i} of {name}": row for i, row in enumerate(readings.T)}, {"p": pressure})
            x, z = (None, None) if config.tip is None else table.columns(config.tip).T
            tip = None if x is None else z + 1j * x
            measured = read_instruments(table, config, fingers[name].finger.length, f"{field}.")
            yield FingerLog(run_name, fingers[name], time, pressure, X_WB, gravity, readings, tip, measured)


def _recording_logs(
    file: Path, described: RecordingConfig, fingers: Mapping[str, PlantFinger], gravity: Array
) -> Iterator[FingerLog]:
    """Yields the finger of each run of a recording; its tip is the body "tip", or the mean of its markers."""
    expected = "such a recording is of one finger, and the scenario has"
    if len(fingers) != 1:
        raise InputError(file, "fingers", len(fingers), f"{expected} {', '.join(fingers)}; or give --bench")
    (finger,) = fingers.values()
    for run in read_recordings(file, described):
        readings = require_value(run.readings, file, "readings", "name the columns of the strain sensors")
        pressures = require_value(run.pressures, file, "pressures", "name the column of the pressure")
        _check_one_pressure(file, "pressures.columns", described.pressures.columns if described.pressures else [])
        # Gravity is that of the scenario in the world, or that of the recording in B.
        X_WB, g = (finger.X_WB.GetAsMatrix34(), gravity) if run.gravity is None else (np.eye(3, 4), run.gravity)
        poses = np.tile(X_WB, (len(run.time), 1, 1))
        samples = run.name, finger, run.time, pressures[:, 0], poses, g, readings
        yield FingerLog(*samples, _tip(run), run.measured)


def _tip(recording: HardwareRecording) -> Planar | None:
    """Position of the tip, (T) z + i x in B, m; None if it has neither a pose nor markers."""
    described = recording.config.markers
    points = [recording.poses["tip"].p] if "tip" in recording.poses else []
    if not points and described is not None:
        points = [recording.markers[name] for name in described.bodies.get("tip", [])]
    if not points:
        return None
    p = np.mean(points, axis=0)
    tip: Planar = p[:, 2] + 1j * p[:, 0]
    return tip


def _check_one_pressure(file: Path, field: str, columns: Sequence[str]) -> None:
    if len(columns) != 1:
        raise InputError(file, field, [*columns], "give the one pressure that bends the finger")


def _table(file: Path, bench: BenchConfig, time: str) -> Table:
    """The rows of a log."""
    names: dict[str, str] = {}
    for name, finger in bench.fingers.items():
        for kind in ("readings", "pressures", "base_pose", "tip"):
            names |= dict.fromkeys(getattr(finger, kind) or (), f"bench.fingers.{name}.{kind}")
        names |= instrument_columns(finger, f"bench.fingers.{name}.")
    return read_table(
        file, Columns(names, time, header=bench.fields or None, points="{marker}_{axis}", hold=bench.hold)
    )
