"""Reads a recording of this project: a file -> its signals, scenario and fingers."""

from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np
from pydrake.systems.framework import DiagramBuilder

from soft_gripper.arrays import Array
from soft_gripper.diagrams.recording import Recording
from soft_gripper.diagrams.scene import add_plant
from soft_gripper.errors import InputError
from soft_gripper.fingers.plant_finger import PlantFinger
from soft_gripper.scenario.scenario_file import parse_scenario
from soft_gripper.scenario.schema import Scenario

_MAX_SIZE = 1e9  # largest absolute value of any signal, in SI units


class RecordedRun(NamedTuple):
    """A recording, with its station and fingers."""

    recording: Recording
    scenario: Scenario
    fingers: Sequence[PlantFinger]


def load_run(file: Path) -> RecordedRun:
    """Reads a recording written by `soft-gripper run` or `play`.

    Raises:
        InputError: if the file is not a recording, has missing samples, or contains no finger.
    """
    recording = Recording.load(file)
    text = recording.data.attrs.get("scenario")
    if not isinstance(text, str):
        raise InputError(file, "scenario", text, "is not a recording of a scenario: it has no such attribute")
    scenario = parse_scenario(file, text)
    _check_time(file, recording, scenario.sensor.period)
    scene = add_plant(DiagramBuilder(), scenario, visuals=False)
    if not scene.fingers:
        raise InputError(file, "fingers", [], "there is no finger in the recording")
    return RecordedRun(recording, scenario, scene.fingers)


def _check_time(file: Path, recording: Recording, period: float) -> None:
    """Checks that samples are a period apart, because they are addressed by index."""
    time = recording.data.get("time")
    if time is None or time.dims != ("time",) or time.dtype.kind != "f" or not len(time):
        variable = None if time is None else f"{time.dtype} {time.dims}"
        raise InputError(file, "time", variable, "give the time of every sample, s")
    steps = np.diff(time.values, prepend=-period)
    wrong = np.flatnonzero(~((steps > 0) & (steps < 2 * period)))
    if len(wrong):
        value, expected = float(time[wrong[0]]), f"times must start at 0 s and increase by {period:g} s"
        raise InputError(file, f"time[{wrong[0]}]", value, expected)


def read_signal(file: object, recording: Recording, name: str, *shape: int, allow_nan: bool = False) -> Array:
    """A signal of the recording in `file`, (T, *shape).

    With `allow_nan`, samples may be NaN, as from a sensor with dropouts.

    Raises:
        InputError: if it was not recorded, or has another shape or type.
    """
    if name not in recording.data:
        raise InputError(file, "signal", name, "is not in the recording")
    values: Array = recording[name].values
    expected = (recording.data.sizes["time"], *shape)
    if values.shape != expected or values.dtype.kind != "f":
        raise InputError(
            file, name, f"{values.dtype} {values.shape}", f"give floating-point numbers of shape {expected}"
        )
    wrong = values[~((np.abs(values) < _MAX_SIZE) | (allow_nan & np.isnan(values)))]
    if len(wrong):
        raise InputError(file, name, float(wrong[0]), f"give finite numbers with absolute values below {_MAX_SIZE:g}")
    return values
