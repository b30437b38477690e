"""Recordings of free bending -> a calibration of the fingers in them.

Recordings are those of `soft-gripper run` and `play`, or logs of hardware, any file of `tables`. Their columns are the
fields of a bench (`live.bench_schema`), or those of a recording of one finger, markers included (`recording_schema`).
Where an instrument measures a force, the finger is not free. Its zero and drift are those of what it reads while it
reads no more than at the beginning. It may be late: of each hold of the pressure, what it reads last counts.
"""

from collections.abc import Collection, Iterator, Sequence
from dataclasses import asdict, replace
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from pydrake.common.yaml import yaml_dump

from soft_gripper.arrays import Array, Planar
from soft_gripper.errors import InputError
from soft_gripper.estimators.plane import planar_gravity
from soft_gripper.extras.hardware.clipping import stuck_readings
from soft_gripper.extras.hardware.finger_logs import FingerLog, Log, read_finger_logs, steady
from soft_gripper.extras.hardware.free_bending import Calibration, FreeBending, calibrate
from soft_gripper.extras.hardware.instrument import InstrumentRun, find_instrument
from soft_gripper.extras.hardware.kept_states import kept_states
from soft_gripper.extras.hardware.measured import Measured, latest
from soft_gripper.extras.hardware.recorded_run import load_run, read_signal
from soft_gripper.files.output import atomic_file
from soft_gripper.fingers.plant_finger import PlantFinger
from soft_gripper.fingers.statics import FacePress
from soft_gripper.scenario.calibration_file import CalibrationConfig, FingerCalibrationConfig, layout_identity
from soft_gripper.scenario.nominal_model import read_nominal_model
from soft_gripper.scenario.schema import Scenario
from soft_gripper.sensors.sensor_layout import SensorLayout, strain_sensors

ASSUMED = "gains are 1 within 5 %, the shape of the response is right, and the finger's own weight is its only load"
_REST = 0.3  # s of constant pressure, after which a finger is assumed to be at rest
_STEADY_PRESSURE = 0.02  # share of the pressure range; allowed variation in that time
_SAMPLES, _PRESSED_SAMPLES = 3000, 800  # used per recording, spread evenly: of a free finger, and a pressed one
_LEAST_FORCE = 0.05  # N, beyond which a measured force is a contact; scales drift by less in some minutes
_MOTION = 0.01  # extension ratio: smallest range of the most stretched sensor
_LEAST_GAIN = 0.5  # or its inverse; values further from 1 are rejected as errors
_RESIDUAL = 0.05  # share of that range; larger residuals indicate contact or a different finger


class _Measured(NamedTuple):
    """Measurements of a finger, T samples."""

    time: Array  # (T) s
    pressure: Array  # (T) Pa
    gravity: Planar  # (T) see FreeBending
    ratios: Array  # (T, R) extension ratios
    tip: Planar | None = None  # (T) m
    press: FacePress | None = None  # (T) what an instrument measures; 0 N if nothing, NaN if it is not known


class _Recorded(NamedTuple):
    """A recording of one finger: the nominal layout, and what was measured."""

    layout: SensorLayout
    samples: FreeBending


