"""Grasp: what height and forces earn, and when it is over."""

import numpy as np
import pytest

from soft_gripper.extras.learning.config import GraspConfig
from soft_gripper.extras.learning.tasks import Grasp, Handled, HandledObject

CONFIG = GraspConfig(object="block", height=0.05, force_weight=0.2, crushing_force=5.0)


@pytest.fixture
def judge(grasp_station, monkeypatch):
    """Judges a height, m, forces and their peak, N, after steps of 0.1 s."""

    def judged(height, force=(0.0, 0.0), peak=1.0):
        seen = Handled(np.array([0.0, 0.0, height]), np.array(force), peak)
        monkeypatch.setattr(HandledObject, "look", lambda *_: seen)
        return Grasp(grasp_station, CONFIG, 0.1).judge(None)

    return judged


@pytest.mark.parametrize(
    ("height", "force", "reward"),
    [
        (0.025, (0.0, 0.0), 0.1 * 0.5),
        (0.025, (1.0, 0.5), 0.1 * (0.5 - 0.2 * 1.0)),
        (0.2, (0.0, 0.0), 0.1),  # higher is no better
        (-0.01, (0.0, 0.0), 0.0),
    ],
)
def test_height_earns_and_force_costs(judge, height, force, reward):
    found = judge(height, force)
    assert found.reward == pytest.approx(reward)
    assert not found.terminated


def test_a_crushed_object_costs_one_and_ends_it(judge):
    found = judge(0.05, (1.0, 1.0), 5.1)
    assert found.reward == pytest.approx(0.1 * 0.8 - 1)
    assert found.terminated
    assert not judge(0.05, (1.0, 1.0), 4.9).terminated


@pytest.mark.parametrize(
    ("height", "force", "peak", "success"),
    [
        (0.041, (0.3, 0.3), 1.0, True),
        (0.039, (0.3, 0.3), 1.0, False),
        (0.05, (0.3, 0.0), 1.0, False),  # it leans on one finger
        (0.05, (0.3, 0.3), 5.1, False),
    ],
)
def test_success_is_to_hang_in_all_fingers(judge, height, force, peak, success):
    info = judge(height, force, peak).info
    assert info["success"] is success
    assert (info["height"], info["peak_force"], info["crushed"]) == (height, peak, peak > 5)
    np.testing.assert_array_equal(info["force"], force)
