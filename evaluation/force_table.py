"""External torques of a run, estimated and true, for several numbers of sensor sections."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from soft_gripper.diagrams.pressure_steps import pressure_steps
from soft_gripper.diagrams.recording import Recording
from soft_gripper.diagrams.sensing import bending_plane_gravity, sensor_layout
from soft_gripper.diagrams.station import Station
from soft_gripper.evaluation.held_steps import held_samples
from soft_gripper.external_torque import external_torque
from soft_gripper.sensor_layout import arcs_from_readings, extension_ratios


@dataclass(frozen=True)
class ForceRow:
    """Averages over one held step at one joint, counted from the base."""

    scenario: str
    finger: str
    sections: int
    pressure_kpa: float
    joint: int
    estimated_nm: float
    true_nm: float


def force_table(name: str, station: Station, recording: Recording, sections: Sequence[int]) -> list[ForceRow]:
    """A row for every finger, number of sections, held step and joint, in this order."""
    rows = []
    for finger in station.fingers:
        signals = ("sampled_joint_angles", "sampled_pressure", "true_external_torque")
        q, pressure, truth = (
            held_samples(station.scenario, recording[f"{finger.name}.{signal}"]) for signal in signals
        )
        steps = pressure_steps(station.scenario, finger.name) / 1e3
        gravity = bending_plane_gravity(station.scenario, finger)
        for count in sections:
            layout = replace(sensor_layout(station.scenario, finger), sections=count)
            readings = layout.response.reading(extension_ratios(layout, q))
            theta = arcs_from_readings(layout, readings).theta
            estimate = external_torque(layout, theta, pressure, gravity).mean(axis=1)
            for (step, joint), torque in np.ndenumerate(estimate):
                true = float(truth[step, :, joint].mean())
                rows.append(ForceRow(name, finger.name, count, float(steps[step]), joint, float(torque), true))
    return rows
