"""Why the paper's fingertip error in free bending hardly depends on the number of sensors, while here it does.

Two changes of the simulated finger are tried on recorded joint angles: joints where the segments begin, as a chain of
URDF links has them, and noise in the readings. The estimate is the same, one arc a section.

With joints in the middles of the segments a section measures the whole angle of each of its joints. With joints where
segments begin, the first lies at the base, where the sensors begin: half of its angle is turned before them, and no
number of sensors sees it. The tip then errs by its lever, the whole finger, times half a joint's angle.
"""

from dataclasses import dataclass

import numpy as np

from soft_gripper.arrays import Array, Planar
from soft_gripper.estimators.section_arcs import bends_from_paths
from soft_gripper.fingers.finger import Finger
from soft_gripper.fingers.kinematics import forward_kinematics, segment_path_lengths
from soft_gripper.shape.arcs import join_arcs


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
    ds, offsets = finger.segment_length, np.array(finger.sensor_offsets)[:, None, None]
    in_middles = segment_path_lengths(q, ds, offsets)
    tip = forward_kinematics(q, ds).tip
    at_starts, tip_of_starts = chain_with_joints_at_starts(q, ds, offsets)
    middles, starts, noisy = [], [], []
    for count in sections:
        ends = finger.section_ends(count)[:-1]
        paths = np.add.reduceat(in_middles, ends, axis=-1)
        middles.append(np.abs(_tip(paths, finger) - tip))
        starts.append(np.abs(_tip(np.add.reduceat(at_starts, ends, axis=-1), finger) - tip_of_starts))
        rest = finger.length / count
        errors = [_tip(paths + noise * rest * rng.normal(size=paths.shape), finger) - tip for _ in range(200)]
        noisy.append(np.sqrt(np.mean(np.abs(errors) ** 2, axis=0)))
    return TipErrors(sections, np.array(middles), np.array(starts), np.array(noisy))


def chain_with_joints_at_starts(q: Array, ds: float, offsets: Array) -> tuple[Array, Planar]:
    """Lengths of sensor paths over every segment, and the tip, of a chain whose joint i lies where segment i begins.

    `offsets` (paths, 1, 1) m are from the axis; lengths (paths, steps, N) m, tip (steps) m in B. As in
    `kinematics.sensor_path` a point of a path at a joint lies on the bisector of its links.
    """
    headings = q.cumsum(axis=-1)
    before = np.concatenate([np.zeros_like(q[..., :1]), headings[..., :-1]], axis=-1)
    bisectors = np.concatenate([(before + headings) / 2, headings[..., -1:]], axis=-1)
    links = ds * np.exp(1j * headings)
    sides = 1j * offsets * np.exp(1j * bisectors)
    return np.abs(links + np.diff(sides, axis=-1)), links.sum(axis=-1)


def _tip(paths: Array, finger: Finger) -> Planar:
    """The estimated tip from the lengths of the inner and outer paths, (2, steps, S) m."""
    inner, outer = paths
    tip: Planar = join_arcs(*bends_from_paths(finger, inner, outer)).end[..., -1]
    return tip
