"""Differences of this evaluation from the paper's: both results and the reason, in numbers of this evaluation.

Why the paper's fingertip error in free bending hardly depends on the number of sensors, while here it does.

Two changes of the simulated finger are tried on recorded joint angles: joints where the segments begin, as a chain of
URDF links has them, and noise in the readings. The estimate is the same, one arc a section.

With joints in the middles of the segments a section measures the whole angle of each of its joints. With joints where
segments begin, the first lies at the base, where the sensors begin: half of its angle is turned before them, and no
number of sensors sees it. The tip then errs by its lever, the whole finger, times half a joint's angle.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from soft_gripper.arrays import Array, Planar
from soft_gripper.diagrams.recording import Recording
from soft_gripper.estimators.arcs import arcs_from_lengths
from soft_gripper.extras.paper.claims import PAPER_POSE_GAIN, PAPER_TIP_GAIN
from soft_gripper.extras.paper.pose_rows import largest_gain, mean_errors
from soft_gripper.fingers.finger import Finger
from soft_gripper.fingers.kinematics import (
    forward_kinematics,
    link_directions,
    planar_vector,
    rotated,
    segment_path_lengths,
)
from soft_gripper.runs.scores.poses import PoseRow, held_samples
from soft_gripper.scenario.schema import Scenario


@dataclass(frozen=True)
class TipErrors:
    """Fingertip errors by the number of sections, m, each (len(sections), steps)."""

    sections: tuple[int, ...]
    middles: Array  # joints in the middles of the segments, as here
    starts: Array  # joints where the segments begin
    noisy: Array  # joints in the middles, noise in the readings: root mean square


def tip_errors(
    finger: Finger, q: Array, sections: tuple[int, ...] = (1, 2, 3, 4), noise: float = 1e-3, seed: int = 0
) -> TipErrors:
    """Fingertip errors at joint angles (steps, N) rad; `noise` of the extension ratio, root mean square."""
    rng = np.random.default_rng(seed)
    ds = finger.segment_length
    offsets = np.array(finger.sensor_offsets)[:, None, None]
    middle_lengths = segment_path_lengths(q, ds, offsets)
    tip = forward_kinematics(q, ds).tip
    start_points, start_tip = start_joint_chain(q, ds, offsets)
    middles, starts, noisy = [], [], []
    for count in sections:
        ends = finger.section_ends(count)[:-1]
        paths = np.add.reduceat(middle_lengths, ends, axis=-1)
        middles.append(np.abs(_tip(paths, finger) - tip))
        starts.append(np.abs(_tip(np.add.reduceat(start_points, ends, axis=-1), finger) - start_tip))
        rest_length = finger.length / count
        errors = [_tip(paths + noise * rest_length * rng.normal(size=paths.shape), finger) - tip for _ in range(200)]
        noisy.append(np.sqrt(np.mean(np.abs(errors) ** 2, axis=0)))
    return TipErrors(sections, np.array(middles), np.array(starts), np.array(noisy))


def start_joint_chain(q: Array, ds: float, offsets: Array) -> tuple[Array, Planar]:
    """Lengths of sensor paths over every segment, and the tip, of a chain whose joint i lies where segment i begins.

    `offsets` (paths, 1, 1) m are from the axis; lengths (paths, steps, N) m, tip (steps) m in B. As in
    `kinematics.sensor_path` a point of a path at a joint lies on the bisector of its links.
    """
    headings = q.cumsum(axis=-1)
    last_headings = np.concatenate([np.zeros_like(q[..., :1]), headings[..., :-1]], axis=-1)
    bisectors = np.concatenate([(last_headings + headings) / 2, headings[..., -1:]], axis=-1)
    links = ds * link_directions(q)
    sides = rotated(planar_vector(offsets, 0.0), bisectors)
    return np.abs(links + np.diff(sides, axis=-1)), links.sum(axis=-1)


def _tip(paths: Array, finger: Finger) -> Planar:
    """The estimated tip from the lengths of the inner and outer paths, (2, steps, S) m."""
    inner, outer = paths
    spacing = finger.sensor_spacing
    return arcs_from_lengths(inner, outer, spacing, finger.sensor_offsets[0] / spacing).end[..., -1]


POSE, TIP = "pose_error_mm", "tip_error_mm"


@dataclass(frozen=True)
class PaperDifference:
    """One subject: the paper's result, the result here, and the reason."""

    subject: str
    paper: str
    here: str
    reason: str


def held_tip_errors(scenario: Scenario, recording: Recording, finger: Finger) -> tuple[Array, TipErrors]:
    """Bend angles, rad (steps), and tip errors of one finger at the held steps of free bending."""
    q = held_samples(scenario, recording, f"{finger.name}.sampled_joint_angles").mean(axis=1)
    return q.sum(axis=-1), tip_errors(finger, q)


def differences(rows: Sequence[PoseRow], name: str, contact: Sequence[str], errors: TipErrors) -> list[PaperDifference]:
    """Collects the differences of this evaluation from the paper's.

    Args:
        rows: of the evaluation.
        name: name of the scenario of free bending.
        contact: names of those with contact.
        errors: fingertip errors in free bending with joints in other places, `held_tip_errors`.
    """
    return [_fingertip(rows, name, errors), _gains(rows, contact), _flattening(rows, contact)]


def _fingertip(rows: Sequence[PoseRow], name: str, errors: TipErrors) -> PaperDifference:
    tip = mean_errors(rows, name, TIP)
    starts = 1e3 * errors.starts.mean(axis=-1)
    return PaperDifference(
        "Fingertip in free bending",
        "The error hardly depends on the number of sensors.",
        f"It falls: {_list(tip)} mm with 1 to {len(tip)} sensors per side.",
        "Joints lie in the middles of the segments here. A chain of links usually has them where segments begin, the"
        " first at the base, where the sensors begin: half of its angle is turned before them, and no number of"
        f" sensors measures it. The same joint angles on such a chain give {_list(starts)} mm. The paper's model is"
        " not at hand: this is the likely cause, not a proof.",
    )


def _gains(rows: Sequence[PoseRow], contact: Sequence[str]) -> PaperDifference:
    pose, tip = (largest_gain(rows, contact, 2, 4, error) for error in (POSE, TIP))
    residual = np.max([mean_errors(rows, name, POSE)[1] for name in contact])
    return PaperDifference(
        "Gain from two to four sensors, in contact",
        f"{PAPER_POSE_GAIN} mm (pose) and {PAPER_TIP_GAIN} mm (fingertip).",
        f"Up to {pose:.1f} mm (pose) and {tip:.1f} mm (fingertip), at the step that gains most.",
        f"Two sensors leave less to gain: a mean pose error of {residual:.2f} mm at most. Nothing disturbs the sensors"
        " here, and their places and the finger are exactly known.",
    )


def _flattening(rows: Sequence[PoseRow], contact: Sequence[str]) -> PaperDifference:
    gains = -np.diff([mean_errors(rows, name, POSE) for name in contact], axis=-1)
    return PaperDifference(
        "Gain of each further sensor, in contact",
        "Four sensors still gain much over two, as above.",
        f"Gains flatten beyond two: up to {_list(gains.max(axis=0))} mm of mean pose error with the second, third and"
        " fourth sensor.",
        "The error decreases roughly with the square of the arc length: the second sensor removes most of it.",
    )


def _list(numbers: Array) -> str:
    *first_texts, last_text = (f"{value:.2f}" for value in numbers)
    return f"{', '.join(first_texts)} and {last_text}"
