"""Recordings of free bending -> a calibration of the fingers in them.

Recordings are those of `soft-gripper run` and `play`, or logs of hardware, any file of `tables`. Their columns are the
fields of a bench (`live.bench_schema`), or those of a recording of one finger, markers included (`recording_schema`).
"""

from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from pydrake.systems.framework import DiagramBuilder

from soft_gripper.arrays import Array, Planar
from soft_gripper.diagrams.scene import add_plant
from soft_gripper.errors import InputError
from soft_gripper.estimators.plane import planar_gravity
from soft_gripper.extras.hardware.bench_schema import BenchConfig
from soft_gripper.extras.hardware.free_bending import FreeBending, calibrate
from soft_gripper.extras.hardware.recorded_run import load_run, read_signal
from soft_gripper.extras.hardware.recording_schema import RecordingConfig
from soft_gripper.extras.hardware.recordings import HardwareRecording, check_relative, read_recording
from soft_gripper.extras.hardware.table import Columns, Table
from soft_gripper.extras.hardware.table_files import read_table
from soft_gripper.files.document import given, require
from soft_gripper.fingers.plant_finger import PlantFinger
from soft_gripper.scenario.calibration_file import Calibration, CalibrationConfig, as_config
from soft_gripper.scenario.nominal_model import read_nominal_model
from soft_gripper.scenario.schema import Scenario
from soft_gripper.sensors.sensor_layout import SensorLayout, strain_sensors

ASSUMED = "gains are 1 within 5 %, the shape of the response is right, and the finger's own weight is its only load"
_REST = 0.3  # s of constant pressure, after which a finger is assumed to be at rest
_STEADY_PRESSURE = 0.02  # share of the pressure range; allowed variation in that time
_SAMPLES = 3000  # number of samples used per recording, spread evenly
_MOTION = 0.01  # extension ratio: smallest range of the most stretched sensor
_LEAST_GAIN = 0.5  # or its inverse; values further from 1 are rejected as errors
_RESIDUAL = 0.05  # share of that range; larger residuals indicate contact or a different finger


@dataclass(frozen=True)
class Log:
    """How a log of hardware is read: the fields of a bench, or the columns of a recording of one finger."""

    described: BenchConfig | RecordingConfig
    scenario: Scenario  # with its fingers and sensors


class _Measured(NamedTuple):
    """Measurements of a finger, T samples."""

    time: Array  # (T) s
    pressure: Array  # (T) Pa
    gravity: Planar  # (T) see FreeBending
    readings: Array  # (T, R), or extension ratios
    tip: Planar | None  # (T) m


class _Recorded(NamedTuple):
    """A recording of one finger: the nominal layout, and what was measured."""

    layout: SensorLayout
    samples: FreeBending


def calibrate_recordings(
    files: Sequence[Path], log: Log | None = None, sought: Collection[str] = ()
) -> CalibrationConfig:
    """Fits gains, offsets, hysteresis, drift and the bend ratio of each finger to all recordings together.

    The fit starts from the nominal models of the recordings, without the calibrations loaded in them.

    Args:
        files: recordings of this project, unless `log` says how to read them.
        log: of other recordings.
        sought: names of what is fitted beyond these, see `free_bending.SOUGHT`.

    Raises:
        InputError: if the recordings cannot be read, are of different fingers, or do not show free bending.
    """
    layouts: dict[str, SensorLayout] = {}
    recorded: dict[str, list[FreeBending]] = {}
    for file in files:
        for layout, found in _simulated(file) if log is None else _logged(file, log):
            name = layout.finger.name
            if layouts.setdefault(name, layout) != layout:
                raise InputError(file, "finger", name, f"finger or sensors differ from those in {files[0]}")
            recorded.setdefault(name, []).append(found)
    fingers = {}
    for name, layout in layouts.items():
        calibration = calibrate(layout, recorded[name], sought)
        at_rest = np.concatenate([each.ratios[each.hold >= 0] for each in recorded[name]])
        _check_fit(name, calibration, _range(at_rest[np.isfinite(at_rest).all(axis=1)]))
        doubtful = [f"{files[number].name} at {time:.1f} s" for number, time in calibration.doubtful]
        fingers[name] = as_config(layout, calibration, doubtful)
    return CalibrationConfig(ASSUMED, fingers)