def calibrate_recordings(
    files: Sequence[Path], log: Log | None = None, sought: Collection[str] = ()
) -> CalibrationConfig:
    """Fits gains, offsets, hysteresis, drift and the bend per pressure of each finger to all recordings together.

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
    declared = None if log is None else log.scenario.estimator.uncertainty.friction
    friction = {} if declared is None else {"friction": declared}
    for name, layout in layouts.items():
        calibration = calibrate(layout, recorded[name], sought, **friction)
        at_rest = np.concatenate([each.ratios[each.hold >= 0] for each in recorded[name]])
        _check_fit(name, calibration, _range(at_rest[np.isfinite(at_rest).all(axis=1)]))
        doubtful = [f"{files[number].name} at {time:.1f} s" for number, time in calibration.doubtful]
        fingers[name] = as_config(layout, calibration, doubtful)
    return CalibrationConfig(ASSUMED, fingers)


def as_config(layout: SensorLayout, found: Calibration, doubtful: Sequence[str] = ()) -> FingerCalibrationConfig:
    """Entry of the file for the calibration of a finger with that nominal layout.

    `doubtful` are holds that do not fit, in words.
    """
    found_of_readings = "gains", "offsets", "gain_stds", "offset_stds", "drifts"
    length, spacing, one_sided, sections = layout_identity(layout)
    lists = {name: getattr(found, name).tolist() for name in found_of_readings}
    single = {
        name: getattr(found, name)
        for name in (
            *("bend_ratio", "residual", "bend_ratio_std", "hysteresis", "tip_measured"),
            *("response_curvature", "response_curvature_std", "pressure_offset", "pressure_offset_std"),
            *("bend_variation", "bend_variation_std", "strength", "strength_std", "friction", "bend_gain_std"),
        )
    }
    found_before = {**lists, **single}
    config = FingerCalibrationConfig(length, spacing, one_sided, sections, **found_before, doubtful=list(doubtful))
    if found.states is not None:
        readings = [f"{path} {section}" for path in layout.path_names for section in range(layout.sections)]
        names = [*readings, "drive [N m]", "gravity x [m/s^2]", "gravity z [m/s^2]"]
        states = found.states
        config.fitted = kept_states(names, states.fitted, states.widths, states.noise, states.disagreement)
    return config


def save_calibration(calibration: CalibrationConfig, path: Path) -> None:
    """Writes a calibration."""
    with atomic_file(path) as partial:
        partial.write_text(yaml_dump(asdict(calibration)), encoding="utf-8")


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
        samples = _free_bending(file, layout, _Measured(time, pressure, gravity, ratios))
        contact = f"{name}.contact"
        if contact in recording.data and np.any(read_signal(file, recording, contact)[_resting(time, pressure)] > 0):
            expected = "contact was detected; record free bending, or omit the threshold if that was noise"
            raise InputError(file, contact, True, expected)
        yield _Recorded(layout, samples)


def _logged(file: Path, log: Log) -> Iterator[_Recorded]:
    """The fingers of a log."""
    logs = read_finger_logs(file, log)
    for each, press in zip(logs, _presses(logs), strict=True):
        layout = _nominal(log.scenario, each.finger, file)
        gravity = planar_gravity(each.X_WB, each.gravity)
        ratios = layout.response.ratio(each.readings)
        measured = _Measured(each.time, each.pressure, gravity, ratios, each.tip, press)
        yield _Recorded(layout, _free_bending(file, layout, measured))


def _presses(logs: Sequence[FingerLog]) -> list[FacePress | None]:
    """What instruments measure of forces in the runs of a file, without their zeros and drift."""
    forces = [log.measured.get("force") for log in logs]
    runs = [_run(log, force) for log, force in zip(logs, forces, strict=True) if force is not None]
    scale = find_instrument(runs, _LEAST_FORCE, most_delay=0.0) if runs else None
    corrected = iter([scale.corrected(i, run) for i, run in enumerate(runs)] if scale else [])
    return [
        None if force is None else _press(log, next(corrected), force) for log, force in zip(logs, forces, strict=True)
    ]


def _run(log: FingerLog, force: Measured) -> InstrumentRun:
    """What an instrument reads, beside what it reads more than at the beginning."""
    value = latest(log.time, force.value)
    begins = value[(log.time <= log.time[0] + _REST) & np.isfinite(value)]
    zero = float(np.median(begins)) if len(begins) else 0.0
    return InstrumentRun(log.time, value, value - zero, _resting(log.time, log.pressure))


def _press(log: FingerLog, force: Array, measured: Measured) -> FacePress:
    """A force at its place; NaN where it presses at an unknown one."""
    place = latest(log.time, measured.place)
    pressing = np.where(np.abs(force) <= _LEAST_FORCE, 0.0, force + 0 * place)
    axis = None if measured.along is None else complex(measured.along[1], measured.along[0])
    return FacePress(pressing, np.nan_to_num(place), None if axis is None else axis / abs(axis))


def _nominal(scenario: Scenario, finger: PlantFinger, file: Path) -> SensorLayout:
    """The nominal layout of a finger, before any calibration."""
    nominal = read_nominal_model(replace(scenario.nominal, calibration=None))
    layout = strain_sensors(nominal.layout(finger.finger, scenario.sensor), str(file))
    return replace(layout, finger=replace(layout.finger, name=finger.name))


def _free_bending(file: Path, layout: SensorLayout, measured: _Measured) -> FreeBending:
    """The samples of a recording, checked."""
    time, pressure, gravity, ratios, tip, press = measured
    name, rest = layout.finger.name, _resting(time, pressure)
    if press is not None:
        rest = _last_steady(rest, press.force, time)
    _check_readings(file, name, ratios, pressure)
    read = rest & np.isfinite(ratios).all(axis=1)
    _check_motion(file, name, ratios[read].reshape(-1, layout.paths, layout.sections))
    begins = rest & ~np.append(False, rest[:-1])
    hold = np.where(rest, begins.cumsum() - 1, -1)
    if press is not None and not np.nan_to_num(press.force).any():
        press = None
    most = _SAMPLES if press is None else _PRESSED_SAMPLES
    chosen = np.unique(np.linspace(0, len(time) - 1, min(most, len(time))).astype(int))
    kept = None if tip is None else tip[chosen]
    if press is not None:
        press = press._replace(force=np.nan_to_num(press.force[chosen]), place=press.place[chosen])
    return FreeBending(time[chosen], pressure[chosen], gravity[chosen], ratios[chosen], hold[chosen], kept, press)


def _resting(time: Array, pressure: Array) -> NDArray[np.bool_]:
    """Samples before which the pressure has been steady for long enough, (T,)."""
    return steady(pressure, _rest_samples(time), _STEADY_PRESSURE * float(np.ptp(pressure)))


def _rest_samples(time: Array) -> int:
    return round(_REST / float(np.median(np.diff(time)))) if len(time) > 1 else 1


def _last_steady(rest: NDArray[np.bool_], force: Array, time: Array) -> NDArray[np.bool_]:
    """The samples of every stretch of rest in which the force has become steady, to its end, (T,)."""
    is_steady = rest & steady(force, _rest_samples(time), _LEAST_FORCE / 2)
    moves = np.flatnonzero(rest & ~is_steady)
    stretch = (rest & ~np.append(False, rest[:-1])).cumsum()
    last = np.full(stretch.max() + 1, -1)
    last[stretch[moves]] = moves  # the last of each counts
    found: NDArray[np.bool_] = is_steady & (np.arange(len(rest)) > last[stretch])
    return found


def _range(ratios: Array) -> float:
    """Range of the most stretched sensor, 1st to 99th percentile, extension ratio."""
    return float(_ranges(ratios).max())


def _ranges(ratios: Array) -> Array:
    low, high = np.percentile(ratios, [1, 99], axis=0)
    ranges: Array = high - low
    return ranges


def _check_readings(file: Path, name: str, ratios: Array, pressure: Array) -> None:
    for reading, lost in enumerate(np.isnan(ratios).mean(axis=0)):
        if lost > 0.5:
            expected = f"reading {reading} is NaN in {100 * lost:.0f} % of the samples; a dead sensor has no gain"
            raise InputError(file, f"{name}.strain", np.nan, expected)
    readings = {f"reading {i}": ratio for i, ratio in enumerate(ratios.T)}
    for stuck in stuck_readings(readings, {"pressure": pressure}):
        expected = f"{stuck.name} {stuck.question} Its gain would be wrong: leave those samples empty, or move it less"
        raise InputError(file, f"{name}.strain", round(stuck.value, 6), expected)


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
            raise InputError("calibrate", f"gain or bend per pressure of '{name}'", round(float(gain), 4), expected)
    if not found.residual <= _RESIDUAL * moved:
        expected = f"more than {_RESIDUAL * moved:.2g} is left; {because}"
        raise InputError("calibrate", f"residual of '{name}'", round(found.residual, 6), expected)
