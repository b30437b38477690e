"""Where this evaluation differs from the paper's: what each found, and why, in numbers of this evaluation."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from soft_gripper.arrays import Array
from soft_gripper.diagrams.recording.recording import Recording
from soft_gripper.diagrams.schema.scenario import Scenario
from soft_gripper.evaluation.paper.claims import PAPER_POSE_GAIN, PAPER_TIP_GAIN
from soft_gripper.evaluation.paper.held_steps import held_samples
from soft_gripper.evaluation.paper.pose_table import PoseRow, largest_gain, mean_errors
from soft_gripper.evaluation.paper.why_the_paper_differs import TipErrors, tip_errors
from soft_gripper.fingers.finger import Finger

POSE, TIP = "pose_error_mm", "tip_error_mm"


@dataclass(frozen=True)
class Difference:
    """One subject: what the paper found, what is found here, and the reason."""

    subject: str
    paper: str
    here: str
    reason: str


def held_tip_errors(scenario: Scenario, recording: Recording, finger: Finger) -> tuple[Array, TipErrors]:
    """Bend angles, rad (steps), and tip errors of one finger at the held steps of free bending."""
    q = held_samples(scenario, recording, f"{finger.name}.sampled_joint_angles").mean(axis=1)
    return q.sum(axis=-1), tip_errors(finger, q)


def differences(rows: Sequence[PoseRow], free: str, contact: Sequence[str], errors: TipErrors) -> list[Difference]:
    """All of them.

    Args:
        rows: of the evaluation.
        free: name of the scenario of free bending.
        contact: names of those with contact.
        errors: fingertip errors in free bending with joints in other places, `held_tip_errors`.
    """
    return [_fingertip(rows, free, errors), _gains(rows, contact), _flattening(rows, contact)]


def _fingertip(rows: Sequence[PoseRow], free: str, errors: TipErrors) -> Difference:
    tip = mean_errors(rows, free, TIP)
    starts = 1e3 * errors.starts.mean(axis=-1)
    return Difference(
        "Fingertip in free bending",
        "The error hardly depends on the number of sensors.",
        f"It falls: {_list(tip)} mm with one to {len(tip)} sensors a side.",
        "Joints lie in the middles of the segments here. A chain of links usually has them where segments begin, the"
        " first at the base, where the sensors begin: half of its angle is turned before them, and no number of"
        f" sensors measures it. The same joint angles on such a chain give {_list(starts)} mm. The paper's model is"
        " not at hand: this is the likely cause, not a proof.",
    )


def _gains(rows: Sequence[PoseRow], contact: Sequence[str]) -> Difference:
    pose, tip = (largest_gain(rows, contact, 2, 4, error) for error in (POSE, TIP))
    left = np.max([mean_errors(rows, name, POSE)[1] for name in contact])
    return Difference(
        "Gain from two to four sensors, in contact",
        f"{PAPER_POSE_GAIN} mm (pose) and {PAPER_TIP_GAIN} mm (fingertip).",
        f"Up to {pose:.1f} mm (pose) and {tip:.1f} mm (fingertip), at the step that gains most.",
        f"Two sensors leave less to gain: a mean pose error of {left:.2f} mm at most. Nothing disturbs the sensors"
        " here, and their places and the finger are exactly known.",
    )


def _flattening(rows: Sequence[PoseRow], contact: Sequence[str]) -> Difference:
    gains = -np.diff([mean_errors(rows, name, POSE) for name in contact], axis=-1)
    return Difference(
        "Gain of each further sensor, in contact",
        "Four sensors still gain much over two, as above.",
        f"Gains flatten beyond two: up to {_list(gains.max(axis=0))} mm of mean pose error with the second, third and"
        " fourth sensor.",
        "The error falls about with the square of the length of an arc: most of it is gone with the second sensor.",
    )


def _list(numbers: Array) -> str:
    *first, last = (f"{number:.2f}" for number in numbers)
    return f"{', '.join(first)} and {last}"
