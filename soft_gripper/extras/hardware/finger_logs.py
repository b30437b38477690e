"""Logs of fingers with strain sensors: the fields of a bench, or the columns of a recording of one finger."""

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
from soft_gripper.extras.hardware.measured import Measured, check_places, measured_by
from soft_gripper.extras.hardware.recording_schema import RecordingConfig, instrument_columns, load_description
from soft_gripper.extras.hardware.recordings import (
    HardwareRecording,
    check_interval,
    check_relative,
    note_stuck,
    read_recordings,
)
from soft_gripper.extras.hardware.table import Columns, Table, runs_of, without_zero_stamps
from soft_gripper.extras.hardware.table_files import read_table
from soft_gripper.files.document import require, require_value
from soft_gripper.fingers.plant_finger import PlantFinger
from soft_gripper.scenario.nominal_model import read_nominal_model
from soft_gripper.scenario.scenario_file import load_scenario
from soft_gripper.scenario.schema import Scenario
from soft_gripper.sensors.measurement import MeasurementModel

_SHORTEST_INTERVAL, _LONGEST_INTERVAL = 5e-4, 60.0  # s
_REST = 0.3  # s at the beginning, in which a pressure against vacuum is noticed


@dataclass(frozen=True)
class Log:
    """How a log of hardware is read: the fields of a bench, or the columns of a recording of one finger."""

    described: BenchConfig | RecordingConfig
    scenario: Scenario  # with its fingers and sensors


def given_log(
    scenario: str | None, bench: Path | None, described_as: str | None, command: str, changes: Sequence[str] = ()
) -> Log | None:
    """The log that the options --scenario, --bench, --as and --set of a command describe; None if none is given.

    Raises:
        InputError: if they do not go together, or a file does not fit.
    """
    named = {"--scenario": scenario, "--bench": bench, "--as": described_as}
    found = [name for name, value in named.items() if value is not None]
    if not found:
        return None
    if len(found) != 2 or "--scenario" not in found:
        expected = "logs need --scenario, which has the fingers, and either --bench or --as, which names the columns"
        raise InputError(command, "options", found, expected)
    assert scenario is not None
    read = load_bench(bench) if bench is not None else load_description(str(described_as))
    return Log(read, load_scenario(scenario, changes))


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
    """The runs of the fingers in a file.

    Raises:
        InputError: if it does not fit its description, or the scenario's fingers and sensors.
    """
    scenario = log.scenario
    parts = scenario.models, scenario.gravity, scenario.arm
    scene = add_plant(DiagramBuilder(), scenario.plant_config, *parts, visuals=False, directives=scenario.directives)
    fingers = {each.name: each for each in scene.fingers}
    gravity = np.array(scenario.gravity)
    if isinstance(log.described, BenchConfig):
        found = [*_bench_logs(file, log.described, fingers, gravity, scenario.sensor.period)]
    else:
        found = [*_recording_logs(file, log.described, fingers, gravity)]
    for each in found:
        _check(file, each, nominal_layout(scenario, each.finger))
    return found


def steady(value: Array, window: int, most: float) -> NDArray[np.bool_]:
    """Samples before which a value, (T,), has varied by no more than `most` for a window of samples; not where NaN."""
    found = np.zeros(len(value), dtype=bool)
    window = max(window, 1)
    if len(value) > window:
        spans = np.ptp(np.lib.stride_tricks.sliding_window_view(value, window + 1), axis=-1)
        found[window:] = spans <= most
    return found


def nominal_layout(scenario: Scenario, finger: PlantFinger) -> MeasurementModel:
    """The nominal sensors and finger of a scenario."""
    return read_nominal_model(scenario.nominal).layout(finger.finger, scenario.sensor)


def _check(file: Path, log: FingerLog, layout: MeasurementModel) -> None:
    name, readings = log.finger.name, log.readings.shape[1]
    if readings != layout.readings:
        expected = f"give {layout.readings}, as many as the scenario's sensors have"
        raise InputError(file, f"readings of {name}", readings, expected)
    unread = np.flatnonzero(np.isnan(log.pressure))
    if len(unread):
        lost = f"at {log.time[unread[0]]:g} s, and in {len(unread)} of {len(log.time)} samples"
        how = "give a pressure; `hold` in the description is the age, s, up to which the last one counts"
        raise InputError(file, f"pressure of {name}", np.nan, f"{lost}: {how}")
    for kind, measured in log.measured.items():
        check_places(file, f"measured_{kind}.place", measured.place, layout.finger.length)


