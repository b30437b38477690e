"""Reads logs of fingers with strain sensors: a file, and a bench or a recording description -> T samples a finger.

A recording of this project needs no description: it has its scenario.
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from pydrake.systems.framework import DiagramBuilder

from soft_gripper.arrays import Array, Planar
from soft_gripper.diagrams.recording import Recording
from soft_gripper.diagrams.scene import add_plant
from soft_gripper.errors import InputError
from soft_gripper.extras.hardware.bench_schema import BenchConfig, load_bench
from soft_gripper.extras.hardware.measured import Measured, instrument_violations, place_violations, read_instruments
from soft_gripper.extras.hardware.recording_schema import RecordingConfig, instrument_columns, load_description
from soft_gripper.extras.hardware.recordings import (
    HardwareRecording,
    absolute_violations,
    interval_violations,
    note_stuck,
    read_recordings,
)
from soft_gripper.extras.hardware.table import Columns, drop_zero_stamps, split_runs
from soft_gripper.extras.hardware.table_files import read_table
from soft_gripper.files.document import require, require_value
from soft_gripper.fingers.kinematics import as_planar
from soft_gripper.fingers.plant_finger import PlantFinger
from soft_gripper.quantity import Violation
from soft_gripper.scenario.nominal_model import read_nominal_model
from soft_gripper.scenario.scenario_file import load_scenario, parse_scenario
from soft_gripper.scenario.schema import Scenario
from soft_gripper.sensors.measurement import MeasurementModel

_MIN_INTERVAL, _MAX_INTERVAL = 5e-4, 60.0  # s
_MAX_SIZE = 1e9  # largest absolute value of any recorded signal, in SI units
_REST_TIME = 0.3  # s at the beginning, in which a pressure against vacuum is noticed


@dataclass(frozen=True)
class Log:
    """Description of a log of hardware: the fields of a bench, or the columns of a recording of one finger."""

    described: BenchConfig | RecordingConfig
    scenario: Scenario  # with its fingers and sensors


def load_log(
    scenario: str | None, bench: Path | None, described_as: str | None, command: str, changes: Sequence[str] = ()
) -> Log | None:
    """Log that the options --scenario, --bench, --as and --set of a command describe; None if none is given."""
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
    """Reads the runs of the fingers in a file."""
    scenario = log.scenario
    fingers = {finger.name: finger for finger in _scenario_fingers(scenario)}
    gravity = np.array(scenario.gravity)
    if isinstance(log.described, BenchConfig):
        finger_logs = [*_bench_logs(file, log.described, fingers, gravity, scenario.sensor.period)]
    else:
        finger_logs = [*_recording_logs(file, log.described, fingers, gravity)]
    for log_ in finger_logs:
        _raise_violation(file, _log_violations(log_, nominal_layout(scenario, log_.finger)))
    return finger_logs


def _raise_violation(file: Path, violations: Iterable[Violation]) -> None:
    for violation in violations:
        raise InputError(file, *violation)


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


def _log_violations(log: FingerLog, layout: MeasurementModel) -> Iterator[Violation]:
    """Yields violations of the sensors of a finger by its log."""
    name, readings = log.finger.name, log.readings.shape[1]
    if readings != layout.readings:
        yield f"readings of {name}", readings, f"give {layout.readings}, as many as the scenario's sensors have"
    missing_rows = np.flatnonzero(np.isnan(log.pressure))
    if len(missing_rows):
        loss = f"at {log.time[missing_rows[0]]:g} s, and in {len(missing_rows)} of {len(log.time)} samples"
        remedy = "give a pressure; `hold` in the description is the age, s, up to which the last one counts"
        yield f"pressure of {name}", np.nan, f"{loss}: {remedy}"
    for kind, measured in log.measured.items():
        yield from place_violations(f"measured_{kind}.place", measured.place, layout.finger.length)


def _bench_logs(
    file: Path, bench: BenchConfig, fingers: Mapping[str, PlantFinger], gravity: Array, period: float
) -> Iterator[FingerLog]:
    """Yields the fingers of a log with the fields of a bench; `period` of the scenario's sensors, s."""
    time_column = require_value(bench.time, file, "bench.time", "a log needs the time of every row")
    log_table = drop_zero_stamps(read_table(file, _bench_columns(bench, time_column)), time_column, 1.0)
    runs = [log_table] if bench.pause is None else split_runs(log_table, time_column, bench.pause)
    for run_number, table in enumerate(runs, 1):
        time = table.columns([time_column])[:, 0]
        _raise_violation(file, _bench_violations(bench, time_column, time, fingers, period))
        run_name = file.stem if len(runs) == 1 else f"{file.stem}_{run_number}"
        for name, config in bench.fingers.items():
            field, finger = f"bench.fingers.{name}", fingers[name]
            pressure = bench.relative(table.columns(config.pressures)[:, 0])
            if bench.pressure_ambient is None:
                remedy = "give `pressure_ambient`, what it has in open air; if it is not, `pressure_ambient: 0`"
                reference = time <= time[0] + _REST_TIME
                _raise_violation(file, absolute_violations(f"{field}.pressures", pressure, reference, remedy))
            X_WB = np.tile(finger.X_WB.GetAsMatrix34(), (len(time), 1, 1))
            if config.base_pose is not None:
                X_WB = table.columns(config.base_pose).reshape(-1, 3, 4)
            readings = table.columns(config.readings)
            note_stuck(file, {f"reading {i} of {name}": row for i, row in enumerate(readings.T)}, {"p": pressure})
            tip = None if config.tip is None else as_planar(table.columns(config.tip))
            measured = read_instruments(table, config)
            _raise_violation(file, instrument_violations(measured, config, finger.finger.length, f"{field}."))
            yield FingerLog(run_name, finger, time, pressure, X_WB, gravity, readings, tip, measured)


