"""What a sweep measures of a run, by the kind of its scenario."""

from dataclasses import asdict, dataclass

import numpy as np

from soft_gripper.diagrams.recording.recording import Recording
from soft_gripper.diagrams.station_parts import Station
from soft_gripper.runs.scores.phases import outcome
from soft_gripper.runs.scores.poses import held_samples, recorded_pose_table
from soft_gripper.runs.scores.steps import step_table
from soft_gripper.runs.trials.trial import Judged, judged
from soft_gripper.scenario.scenario import Scenario


@dataclass(frozen=True)
class OpenLoop:
    """Steps of pressure, over all held steps and fingers; the torque is the external one at the base joint."""

    mean_pose_error_mm: float
    max_pose_error_mm: float
    mean_tip_error_mm: float
    max_tip_error_mm: float
    mean_torque_error_mnm: float
    largest_bend_deg: float
    peak_contact_force_n: float


@dataclass(frozen=True)
class ClosedLoop:
    """Steps of the opening, over all of them; NaN for the settling time if one does not settle."""

    mean_settling_s: float
    max_overshoot_percent: float
    mean_steady_error_true_mm: float
    mean_steady_error_estimated_mm: float
    crossings: int


@dataclass(frozen=True)
class Task:
    """A task: how it ended as estimated, and when."""

    outcome: str
    duration_s: float


@dataclass(frozen=True)
class JudgedTask(Judged, Task):
    """A task that holds an object and looks for contact: what became of it in truth, too."""


Measures = OpenLoop | ClosedLoop | Task


def kind_of(scenario: Scenario) -> type[Measures]:
    """What is measured of a scenario."""
    if scenario.task is not None:
        looks = scenario.estimator.contact_threshold is not None
        return JudgedTask if looks and any(phase.holds for phase in scenario.task.phases) else Task
    return OpenLoop if scenario.control.set_points is None else ClosedLoop


def measure(station: Station, recording: Recording) -> Measures:
    """What is measured of a run."""
    kind = kind_of(station.scenario)
    if kind is OpenLoop:
        return _open_loop(station, recording)
    if kind is ClosedLoop:
        return _closed_loop(station, recording)
    end = outcome(recording).words
    if kind is Task:
        return Task(end, float(recording["time"].values[-1]))
    return JudgedTask(end, **asdict(judged(station, recording)))


def _open_loop(station: Station, recording: Recording) -> OpenLoop:
    rows = recorded_pose_table("", station, recording)
    poses, tips = np.array([row.pose_error_mm for row in rows]), np.array([row.tip_error_mm for row in rows])
    torques = [
        [
            held_samples(station.scenario, recording, f"{finger.name}.{signal}")[..., 0].mean(axis=-1)
            for signal in ("external_torque", "true_external_torque")
        ]
        for finger in station.fingers
    ]
    torque_errors = 1e3 * np.abs(np.array(torques)[:, 0] - np.array(torques)[:, 1])
    contact = max(float(recording[f"{finger.name}.true_contact_total"].max()) for finger in station.fingers)
    bend = max(abs(row.bend_angle_deg) for row in rows)
    errors = [poses.mean(), poses.max(), tips.mean(), tips.max(), torque_errors.mean()]
    return OpenLoop(*map(float, [*errors, bend, contact]))


def _closed_loop(station: Station, recording: Recording) -> ClosedLoop:
    rows = step_table(station, recording)
    true, estimated = (
        float(np.mean([abs(getattr(row, f"steady_error_{kind}_mm")) for row in rows])) for kind in ("true", "estimated")
    )
    settling = float(np.mean([row.settling_s for row in rows]))
    overshoot = max(row.overshoot_percent for row in rows)
    return ClosedLoop(settling, overshoot, true, estimated, sum(row.crossings for row in rows))
