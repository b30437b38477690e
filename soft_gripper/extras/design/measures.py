"""Measures of a design beyond those of a sweep: functions of a station and its recording, as a user's own measure."""

import math
from dataclasses import replace

import numpy as np

from soft_gripper.diagrams.recording import Recording
from soft_gripper.diagrams.station_parts import Station
from soft_gripper.errors import InputError
from soft_gripper.extras.grasps.strength import LOADS, Shake, direction_strength
from soft_gripper.runs.scores.grasp import last
from soft_gripper.runs.scores.recorded_grasps import objects_of
from soft_gripper.scenario.scenario_file import dump_scenario
from soft_gripper.scenario.schema import DRAKE
from soft_gripper.scenario.sensor_presets import sensor_layout


def force_error_n(station: Station, recording: Recording) -> float:
    """Mean size of the error of the estimated transverse force, N, over all fingers and the last half second.

    Samples without an estimated force, as of a moving finger, are left out; NaN if there are no others.

    Raises:
        InputError: if the estimator reports no contact force.
    """
    window = last(recording["time"].values)
    errors = []
    for finger in station.fingers:
        if f"{finger.name}.transverse_force" not in recording.data:
            expected = 'reports no contact force, for force_error_n: give "contact"'
            raise InputError("design", "estimator.type", station.scenario.estimator.type, expected)
        estimated, true = (recording[f"{finger.name}.{kind}transverse_force"].values for kind in ("", "true_"))
        errors.append(np.abs(estimated - true)[window])
    finite_errors = np.concatenate(errors)
    finite_errors = finite_errors[np.isfinite(finite_errors)]  # not every sample has the truth
    return float(finite_errors.mean()) if len(finite_errors) else math.nan


def sensors(station: Station, recording: Recording) -> int:
    """Readings of strain, curvature or orientation in all fingers."""
    return sum(sensor_layout(finger.finger, station.scenario.sensor).readings for finger in station.fingers)


def strength_n(station: Station, recording: Recording) -> float:
    """Smallest force, of six directions, that takes the object out of the grasp, N; see `extras/grasps/strength.py`.

    The loads are applied in Drake, whatever the engine of the scenario.
    """
    text = dump_scenario(replace(station.scenario, engine=DRAKE, engine_step=None))
    object_name = objects_of(station)[0]
    indices = [index for index, load in enumerate(LOADS) if not load.is_torque]
    return min(direction_strength(text, object_name, index, Shake()).strength for index in indices)


OWN = {function.__name__: f"{__name__}:{function.__name__}" for function in (force_error_n, sensors, strength_n)}