def _bench_violations(
    bench: BenchConfig, time_column: str, time: Array, fingers: Mapping[str, PlantFinger], period: float
) -> Iterator[Violation]:
    """Yields violations in the times, (T,) s, of a run, and in the fingers of its bench."""
    for wrong_time in time[1:][~(np.diff(time) > 0)]:
        yield time_column, float(wrong_time), "times must increase from row to row"
    if len(time) < 2:
        yield time_column, len(time), "needs at least 2 samples"
    limits = min(_MIN_INTERVAL, 0.5 * period), max(_MAX_INTERVAL, 2 * period)
    yield from interval_violations(time_column, time, *limits, "is the time in s?")
    for name, config in bench.fingers.items():
        if name not in fingers:
            yield "bench.fingers", name, f"the scenario has no such finger; it has {', '.join(fingers)}"
        yield from _pressure_violations(f"bench.fingers.{name}.pressures", config.pressures)


def _pressure_violations(field: str, columns: Sequence[str]) -> Iterator[Violation]:
    if len(columns) != 1:
        yield field, [*columns], "give the one pressure that bends the finger"


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
        columns = described.pressures.columns if described.pressures else []
        _raise_violation(file, _pressure_violations("pressures.columns", columns))
        # Gravity is that of the scenario in the world, or that of the recording in B.
        X_WB, g = (finger.X_WB.GetAsMatrix34(), gravity) if run.gravity is None else (np.eye(3, 4), run.gravity)
        poses = np.tile(X_WB, (len(run.time), 1, 1))
        samples = run.name, finger, run.time, pressures[:, 0], poses, g, readings
        yield FingerLog(*samples, _tip(run), run.measured)


def _tip(recording: HardwareRecording) -> Planar | None:
    """Position of the tip, (T) z + i x in B, m; None if it has neither a pose nor markers."""
    markers_config = recording.config.markers
    points = [recording.poses["tip"].p] if "tip" in recording.poses else []
    if not points and markers_config is not None:
        points = [recording.markers[name] for name in markers_config.bodies.get("tip", [])]
    return as_planar(np.mean(points, axis=0)[:, ::2]) if points else None


def _bench_columns(bench: BenchConfig, time: str) -> Columns:
    names: dict[str, str] = {}
    for name, finger in bench.fingers.items():
        for kind in ("readings", "pressures", "base_pose", "tip"):
            names |= dict.fromkeys(getattr(finger, kind) or (), f"bench.fingers.{name}.{kind}")
        names |= instrument_columns(finger, f"bench.fingers.{name}.")
    return Columns(names, time, header=bench.fields or None, points="{marker}_{axis}", hold=bench.hold)


class RecordedRun(NamedTuple):
    """A recording, with its station and fingers."""

    recording: Recording
    scenario: Scenario
    fingers: Sequence[PlantFinger]


def load_run(file: Path) -> RecordedRun:
    """Reads a recording written by `soft-gripper run` or `play`."""
    recording = Recording.load(file)
    text = recording.data.attrs.get("scenario")
    if not isinstance(text, str):
        raise InputError(file, "scenario", text, "is not a recording of a scenario: it has no such attribute")
    scenario = parse_scenario(file, text)
    _check_time(file, recording, scenario.sensor.period)
    fingers = _scenario_fingers(scenario)
    require(len(fingers) > 0, file, "fingers", [], "there is no finger in the recording")
    return RecordedRun(recording, scenario, fingers)


def _check_time(file: Path, recording: Recording, period: float) -> None:
    """Checks that samples are a period apart, s, since they are addressed by index."""
    time = recording.data.get("time")
    if time is None or time.dims != ("time",) or time.dtype.kind != "f" or not len(time):
        variable = None if time is None else f"{time.dtype} {time.dims}"
        raise InputError(file, "time", variable, "give the time of every sample, s")
    steps = np.diff(time.values, prepend=-period)
    wrong_rows = np.flatnonzero(~((steps > 0) & (steps < 2 * period)))
    if len(wrong_rows):
        value, expected = float(time[wrong_rows[0]]), f"times must start at 0 s and increase by {period:g} s"
        raise InputError(file, f"time[{wrong_rows[0]}]", value, expected)


def read_signal(file: object, recording: Recording, name: str, *shape: int, allow_nan: bool = False) -> Array:
    """A signal of the recording in `file`, (T, *shape).

    With `allow_nan`, samples may be NaN, as from a sensor with dropouts.
    """
    if name not in recording.data:
        raise InputError(file, "signal", name, "is not in the recording")
    values: Array = recording[name].values
    expected_shape = (recording.data.sizes["time"], *shape)
    if values.shape != expected_shape or values.dtype.kind != "f":
        raise InputError(
            file, name, f"{values.dtype} {values.shape}", f"give floating-point numbers of shape {expected_shape}"
        )
    wrong = values[~((np.abs(values) < _MAX_SIZE) | (allow_nan & np.isnan(values)))]
    if len(wrong):
        raise InputError(file, name, float(wrong[0]), f"give finite numbers with absolute values below {_MAX_SIZE:g}")
    return values


def _scenario_fingers(scenario: Scenario) -> Sequence[PlantFinger]:
    return add_plant(DiagramBuilder(), scenario, visuals=False).fingers
