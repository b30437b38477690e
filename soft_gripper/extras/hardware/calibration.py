"""Calibrates fingers from recordings of free bending: files -> gains, offsets and a bend per pressure for each finger.

Recordings are those of `soft-gripper run` and `play`, or logs of hardware (`table_files`). Their columns are the
fields of a bench (`live.bench_schema`), or those of a recording of one finger, markers included (`recording_schema`).
Where an instrument measures a force, the finger is not free. Zero and drift of the instrument follow from readings
that are no larger than at the beginning. It may be late: of each hold of the pressure, its last readings count.
"""

from collections.abc import Collection, Iterator, Sequence
from dataclasses import asdict, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from pydrake.common.yaml import yaml_dump

from soft_gripper.arrays import Array, Planar
from soft_gripper.errors import InputError
from soft_gripper.estimators.plane import planar_gravity
from soft_gripper.extras.hardware.clipping import stuck_readings
from soft_gripper.extras.hardware.finger_logs import FingerLog, Log, load_run, read_finger_logs, read_signal, steady
from soft_gripper.extras.hardware.fitted_range import kept_states
from soft_gripper.extras.hardware.free_bending import Calibration, FreeBending, calibrate
from soft_gripper.extras.hardware.instrument import InstrumentRun, find_instrument
from soft_gripper.extras.hardware.measured import Measured, latest
from soft_gripper.files.output import atomic_file
from soft_gripper.fingers.plant_finger import PlantFinger
from soft_gripper.fingers.statics import FacePress
from soft_gripper.scenario.calibration_file import CalibrationConfig, FingerCalibrationConfig, layout_identity
from soft_gripper.scenario.nominal_model import read_nominal_model
from soft_gripper.scenario.schema import Scenario
from soft_gripper.sensors.sensor_layout import SensorLayout, strain_sensors

ASSUMED = "gains are 1 within 5 %, the shape of the response is right, and the finger's own weight is its only load"
_REST_TIME = 0.3  # s of constant pressure until a finger is assumed to be at rest
_STEADY_PRESSURE_SHARE = 0.02  # share of the pressure range; allowed variation in that time
_MAX_SAMPLES, _MAX_PRESSED_SAMPLES = 3000, 800  # used per recording, spread evenly: of a free finger, and a pressed one
_MIN_CONTACT_FORCE = 0.05  # N; a larger measured force is a contact; scales drift by less in some minutes
_MIN_RANGE = 0.01  # extension ratio: smallest range of the most stretched sensor
_MIN_GAIN = 0.5  # or its inverse; values further from 1 are rejected as errors
_MAX_RESIDUAL_SHARE = 0.05  # share of that range; larger residuals indicate contact or a different finger


def calibrate_recordings(
    files: Sequence[Path], log: Log | None = None, sought: Collection[str] = ()
) -> CalibrationConfig:
    """Fits gains, offsets, hysteresis, drift and the bend per pressure of each finger to all recordings together.

    The fit starts from the nominal models of the recordings, without the calibrations loaded in them.

    Args:
        files: recordings of this project, unless `log` says how to read them.
        log: of other recordings.
        sought: names of further parameters to fit, see `free_bending.SOUGHT`.

    Raises:
        InputError: if the recordings cannot be read, are of different fingers, or do not show free bending.
    """
    layouts: dict[str, SensorLayout] = {}
    samples_by_finger: dict[str, list[FreeBending]] = {}
    for file in files:
        for layout, recording in _run_recordings(file) if log is None else _log_recordings(file, log):
            name = layout.finger.name
            if layouts.setdefault(name, layout) != layout:
                raise InputError(file, "finger", name, f"finger or sensors differ from those in {files[0]}")
            samples_by_finger.setdefault(name, []).append(recording)
    fingers = {}
    declared = None if log is None else log.scenario.estimator.uncertainty.friction
    friction = {} if declared is None else {"friction": declared}
    for name, layout in layouts.items():
        calibration = calibrate(layout, samples_by_finger[name], sought, **friction)
        ratios = np.concatenate([samples.ratios[samples.hold >= 0] for samples in samples_by_finger[name]])
        complete_ratios = ratios[np.isfinite(ratios).all(axis=1)]
        _check_fit(name, calibration, float(_strain_ranges(complete_ratios).max()))
        doubtful = [f"{files[file_number].name} at {time:.1f} s" for file_number, time in calibration.doubtful]
        fingers[name] = as_config(layout, calibration, doubtful)
    return CalibrationConfig(ASSUMED, fingers)