def _bench_logs(
    file: Path, bench: BenchConfig, fingers: Mapping[str, PlantFinger], gravity: Array, period: float
) -> Iterator[FingerLog]:
    """The fingers of a log with the fields of a bench; `period` of the scenario's sensors, s."""
    named = require_value(bench.time, file, "bench.time", "a log needs the time of every row")
    whole = _table(file, bench, named)
    whole = without_zero_stamps(whole, named, 1.0)
    runs = [whole] if bench.pause is None else runs_of(whole, named, bench.pause)
    for number, table in enumerate(runs, 1):
        time = table.columns([named])[:, 0]
        backward = np.flatnonzero(~(np.diff(time) > 0))
        if len(backward):
            raise InputError(file, named, float(time[backward[0] + 1]), "times must increase from row to row")
        require(len(time) > 1, file, named, len(time), "needs at least 2 samples")
        limits = min(_SHORTEST_INTERVAL, 0.5 * period), max(_LONGEST_INTERVAL, 2 * period)
        check_interval(file, named, time, *limits, "is the time in s?")
        of_run = file.stem if len(runs) == 1 else f"{file.stem}_{number}"
        for name, config in bench.fingers.items():
            of = f"bench.fingers.{name}"
            if name not in fingers:
                known = ", ".join(fingers)
                raise InputError(file, "bench.fingers", name, f"the scenario has no such finger; it has {known}")
            _check_one_pressure(file, f"{of}.pressures", config.pressures)
            pressure = bench.relative(table.columns(config.pressures)[:, 0])
            if bench.pressure_ambient is None:
                how = "give `pressure_ambient`, what it has in open air; if it is not, `pressure_ambient: 0`"
                check_relative(file, f"{of}.pressures", pressure, time <= time[0] + _REST, how)
            X_WB = np.tile(fingers[name].X_WB.GetAsMatrix34(), (len(time), 1, 1))
            if config.base_pose is not None:
                X_WB = table.columns(config.base_pose).reshape(-1, 3, 4)
            readings = table.columns(config.readings)
            note_stuck(file, {f"reading {i} of {name}": one for i, one in enumerate(readings.T)}, {"p": pressure})
            x, z = (None, None) if config.tip is None else table.columns(config.tip).T
            tip = None if x is None else z + 1j * x
            measured = measured_by(table, config, fingers[name].finger.length, f"{of}.")
            yield FingerLog(of_run, fingers[name], time, pressure, X_WB, gravity, readings, tip, measured)


def _recording_logs(
    file: Path, described: RecordingConfig, fingers: Mapping[str, PlantFinger], gravity: Array
) -> Iterator[FingerLog]:
    """The finger of a recording with described columns; its tip is the body "tip", or the mean of its markers."""
    expected = "such a recording is of one finger, and the scenario has"
    if len(fingers) != 1:
        raise InputError(file, "fingers", len(fingers), f"{expected} {', '.join(fingers)}; or give --bench")
    (finger,) = fingers.values()
    for found in read_recordings(file, described):
        readings = require_value(found.readings, file, "readings", "name the columns of the strain sensors")
        pressures = require_value(found.pressures, file, "pressures", "name the column of the pressure")
        _check_one_pressure(file, "pressures.columns", described.pressures.columns if described.pressures else [])
        # Gravity is that of the scenario in the world, or that of the recording in B.
        X_WB, pull = (finger.X_WB.GetAsMatrix34(), gravity) if found.gravity is None else (np.eye(3, 4), found.gravity)
        poses = np.tile(X_WB, (len(found.time), 1, 1))
        of_run = found.name, finger, found.time, pressures[:, 0], poses, pull, readings
        yield FingerLog(*of_run, _tip(found), found.measured)


def _tip(recording: HardwareRecording) -> Planar | None:
    """The place of the tip, (T) z + i x in B, m; None if it has neither a pose nor markers."""
    described = recording.config.markers
    places = [recording.poses["tip"].p] if "tip" in recording.poses else []
    if not places and described is not None:
        places = [recording.markers[name] for name in described.bodies.get("tip", [])]
    if not places:
        return None
    p = np.mean(places, axis=0)
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