def _simulated(file: Path) -> Iterator[_Recorded]:
    """The fingers of a recording of this project."""
    recording, scenario, fingers = load_run(file)
    for finger in fingers:
        layout, name = _nominal(scenario, finger, file), finger.name
        pressure = read_signal(file, recording, f"{name}.sampled_pressure")
        strain = read_signal(file, recording, f"{name}.strain", layout.paths, layout.sections, allow_nan=True)
        X_WB = read_signal(file, recording, f"{name}.X_WB", 3, 4)
        time = scenario.sensor.period * np.arange(len(pressure))
        ratios = layout.response.ratio(strain.reshape(len(strain), layout.readings))
        gravity = planar_gravity(X_WB, np.array(scenario.gravity))
        samples = _free_bending(file, layout, _Measured(time, pressure, gravity, ratios, None))
        contact = f"{name}.contact"
        if contact in recording.data and np.any(read_signal(file, recording, contact)[_resting(time, pressure)] > 0):
            expected = "contact was detected; record free bending, or omit the threshold if that was noise"
            raise InputError(file, contact, True, expected)
        yield _Recorded(layout, samples)


def _logged(file: Path, log: Log) -> Iterator[_Recorded]:
    """The fingers of a log."""
    scenario, described = log.scenario, log.described
    parts = scenario.models, scenario.gravity, scenario.arm
    scene = add_plant(DiagramBuilder(), scenario.plant_config, *parts, visuals=False, directives=scenario.directives)
    fingers = {each.name: each for each in scene.fingers}
    if isinstance(described, BenchConfig):
        found: Iterable[tuple[PlantFinger, _Measured]]
        found = _bench_logs(file, described, fingers, np.array(scenario.gravity))
    else:
        found = [_recording_log(file, described, fingers, np.array(scenario.gravity))]
    for finger, measured in found:
        layout = _nominal(scenario, finger, file)
        if measured.readings.shape[1] != layout.readings:
            expected = f"give {layout.readings}, as many as the scenario's sensors have"
            raise InputError(file, f"readings of {finger.name}", measured.readings.shape[1], expected)
        unread = np.flatnonzero(np.isnan(measured.pressure))
        if len(unread):
            at = f"at {measured.time[unread[0]]:g} s: give a pressure"
            raise InputError(file, f"pressure of {finger.name}", np.nan, at)
        ratios = layout.response.ratio(measured.readings)
        yield _Recorded(layout, _free_bending(file, layout, measured._replace(readings=ratios)))


def _bench_logs(
    file: Path, bench: BenchConfig, fingers: Mapping[str, PlantFinger], gravity: Array
) -> Iterator[tuple[PlantFinger, _Measured]]:
    """The fingers of a log with the fields of a bench."""
    named = given(bench.time, file, "bench.time", "calibration needs the time of every row")
    table = _table(file, bench, named)
    time = table.columns([named])[:, 0]
    backward = np.flatnonzero(~(np.diff(time) > 0))
    if len(backward):
        raise InputError(file, named, float(time[backward[0] + 1]), "times must increase from row to row")
    for name, config in bench.fingers.items():
        field = f"bench.fingers.{name}"
        if name not in fingers:
            known = ", ".join(fingers)
            raise InputError(file, "bench.fingers", name, f"the scenario has no such finger; it has {known}")
        _check_one_pressure(file, f"{field}.pressures", config.pressures)
        pressure = bench.relative(table.columns(config.pressures)[:, 0])
        if bench.pressure_ambient is None:
            how = "give `pressure_ambient`, what it has in open air; if it is not, `pressure_ambient: 0`"
            check_relative(file, f"{field}.pressures", pressure, time <= time[0] + _REST, how)
        X_WB = np.tile(fingers[name].X_WB.GetAsMatrix34(), (len(time), 1, 1))
        if config.base_pose is not None:
            X_WB = table.columns(config.base_pose).reshape(-1, 3, 4)
        readings = table.columns(config.readings)
        x, z = (None, None) if config.tip is None else table.columns(config.tip).T
        tip = None if x is None else z + 1j * x
        yield fingers[name], _Measured(time, pressure, planar_gravity(X_WB, gravity), readings, tip)


def _recording_log(
    file: Path, described: RecordingConfig, fingers: Mapping[str, PlantFinger], gravity: Array
) -> tuple[PlantFinger, _Measured]:
    """The finger of a recording with described columns; its tip is the body "tip", or the mean of its markers."""
    expected = "such a recording is of one finger, and the scenario has"
    require(len(fingers) == 1, file, "fingers", len(fingers), f"{expected} {', '.join(fingers)}; or give --bench")
    (finger,) = fingers.values()
    found = read_recording(file, described)
    readings = given(found.readings, file, "readings", "name the columns of the strain sensors")
    pressures = given(found.pressures, file, "pressures", "name the column of the pressure")
    _check_one_pressure(file, "pressures.columns", described.pressures.columns if described.pressures else [])
    in_world = planar_gravity(finger.X_WB.GetAsMatrix34(), gravity)
    weight = in_world if found.gravity is None else complex(found.gravity[2], found.gravity[0])
    tip = _tip(found)
    return finger, _Measured(found.time, pressures[:, 0], np.full(len(found.time), weight), readings, tip)


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


