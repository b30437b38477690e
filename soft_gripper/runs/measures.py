"""The measures of a run, by the kind of its scenario."""

from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from soft_gripper.diagrams.recording import Recording
from soft_gripper.diagrams.station_parts import Station
from soft_gripper.files.row_table import columns
from soft_gripper.runs.scores.grasp import Grasp
from soft_gripper.runs.scores.poses import held_samples, recorded_pose_table
from soft_gripper.runs.scores.recorded_grasps import objects_of, recorded_grasp
from soft_gripper.runs.scores.recorded_object import RecordedObject
from soft_gripper.runs.scores.recorded_slips import recorded_slip
from soft_gripper.runs.scores.recorded_task import Judged, judged
from soft_gripper.runs.scores.slipping import Slip
from soft_gripper.runs.scores.steps import outcome, step_table
from soft_gripper.scenario.schema import Scenario


@dataclass(frozen=True)
class OpenLoop:
    """Pressure steps, over all steady states and fingers; the torque is the external torque at the base joint.

    The contact force is the largest of a finger, with friction, as a mean over a steady state.
    """

    mean_pose_error_mm: float
    max_pose_error_mm: float
    mean_tip_error_mm: float
    max_tip_error_mm: float
    mean_torque_error_mnm: float
    largest_bend_deg: float
    largest_contact_force_n: float


@dataclass(frozen=True)
class ClosedLoop:
    """Steps of the gripper opening, over all steps; the settling time is NaN if one does not settle."""

    mean_settling_s: float
    max_overshoot_percent: float
    mean_steady_error_true_mm: float
    mean_steady_error_estimated_mm: float
    crossings: int


@dataclass(frozen=True)
class TaskMeasures:
    """A task: its outcome as estimated, and its duration."""

    outcome: str
    duration_s: float


def kind_of(scenario: Scenario) -> tuple[type[Any], ...]:
    """The measures of a scenario: dataclasses whose fields are concatenated; of equal names, the later one is used.

    With a free object, its grasp and why it slips come first. For a task that holds an object and detects contact, the
    ground truth of its result is measured too.
    """
    has_object = any(model.free for model in scenario.models) and scenario.record.patches_every is not None
    grasp: tuple[type[Any], ...] = (Grasp, Slip) if has_object else ()
    if scenario.task is not None:
        looks = scenario.estimator.contact_threshold is not None
        is_judged = looks and any(phase.holds for phase in scenario.task.phases)
        return (*grasp, TaskMeasures, Judged) if is_judged else (*grasp, TaskMeasures)
    return (*grasp, OpenLoop) if scenario.control.set_points is None else (*grasp, ClosedLoop)


def names_of(kind: Sequence[type[Any]]) -> list[str]:
    """The names of the measures of a kind of scenario."""
    return list(dict.fromkeys(name for part in kind for name in columns(part)))


def measure(station: Station, recording: Recording) -> dict[str, Any]:
    """The values of the measures of a run, by name."""
    # The object of the task, or the first free model.
    items = [RecordedObject(station, recording, name) for name in objects_of(station)[:1]]
    makers: dict[type[Any], Callable[[], Any]] = {
        OpenLoop: lambda: _open_loop(station, recording),
        ClosedLoop: lambda: _closed_loop(station, recording),
        TaskMeasures: lambda: TaskMeasures(outcome(recording).words, float(recording.values("time")[-1])),
        Judged: lambda: judged(station, recording),
        Grasp: lambda: recorded_grasp(*items)[0],
        Slip: lambda: recorded_slip(*items),
    }
    values: dict[str, Any] = {}
    for kind in kind_of(station.scenario):
        values |= asdict(makers[kind]())
    return values


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
    contact = max(
        float(held_samples(station.scenario, recording, f"{finger.name}.true_contact_total").mean(axis=1).max())
        for finger in station.fingers
    )
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
