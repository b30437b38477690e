"""The forces by which the step of MuJoCo is chosen are those of whole fingers."""

import numpy as np

from soft_gripper.extras.mujoco_engine.engine import _net_forces
from soft_gripper.truth.contact import COLUMNS


def test_points_of_a_finger_that_oppose_each_other_count_together():
    """Two points, of which one is listed from the side of the object: 3 N across in all, and 5 N against 5 N along."""
    rows = np.zeros((2, COLUMNS))
    rows[:, 3], rows[:, 10:13] = [1, -1], [[1, 5, 0], [-2, 5, 0]]
    assert _net_forces([rows, rows], 2).tolist() == [3, 0]
