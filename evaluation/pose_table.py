"""Pose errors of a run for several numbers of sensor sections, from ONE simulation."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from soft_gripper.arrays import Array
from soft_gripper.diagrams.pressure_steps import pressure_steps
from soft_gripper.diagrams.recording import Recording
from soft_gripper.diagrams.sensing import sensor_layout
from soft_gripper.diagrams.station import Station
from soft_gripper.evaluation.held_steps import held_samples
from soft_gripper.kinematics import forward_kinematics
from soft_gripper.metrics import fingertip_error, pose_error
from soft_gripper.sensor_layout import SensorLayout, arcs_from_readings, extension_ratios, joints_on_arcs


@dataclass(frozen=True)
class PoseRow:
    """Averages over one held step."""

    scenario: str
    finger: str
    estimator: str
    sections: int
    pressure_kpa: float
    bend_angle_deg: float
    pose_error_mm: float
    tip_error_mm: float


def pose_table(name: str, station: Station, recording: Recording, sections: Sequence[int]) -> list[PoseRow]:
    """A row for every finger, number of sections and held step, in this order.

    The sensors are read again from the recorded joint angles, by the very functions that the blocks call.
    """
    rows = []
    for finger in station.fingers:
        q = held_samples(station.scenario, recording[f"{finger.name}.sampled_joint_angles"])
        bend = np.degrees(q.sum(axis=-1).mean(axis=-1))
        pressure = pressure_steps(station.scenario, finger.name) / 1e3
        for count in sections:
            layout = replace(sensor_layout(station.scenario, finger), sections=count)
            for step in zip(pressure, bend, *_errors(layout, q), strict=True):
                rows.append(PoseRow(name, finger.name, "arcs", count, *map(float, step)))
    return rows


def _errors(layout: SensorLayout, q: Array) -> tuple[Array, Array]:
    """Pose and fingertip error, mm, (steps,), of joint angles (steps, samples, N)."""
    truth = forward_kinematics(q, layout.finger.segment_length)
    arcs = arcs_from_readings(layout, layout.response.reading(extension_ratios(layout, q)))
    pose = pose_error(truth.joints, joints_on_arcs(layout, arcs)).mean(axis=-1)
    tip = fingertip_error(truth.tip, arcs.end[..., -1]).mean(axis=-1)
    return 1e3 * pose, 1e3 * tip
