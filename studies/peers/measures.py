"""Measures the quality of a run: error of the fingertips, m, and creep of the grasped object, m/s."""

import numpy as np

from studies.peers.task import PeerTask, PeerTrial

MOVING_TIME, SETTLED_TIME = 0.5, 1.0  # s, after every step of pressure and before the next
CREEP_TIME = 2.0  # s, at the end


def tip_error(task: PeerTask, trial: PeerTrial, reference: PeerTrial) -> float:
    """The larger one of two errors, m: root mean square of the moving and worst mean of the settled tips.

    If something is grasped, only the settled part of the last step counts: where the object comes to
    rest before that differs from run to run.
    """
    step_samples = round(task.scenario.step_duration / task.period)
    difference = (trial.tips - reference.tips).reshape(-1, step_samples, trial.tips.shape[1])
    moving_count, settled_count = (round(seconds / task.period) for seconds in (MOVING_TIME, SETTLED_TIME))
    settled_errors = np.abs(difference[:, -settled_count:].mean(axis=1))
    if task.grasped_body is not None:
        return float(settled_errors[-1].max())
    return float(max(np.sqrt((np.abs(difference[:, :moving_count]) ** 2).mean()), settled_errors.max()))


def creep(task: PeerTask, trial: PeerTrial) -> float:
    """Final speed of the held object, m/s; NaN without an object."""
    if task.grasped_body is None:
        return float("nan")
    samples = round(CREEP_TIME / task.period)
    return float(np.linalg.norm(trial.held[-1] - trial.held[-1 - samples]) / CREEP_TIME)


def holds(task: PeerTask, trial: PeerTrial, reach: float = 0.01) -> bool:
    """Whether the run did not diverge and the object is within `reach` m of its initial position."""
    if not np.isfinite(trial.tips).all() or np.abs(trial.tips).max() > 2 * task.fingers[0].length:
        return False
    if task.grasped_body is None:
        return True
    return bool(np.linalg.norm(trial.held - task.grasped_body.X_WB.translation(), axis=-1).max() < reach)
