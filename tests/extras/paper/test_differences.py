"""The box on the paper and why: its numbers are those of the tables, and of chains whose joints lie elsewhere."""

from itertools import product

import numpy as np
import pytest

from soft_gripper.extras.paper.differences import TipErrors, differences, start_joint_chain, tip_errors
from soft_gripper.fingers.statics import free_bending_angles
from soft_gripper.runs.scores.poses import PoseRow

FREE, CONTACT = "free_bending", ("obstructed_inside", "box_grasp")
POSE = {FREE: (1.0, 0.3, 0.2, 0.1), CONTACT[0]: (7.0, 1.75, 0.8, 0.5), CONTACT[1]: (4.0, 1.0, 0.45, 0.25)}  # mm
POSES = [
    PoseRow(name, "finger", "arcs", "as simulated", n + 1, kpa, 0.0, share * pose[n], 2 * share * pose[n])
    for (name, pose), n, (kpa, share) in product(POSE.items(), range(4), ((50.0, 0.5), (100.0, 1.5)))
]
STARTS = np.array([[3e-3, 5e-3], [4e-3, 5.5e-3], [4e-3, 5e-3], [3e-3, 4.5e-3]])  # m, means 4, 4.75, 4.5, 3.75 mm
ERRORS = TipErrors((1, 2, 3, 4), np.zeros((4, 2)), STARTS, np.zeros((4, 2)))


def box(rows: list[PoseRow], errors: TipErrors = ERRORS) -> list[str]:
    """What is said of every subject, here and why."""
    return [f"{row.here} {row.reason}" for row in differences(rows, FREE, CONTACT, errors)]


def test_says_means_of_both_chains_largest_gains_beside_the_papers_and_those_of_every_further_sensor() -> None:
    fingertip, gain, flattening = differences(POSES, FREE, CONTACT, ERRORS)
    assert "2.00, 0.60, 0.40 and 0.20 mm with 1 to 4 sensors" in fingertip.here
    assert "give 4.00, 4.75, 4.50 and 3.75 mm" in fingertip.reason
    assert gain.paper == "4 mm (pose) and 6 mm (fingertip)."
    assert "Up to 1.9 mm (pose) and 3.8 mm (fingertip)" in gain.here  # 1.5 (1.75 - 0.5), and twice that
    assert "1.75 mm at most" in gain.reason
    assert "5.25, 0.95 and 0.30 mm" in f"{flattening.here} {flattening.reason}"


BENDS = np.radians([20.0, 60.0, 120.0])
PRESSURES = np.array([30e3, 120e3, 240e3])  # Pa


@pytest.fixture
def even_bends(shipped_finger):
    """Joint angles of even bends, (3, N) rad."""
    return np.repeat(BENDS[:, None] / shipped_finger.segments, shipped_finger.segments, axis=1)


def test_half_of_the_first_angle_is_not_measured(shipped_finger, even_bends):
    spacing = shipped_finger.sensor_spacing
    offsets = np.array([0.5, -0.5])[:, None, None] * spacing
    (inner, outer), _ = start_joint_chain(even_bends, shipped_finger.segment_length, offsets)
    measured = (outer - inner).sum(axis=-1) / spacing
    np.testing.assert_allclose(measured, BENDS - even_bends[:, 0] / 2, rtol=3e-3)


def test_with_joints_at_the_starts_more_sensors_gain_little(shipped_finger):
    """The error falls from three quarters of the first angle, times the lever, to no less than half, by 1/2 + 1/4 S.

    Half of the angle is not measured; the rest is that the first section begins too late.
    """
    q = free_bending_angles(shipped_finger, PRESSURES)
    errors = tip_errors(shipped_finger, q)
    lever = shipped_finger.length * np.sinc(q.sum(axis=-1) / 2 / np.pi)
    shares = 1 / 2 + 1 / 4 / np.array(errors.sections)[:, None]
    np.testing.assert_allclose(errors.starts, lever * q[:, 0] * shares, rtol=0.06)