def as_config(layout: SensorLayout, calibration: Calibration, doubtful: Sequence[str] = ()) -> FingerCalibrationConfig:
    """Entry of the file for the calibration of a finger with that nominal layout.

    `doubtful` are holds that do not fit, in words.
    """
    length, spacing, one_sided, sections = layout_identity(layout)
    numbers = {name: value for name, value in calibration._asdict().items() if name not in ("doubtful", "states")}
    numbers = {name: value.tolist() if isinstance(value, np.ndarray) else value for name, value in numbers.items()}
    config = FingerCalibrationConfig(length, spacing, one_sided, sections, **numbers, doubtful=list(doubtful))
    if calibration.states is not None:
        readings = [f"{path} {section}" for path in layout.path_names for section in range(layout.sections)]
        names = [*readings, "drive [N m]", "gravity x [m/s^2]", "gravity z [m/s^2]"]
        states = calibration.states
        config.fitted = kept_states(names, states.fitted, states.widths, states.noise, states.disagreement)
    return config


def save_calibration(calibration: CalibrationConfig, path: Path) -> None:
    """Writes a calibration."""
    with atomic_file(path) as partial:
        partial.write_text(yaml_dump(asdict(calibration)), encoding="utf-8")


def _run_recordings(file: Path) -> Iterator[tuple[SensorLayout, FreeBending]]:
    """Yields the nominal layout and the samples of each finger of a recording of this project."""
    recording, scenario, fingers = load_run(file)
    for finger in fingers:
        layout, name = _nominal_layout(scenario, finger, file), finger.name
        pressure = read_signal(file, recording, f"{name}.sampled_pressure")
        strain = read_signal(file, recording, f"{name}.strain", layout.paths, layout.sections, allow_nan=True)
        X_WB = read_signal(file, recording, f"{name}.X_WB", 3, 4)
        time = scenario.sensor.period * np.arange(len(pressure))
        ratios = layout.response.ratio(strain.reshape(len(strain), layout.readings))
        gravity = planar_gravity(X_WB, np.array(scenario.gravity))
        samples = _free_bending(file, layout, time, pressure, gravity, ratios)
        contact = f"{name}.contact"
        if contact in recording.data and np.any(read_signal(file, recording, contact)[_is_resting(time, pressure)] > 0):
            expected = "contact was detected; record free bending, or omit the threshold if that was noise"
            raise InputError(file, contact, True, expected)
        yield layout, samples


def _log_recordings(file: Path, log: Log) -> Iterator[tuple[SensorLayout, FreeBending]]:
    """Yields the nominal layout and the samples of each finger of a log."""
    logs = read_finger_logs(file, log)
    for finger_log, press in zip(logs, _presses(logs), strict=True):
        layout = _nominal_layout(log.scenario, finger_log.finger, file)
        gravity = planar_gravity(finger_log.X_WB, finger_log.gravity)
        ratios = layout.response.ratio(finger_log.readings)
        measured = finger_log.time, finger_log.pressure, gravity, ratios, finger_log.tip, press
        yield layout, _free_bending(file, layout, *measured)


def _presses(logs: Sequence[FingerLog]) -> list[FacePress | None]:
    """Measured forces in the runs of a file, without zero and drift of the instrument."""
    measured = [(i, log.measured["force"]) for i, log in enumerate(logs) if "force" in log.measured]
    runs = [_instrument_run(logs[i], force) for i, force in measured]
    presses: list[FacePress | None] = [None] * len(logs)
    scale = find_instrument(runs, _MIN_CONTACT_FORCE, max_delay=0.0) if runs else None
    for number, (i, force) in enumerate(measured):
        assert scale is not None
        presses[i] = _to_press(logs[i], scale.corrected(number, runs[number]), force)
    return presses


def _instrument_run(log: FingerLog, force: Measured) -> InstrumentRun:
    """Readings of an instrument, and their excess over the beginning as an estimate."""
    value = latest(log.time, force.value)
    first_values = value[(log.time <= log.time[0] + _REST_TIME) & np.isfinite(value)]
    zero = float(np.median(first_values)) if len(first_values) else 0.0
    return InstrumentRun(log.time, value, value - zero, _is_resting(log.time, log.pressure))


def _to_press(log: FingerLog, force: Array, measured: Measured) -> FacePress:
    """Force on the finger's face, N, and its location; NaN where the location is unknown."""
    place = latest(log.time, measured.place)
    contact_force = np.where(np.abs(force) <= _MIN_CONTACT_FORCE, 0.0, force + 0 * place)
    axis = None if measured.along is None else complex(measured.along[1], measured.along[0])
    return FacePress(contact_force, np.nan_to_num(place), None if axis is None else axis / abs(axis))


def _nominal_layout(scenario: Scenario, finger: PlantFinger, file: Path) -> SensorLayout:
    """The nominal layout of a finger, before any calibration."""
    nominal = read_nominal_model(replace(scenario.nominal, calibration=None))
    layout = strain_sensors(nominal.layout(finger.finger, scenario.sensor), str(file))
    return replace(layout, finger=replace(layout.finger, name=finger.name))


