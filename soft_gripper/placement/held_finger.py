"""What is taken of a recorded run: how its fingers moved, and the samples that count."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from soft_gripper.arrays import Array, Planar
from soft_gripper.errors import InputError
from soft_gripper.estimators.plane import planar_gravity
from soft_gripper.fingers.plant_finger import PlantFinger
from soft_gripper.runs.scores.poses import held_rows, held_samples
from soft_gripper.runs.scores.recorded_run import RecordedRun, read_signal
from soft_gripper.scenario.sensor_presets import sensor_layout
from soft_gripper.sensors.sensor_layout import SensorLayout, strain_sensors
from soft_gripper.truth.contact import touches

SAMPLES = 2  # of every held step, spread evenly: the finger rests, and only noise differs


@dataclass(frozen=True, eq=False)
class HeldFinger:
    """A finger of a run, T samples, of which K are held ones that count."""

    layout: SensorLayout  # as the scenario has it; a placement gives it other sections
    period: float  # s
    q: Array  # (T, N) rad
    held: NDArray[np.int_]  # (K), which of the T samples
    pressure: Array  # (T) Pa
    gravity: Planar  # (K) m/s^2, in the bending plane


def held_fingers(name: str, run: RecordedRun) -> list[HeldFinger]:
    """The fingers of a run that touch something at any held step; all, if none does.

    `name` is that of the scenario or the file.

    Raises:
        InputError: if a signal was not recorded, or the recording ends before the scenario does.
    """
    lasts, duration = float(run.recording["time"][-1]), run.scenario.duration
    if lasts < duration - 1.5 * run.scenario.sensor.period:
        raise InputError(name, "time", lasts, f"the recording ends before the steps of its scenario, {duration:g} s")
    touched = [finger for finger in run.fingers if _touches_anything(name, run, finger)]
    return [_held_finger(name, run, finger) for finger in touched or run.fingers]


def _touches_anything(name: str, run: RecordedRun, finger: PlantFinger) -> bool:
    force = read_signal(name, run.recording, f"{finger.name}.link_contact_force", finger.finger.segments + 1)
    return bool(touches(held_samples(run.scenario, run.recording, force).mean(axis=1)).any())


def _held_finger(name: str, run: RecordedRun, finger: PlantFinger) -> HeldFinger:
    scenario, recording = run.scenario, run.recording
    q = read_signal(name, recording, f"{finger.name}.sampled_joint_angles", finger.finger.segments)
    pressure = read_signal(name, recording, f"{finger.name}.sampled_pressure")
    X_WB = read_signal(name, recording, f"{finger.name}.X_WB", 3, 4)
    steps = held_rows(scenario, recording)
    chosen = np.linspace(0, steps.shape[1] - 1, min(SAMPLES, steps.shape[1])).astype(int)
    held = steps[:, chosen].ravel()
    gravity = planar_gravity(X_WB[held], np.array(scenario.gravity))
    layout = strain_sensors(sensor_layout(finger.finger, scenario.sensor), name)
    return HeldFinger(layout, scenario.sensor.period, q, held, pressure, gravity)
