"""FingertipDistance against positions computed in the world."""

import numpy as np
import pytest
from pydrake.math import RigidTransform, RollPitchYaw

from soft_gripper.fingertip_distance import FingertipDistance, fingertip_distance

X_WB1 = RigidTransform(RollPitchYaw(0.3, -0.5, 1.1), [0.1, -0.2, 0.4])
X_WB2 = RigidTransform(RollPitchYaw(-0.7, 0.2, 2.9), [0.2, 0.05, 0.35])
X_B1B2 = X_WB1.inverse() @ X_WB2


def world_distance(first, second):
    """Distance of two tips x, z, heading, by way of the world; negative against the line from base to base."""
    p_WT1, p_WT2 = (X_WB @ np.array([x, 0, z]) for X_WB, (x, z, _) in ((X_WB1, first), (X_WB2, second)))
    along = (p_WT2 - p_WT1) @ (X_WB2.translation() - X_WB1.translation())
    return np.sign(along) * np.linalg.norm(p_WT2 - p_WT1)


def random_tips(*shape):
    return np.random.default_rng(3).uniform(-0.1, 0.1, (2, *shape, 3))


def test_distance_is_the_one_in_the_world():
    first, second = random_tips()
    assert fingertip_distance(first, second, X_B1B2) == pytest.approx(world_distance(first, second), abs=1e-15)


def test_leading_axes_are_a_batch():
    first, second = 5 * random_tips(4, 5)
    distances = fingertip_distance(first, second, X_B1B2)
    expected = [[world_distance(*pair) for pair in zip(*rows, strict=True)] for rows in zip(first, second, strict=True)]
    np.testing.assert_allclose(distances, expected, atol=1e-15)
    assert distances.min() < 0 < distances.max()


@pytest.mark.parametrize("bend", [0.01, 0.044, 0.046, 0.06])
def test_tips_that_have_passed_each_other_are_apart_by_less_than_nothing(bend):
    """Two fingers 90 mm apart that face each other: the distance goes on falling as they cross."""
    X_B1B2 = RigidTransform(RollPitchYaw(0, 0, np.pi), [0.09, 0, 0])
    tip = np.array([bend, 0.1, 0.5])
    assert fingertip_distance(tip, tip, X_B1B2) == pytest.approx(0.09 - 2 * bend, abs=1e-12)


def test_heading_is_of_no_account():
    first, second = random_tips()
    turned = first + np.array([0, 0, 1.0])
    assert fingertip_distance(turned, second, X_B1B2) == fingertip_distance(first, second, X_B1B2)


def test_block_evaluates_its_inputs():
    block = FingertipDistance(X_B1B2)
    context = block.CreateDefaultContext()
    first, second = random_tips()
    block.GetInputPort("first_tip_pose").FixValue(context, first)
    block.GetInputPort("second_tip_pose").FixValue(context, second)
    distance = block.GetOutputPort("distance").Eval(context)
    assert distance == pytest.approx([world_distance(first, second)], abs=1e-15)
    assert (block.num_input_ports(), block.num_output_ports()) == (2, 1)