def _check_one_pressure(file: Path, field: str, columns: list[str]) -> None:
    if len(columns) != 1:
        raise InputError(file, field, columns, "give the one pressure that bends the finger")


def _table(file: Path, bench: BenchConfig, time: str) -> Table:
    """The rows of a log."""
    names: dict[str, str] = {}
    for name, finger in bench.fingers.items():
        for field in ("readings", "pressures", "base_pose", "tip"):
            names |= dict.fromkeys(getattr(finger, field) or (), f"bench.fingers.{name}.{field}")
    return read_table(file, Columns(names, time, header=bench.fields or None, points="{marker}_{axis}"))


def _nominal(scenario: Scenario, finger: PlantFinger, file: Path) -> SensorLayout:
    """The nominal layout of a finger, before any calibration."""
    nominal = read_nominal_model(replace(scenario.nominal, calibration=None))
    layout = strain_sensors(nominal.layout(finger.finger, scenario.sensor), str(file))
    return replace(layout, finger=replace(layout.finger, name=finger.name))


def _free_bending(file: Path, layout: SensorLayout, measured: _Measured) -> FreeBending:
    """The samples of a recording, checked; its readings are extension ratios."""
    time, pressure, gravity, ratios, tip = measured
    name, rest = layout.finger.name, _resting(time, pressure)
    _check_readings(file, name, ratios)
    read = rest & np.isfinite(ratios).all(axis=1)
    _check_motion(file, name, ratios[read].reshape(-1, layout.paths, layout.sections))
    begins = rest & ~np.append(False, rest[:-1])
    hold = np.where(rest, begins.cumsum() - 1, -1)
    chosen = np.unique(np.linspace(0, len(time) - 1, min(_SAMPLES, len(time))).astype(int))
    kept = None if tip is None else tip[chosen]
    return FreeBending(time[chosen], pressure[chosen], gravity[chosen], ratios[chosen], hold[chosen], kept)


def _resting(time: Array, pressure: Array) -> NDArray[np.bool_]:
    """Samples before which the pressure has been steady for long enough, (T,)."""
    period = float(np.median(np.diff(time))) if len(time) > 1 else _REST
    return _at_rest(pressure, max(round(_REST / period), 1))


def _at_rest(pressure: Array, window: int) -> NDArray[np.bool_]:
    """Samples before which the pressure, (T,) Pa, has been steady for `window` samples."""
    rest = np.zeros(pressure.shape, dtype=bool)
    if len(pressure) > window:
        spans = np.ptp(np.lib.stride_tricks.sliding_window_view(pressure, window + 1), axis=-1)
        rest[window:] = spans <= _STEADY_PRESSURE * np.ptp(pressure)
    return rest


def _range(ratios: Array) -> float:
    """Range of the most stretched sensor, 1st to 99th percentile, extension ratio."""
    return float(_ranges(ratios).max())


def _ranges(ratios: Array) -> Array:
    low, high = np.percentile(ratios, [1, 99], axis=0)
    ranges: Array = high - low
    return ranges


def _check_readings(file: Path, name: str, ratios: Array) -> None:
    for reading, lost in enumerate(np.isnan(ratios).mean(axis=0)):
        if lost > 0.5:
            expected = f"reading {reading} is NaN in {100 * lost:.0f} % of the samples; a dead sensor has no gain"
            raise InputError(file, f"{name}.strain", np.nan, expected)


def _check_motion(file: Path, name: str, ratios: Array) -> None:
    """Checks that every section moves, of ratios (T, paths, sections)."""
    moved = _ranges(ratios).max(axis=0) if len(ratios) else np.zeros(ratios.shape[-1])
    if moved.max() < _MOTION:
        expected = f"too little motion at rest; step the pressure so that sensors stretch by at least {_MOTION:g}"
        raise InputError(file, f"{name}.strain", round(float(moved.max()), 6), expected)
    for section in np.flatnonzero(moved < _MOTION):
        expected = f"section {section} hardly moves; free bending cannot calibrate one that the pressure does not bend"
        raise InputError(file, f"{name}.strain", round(float(moved[section]), 6), expected)


def _check_fit(name: str, found: Calibration, moved: float) -> None:
    because = "something was touched, or it is a different finger"
    for gain in (found.bend_ratio, *found.gains):
        if not _LEAST_GAIN <= gain <= 1 / _LEAST_GAIN:
            expected = f"no finger differs that much from its nominal model; {because}"
            raise InputError("calibrate", f"gain or bend ratio of '{name}'", round(float(gain), 4), expected)
    if not found.residual <= _RESIDUAL * moved:
        expected = f"more than {_RESIDUAL * moved:.2g} is left; {because}"
        raise InputError("calibrate", f"residual of '{name}'", round(found.residual, 6), expected)