def _free_bending(
    file: Path,
    layout: SensorLayout,
    time: Array,
    pressure: Array,
    gravity: Planar,
    ratios: Array,
    tip: Planar | None = None,
    press: FacePress | None = None,
) -> FreeBending:
    """Checks the samples of a recording and thins them out; forces of the press are NaN where they are unknown."""
    name, is_resting = layout.finger.name, _is_resting(time, pressure)
    if press is not None:
        is_resting = _steady_ends(is_resting, press.force, time)
    _check_readings(file, name, ratios, pressure)
    has_readings = is_resting & np.isfinite(ratios).all(axis=1)
    _check_motion(file, name, ratios[has_readings].reshape(-1, layout.paths, layout.sections))
    begins = is_resting & ~np.append(False, is_resting[:-1])
    hold = np.where(is_resting, begins.cumsum() - 1, -1)
    if press is not None and not np.nan_to_num(press.force).any():
        press = None
    max_samples = _MAX_SAMPLES if press is None else _MAX_PRESSED_SAMPLES
    rows = np.unique(np.linspace(0, len(time) - 1, min(max_samples, len(time))).astype(int))
    tips = None if tip is None else tip[rows]
    if press is not None:
        press = press._replace(force=np.nan_to_num(press.force[rows]), place=press.place[rows])
    return FreeBending(time[rows], pressure[rows], gravity[rows], ratios[rows], hold[rows], tips, press)


def _is_resting(time: Array, pressure: Array) -> NDArray[np.bool_]:
    """Mask of the samples before which the pressure was steady for long enough, (T,)."""
    return steady(pressure, _rest_samples(time), _STEADY_PRESSURE_SHARE * float(np.ptp(pressure)))


def _rest_samples(time: Array) -> int:
    return round(_REST_TIME / float(np.median(np.diff(time)))) if len(time) > 1 else 1


def _steady_ends(is_resting: NDArray[np.bool_], force: Array, time: Array) -> NDArray[np.bool_]:
    """Mask of the end of every stretch of rest, from where the force is steady, (T,)."""
    is_steady = is_resting & steady(force, _rest_samples(time), _MIN_CONTACT_FORCE / 2)
    move_starts = np.flatnonzero(is_resting & ~is_steady)
    stretch = (is_resting & ~np.append(False, is_resting[:-1])).cumsum()
    last_rows = np.full(stretch.max() + 1, -1)
    last_rows[stretch[move_starts]] = move_starts  # the last of each counts
    return is_steady & (np.arange(len(is_resting)) > last_rows[stretch])


def _strain_ranges(ratios: Array) -> Array:
    """Ranges of the sensors, 1st to 99th percentile, as extension ratios."""
    low_ratios, high_ratios = np.percentile(ratios, [1, 99], axis=0)
    return high_ratios - low_ratios


def _check_readings(file: Path, name: str, ratios: Array, pressure: Array) -> None:
    for reading, lost_share in enumerate(np.isnan(ratios).mean(axis=0)):
        if lost_share > 0.5:
            expected = f"reading {reading} is NaN in {100 * lost_share:.0f} % of the samples; a dead sensor has no gain"
            raise InputError(file, f"{name}.strain", np.nan, expected)
    readings = {f"reading {i}": ratio for i, ratio in enumerate(ratios.T)}
    for stuck in stuck_readings(readings, {"pressure": pressure}):
        expected = f"{stuck.name} {stuck.question} Its gain would be wrong: leave those samples empty, or move it less"
        raise InputError(file, f"{name}.strain", round(stuck.value, 6), expected)


def _check_motion(file: Path, name: str, ratios: Array) -> None:
    """Checks that every section moves, of ratios (T, paths, sections)."""
    ranges = _strain_ranges(ratios).max(axis=0) if len(ratios) else np.zeros(ratios.shape[-1])
    if ranges.max() < _MIN_RANGE:
        expected = f"too little motion at rest; step the pressure so that sensors stretch by at least {_MIN_RANGE:g}"
        raise InputError(file, f"{name}.strain", round(float(ranges.max()), 6), expected)
    for section in np.flatnonzero(ranges < _MIN_RANGE):
        expected = f"section {section} hardly moves; free bending cannot calibrate one that the pressure does not bend"
        raise InputError(file, f"{name}.strain", round(float(ranges[section]), 6), expected)


def _check_fit(name: str, calibration: Calibration, strain_range: float) -> None:
    cause_text = "something was touched, or it is a different finger"
    for gain in (calibration.bend_ratio, *calibration.gains):
        if not _MIN_GAIN <= gain <= 1 / _MIN_GAIN:
            expected = f"no finger differs that much from its nominal model; {cause_text}"
            raise InputError("calibrate", f"gain or bend per pressure of '{name}'", round(float(gain), 4), expected)
    if not calibration.residual <= _MAX_RESIDUAL_SHARE * strain_range:
        expected = f"is more than {_MAX_RESIDUAL_SHARE * strain_range:.2g}; {cause_text}"
        raise InputError("calibrate", f"residual of '{name}'", round(calibration.residual, 6), expected)
