"""GripperOpening compared with positions in the world, for two fingers and for more."""

import numpy as np
import pytest
from pydrake.math import RigidTransform, RollPitchYaw

from soft_gripper.load.opening import Gripper, GripperOpening, mean_diameter
from soft_gripper.signals import signal_of

X_WB = [
    RigidTransform(RollPitchYaw(0.3, -0.5, 1.1), [0.1, -0.2, 0.4]),
    RigidTransform(RollPitchYaw(-0.7, 0.2, 2.9), [0.2, 0.05, 0.35]),
    RigidTransform(RollPitchYaw(0.1, 1.2, -0.4), [-0.1, 0.1, 0.3]),
]
BASES = pytest.mark.parametrize("bases", [X_WB[:2], X_WB], ids=len)


def in_world(bases, tips):
    """Points of some fingers' tips, (F, 3) m."""
    return np.array([X @ tip for X, tip in zip(bases, tips, strict=True)])


def world_opening(bases, tips):
    """By way of the world: twice the mean distance from the centroid, negative beyond it as the bases stand."""
    origins, points = np.array([X.translation() for X in bases]), in_world(bases, tips)
    arms, outward = points - points.mean(axis=0), origins - origins.mean(axis=0)
    return np.mean([2 * np.sign(arm @ out) * np.linalg.norm(arm) for arm, out in zip(arms, outward, strict=True)])


def random_tips(*shape):
    return np.random.default_rng(3).uniform(-0.1, 0.1, (*shape, 3))


def test_of_two_fingers_it_is_the_distance_of_their_tips():
    """Negative against the line from base to base."""
    gripper, along = Gripper.of_bases(X_WB[:2]), X_WB[1].translation() - X_WB[0].translation()
    for tips in 5 * random_tips(50, 2):
        from_first_to_second = np.diff(in_world(X_WB[:2], tips), axis=0)[0]
        distance = np.sign(from_first_to_second @ along) * np.linalg.norm(from_first_to_second)
        assert gripper.opening(tips) == pytest.approx(distance, abs=1e-15)


def test_curves_and_points_lie_where_drake_puts_them():
    gripper, tips = Gripper.of_bases(X_WB), random_tips(3)
    in_G = [X_WB[0].inverse() @ point for point in in_world(X_WB, tips)]
    np.testing.assert_allclose(gripper.points(tips), in_G, atol=1e-15)
    for i, (x, _, z) in enumerate(tips):
        on_curve = X_WB[0].inverse() @ X_WB[i] @ np.array([x, 0, z])
        np.testing.assert_allclose(gripper.curve(i, np.array([z + 1j * x])), [on_curve], atol=1e-15)


def test_spread_of_the_corners_of_a_polygon_is_the_diameter_of_its_circle():
    for corners in (2, 3, 7):
        angles = 2 * np.pi * np.arange(corners) / corners
        circle = 0.03 * np.array([np.cos(angles), np.sin(angles), np.zeros(corners)]).T + np.array([1.0, 2.0, 3.0])
        assert mean_diameter(circle) == pytest.approx(0.06, rel=1e-12)


@pytest.mark.parametrize("count", [0, 1])
def test_a_gripper_has_two_fingers_or_more(count):
    with pytest.raises(ValueError, match="two fingers or more"):
        Gripper(tuple(X_WB[:count]))


@BASES
def test_block_evaluates_its_inputs(bases):
    names = ["left", "right", "thumb"][: len(bases)]
    block = GripperOpening(Gripper.of_bases(bases), names)
    context, tips = block.CreateDefaultContext(), random_tips(len(bases)) * [1, 0, 1]
    for name, tip in zip(names, tips, strict=True):
        block.GetInputPort(f"{name}.tip_pose").FixValue(context, [tip[0], tip[2], 0.5])  # x, z, heading
    opening = block.GetOutputPort("opening")
    assert opening.Eval(context) == pytest.approx([world_opening(bases, tips)], abs=1e-15)
    assert (block.num_input_ports(), block.num_output_ports()) == (len(bases), 1)
    assert signal_of(opening).unit == "m"
