"""Recordings of free bending -> a calibration of the fingers in them."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from soft_gripper.arrays import Array
from soft_gripper.diagrams.recording import Recording
from soft_gripper.errors import InputError
from soft_gripper.estimators.calibration import Calibration, FreeBending, calibrate
from soft_gripper.estimators.plane import planar_gravity
from soft_gripper.runs.scores.recorded_run import load_run, read_signal
from soft_gripper.scenario.calibration_file import CalibrationConfig, as_config
from soft_gripper.scenario.nominal_model import read_nominal_model
from soft_gripper.scenario.schema import Scenario
from soft_gripper.sensors.sensor_layout import SensorLayout, strain_sensors

ASSUMED = "the mean gain of the sensors of a finger is 1, and its own weight is the only load"
_REST = 0.3  # s of constant pressure, after which a finger is assumed to be at rest
_STEADY = 0.02  # share of the pressure range; allowed variation in that time
_SAMPLES = 300  # number of samples used per recording, spread evenly over those at rest
_MOTION = 0.01  # extension ratio: smallest range of the most stretched sensor
_LEAST_GAIN = 0.5  # or its inverse; values further from 1 are rejected as errors
_RESIDUAL = 0.05  # share of that range; larger residuals indicate contact or a different finger


def calibrate_recordings(files: Sequence[Path]) -> CalibrationConfig:
    """Fits gains, offsets and the bend ratio of each finger to all recordings together.

    The fit starts from the nominal models of the recordings, without the calibrations loaded in them.

    Raises:
        InputError: if the recordings cannot be read, are of different fingers, or do not show free bending.
    """
    layouts: dict[str, SensorLayout] = {}
    samples: dict[str, list[FreeBending]] = {}
    for file in files:
        for layout, found in _free_bending(file):
            name = layout.finger.name
            if layouts.setdefault(name, layout) != layout:
                raise InputError(file, "finger", name, f"finger or sensors differ from those in {files[0]}")
            samples.setdefault(name, []).append(found)
    fingers = {}
    for name, layout in layouts.items():
        together = FreeBending(*map(np.concatenate, zip(*samples[name], strict=True)))
        calibration = calibrate(layout, together)
        _check_fit(name, calibration, _range(together.ratios))
        fingers[name] = as_config(layout, calibration)
    return CalibrationConfig(ASSUMED, fingers)


def _free_bending(file: Path) -> list[tuple[SensorLayout, FreeBending]]:
    """The nominal layout of each finger of a recording, and its samples at rest."""
    recording, scenario, fingers = load_run(file)
    nominal = read_nominal_model(replace(scenario.nominal, calibration=None))
    found = []
    for finger in fingers:
        layout = strain_sensors(nominal.layout(finger.finger, scenario.sensor), str(file))
        layout = replace(layout, finger=replace(layout.finger, name=finger.name))
        found.append((layout, _samples(file, recording, scenario, layout)))
    return found


def _samples(file: Path, recording: Recording, scenario: Scenario, layout: SensorLayout) -> FreeBending:
    name = layout.finger.name
    pressure = read_signal(file, recording, f"{name}.sampled_pressure")
    strain = read_signal(file, recording, f"{name}.strain", layout.paths, layout.sections, allow_nan=True)
    X_WB = read_signal(file, recording, f"{name}.X_WB", 3, 4)
    ratios = layout.response.ratio(strain.reshape(len(strain), layout.readings))
    _check_readings(file, name, ratios)
    rest = _at_rest(pressure, round(_REST / scenario.sensor.period)) & np.isfinite(ratios).all(axis=1)
    _check_motion(file, name, ratios[rest].reshape(-1, layout.paths, layout.sections))
    contact = f"{name}.contact"
    if contact in recording.data and np.any(read_signal(file, recording, contact)[rest] > 0):
        expected = "contact was detected; record free bending, or omit the threshold if that was noise"
        raise InputError(file, contact, True, expected)
    chosen = np.flatnonzero(rest)
    chosen = chosen[np.linspace(0, len(chosen) - 1, min(_SAMPLES, len(chosen))).astype(int)]
    gravity = planar_gravity(X_WB[chosen], np.array(scenario.gravity))
    return FreeBending(pressure[chosen], gravity, ratios[chosen])


def _at_rest(pressure: Array, window: int) -> NDArray[np.bool_]:
    """Samples before which the pressure, (T,) Pa, has been steady for `window` samples."""
    rest = np.zeros(pressure.shape, dtype=bool)
    if len(pressure) > window:
        spans = np.ptp(np.lib.stride_tricks.sliding_window_view(pressure, window + 1), axis=-1)
        rest[window:] = spans <= _STEADY * np.ptp(pressure)
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
