"""The arm's kinematics, compared with textbook solutions of planar arms and, for six axes, with themselves."""

from itertools import product

import numpy as np
import pytest
from pydrake.math import RigidTransform, RollPitchYaw, RotationMatrix

from soft_gripper.control.arm_motion import movable_joints, solve_posture, tool_pose
from soft_gripper.models import DIRECTORY

HOME = np.array([0, -1.5, 1.5, -1.5, -1.5, 0])  # rad, of the UR5e
LINKS = np.array([0.5, 0.4, 0.1])  # m, of a planar arm
LIMIT = 6.28  # rad
REVOLUTE = f'type="revolute"><limit lower="-{LIMIT}" upper="{LIMIT}" velocity="3" effort="50"/>'
CONTINUOUS = 'type="continuous"><limit velocity="3" effort="50"/>'


def planar_arm(joint, extra=""):
    """URDF of three links that turn about z, and the tool at their end."""
    parents = ("base", "link0", "link1")
    starts = (0.0, *LINKS[:2])
    joints = [
        f'<link name="link{i}"/><joint name="joint{i}" {joint}<parent link="{parent}"/><child link="link{i}"/>'
        f'<origin xyz="{start} 0 0"/><axis xyz="0 0 1"/></joint>'
        for i, (parent, start) in enumerate(zip(parents, starts, strict=True))
    ]
    tool = (
        '<link name="tool"/><joint name="mount" type="fixed"><parent link="link2"/><child link="tool"/>'
        f'<origin xyz="{LINKS[2]} 0 0"/></joint>'
    )
    return f'<robot name="arm"><link name="base"/>{"".join(joints)}{tool}{extra}</robot>'


def planar_pose(q):
    """Pose of the planar arm's tool, from the textbook."""
    headings = np.cumsum(q)
    return RigidTransform(
        RotationMatrix.MakeZRotation(headings[-1]), [LINKS @ np.cos(headings), LINKS @ np.sin(headings), 0]
    )


def planar_postures(X_WTool):
    """Both postures of the planar arm, (2, 3) rad, from the law of cosines."""
    a, b, c = LINKS
    heading = RollPitchYaw(X_WTool.rotation()).yaw_angle()
    x, y = X_WTool.translation()[:2] - c * np.array([np.cos(heading), np.sin(heading)])
    elbow = np.arccos((x**2 + y**2 - a**2 - b**2) / (2 * a * b)) * np.array([1, -1])
    shoulder = np.arctan2(y, x) - np.arctan2(b * np.sin(elbow), a + b * np.cos(elbow))
    return np.array([shoulder, elbow, heading - shoulder - elbow]).T


def nearest(postures, seed, limit):
    """Of the postures (M, 3) and all that differ from them by whole turns, the nearest to the seed within limits."""
    turns = 2 * np.pi * np.array(list(product(range(-4, 5), repeat=3)))
    everywhere = (postures[:, None] + turns).reshape(-1, 3)
    allowed = everywhere[np.all(np.abs(everywhere) <= limit, axis=1)]
    return allowed[np.linalg.norm(allowed - seed, axis=1).argmin()]


def miss(X_WA, X_WB):
    X_AB = X_WA.inverse() @ X_WB
    return max(np.linalg.norm(X_AB.translation()), X_AB.rotation().ToAngleAxis().angle())


@pytest.fixture(scope="module")
def ur5e(load_plant):
    plant = load_plant((DIRECTORY / "arms/ur5e.urdf").read_text(), "base_link")
    return plant, plant.GetFrameByName("tool0")


def test_tool_pose_is_the_textbooks(load_plant):
    plant = load_plant(planar_arm(REVOLUTE), "base")
    for q in np.random.default_rng(1).uniform(-3, 3, (5, 3)):
        assert miss(tool_pose(plant, plant.GetFrameByName("tool"), q), planar_pose(q)) < 1e-12


@pytest.mark.slow
@pytest.mark.parametrize(("joint", "limit"), [(REVOLUTE, LIMIT), (CONTINUOUS, np.inf)], ids=["limited", "continuous"])
def test_of_all_textbook_postures_the_nearest_is_found(load_plant, joint, limit):
    plant = load_plant(planar_arm(joint), "base")
    rng = np.random.default_rng(2)
    for _ in range(15):
        seed, X_WTool = rng.uniform(-6, 6, 3), planar_pose(rng.uniform(-3, 3, 3))
        q = solve_posture(plant, plant.GetFrameByName("tool"), X_WTool, seed)
        np.testing.assert_allclose(q, nearest(planar_postures(X_WTool), seed, limit), atol=2e-6)


@pytest.mark.parametrize("goal", [6.2, -0.2, 6.4], ids=["before its limit", "a turn away", "beyond its limit"])
def test_a_joint_turns_up_to_its_limit_and_no_further(load_plant, goal):
    plant = load_plant(planar_arm(REVOLUTE), "base")
    seed, X_WTool = np.array([6.0, 1.0, 0.5]), planar_pose([goal, 1.0, 0.5])
    q = solve_posture(plant, plant.GetFrameByName("tool"), X_WTool, seed)
    np.testing.assert_allclose(q, nearest(planar_postures(X_WTool), seed, LIMIT), atol=2e-6)
    assert (q[0] > 6) == (goal < LIMIT)


@pytest.mark.slow
def test_forward_undoes_inverse(ur5e):
    plant, tool = ur5e
    rng = np.random.default_rng(3)
    lower, upper = plant.GetPositionLowerLimits(), plant.GetPositionUpperLimits()
    for _ in range(20):
        seed, X_WTool = HOME + rng.uniform(-1, 1, 6), tool_pose(plant, tool, rng.uniform(-3, 3, 6))
        q = solve_posture(plant, tool, X_WTool, seed)
        assert miss(tool_pose(plant, tool, q), X_WTool) < 1e-6
        assert np.all((lower <= q) & (q <= upper))
        assert np.all(np.abs(q - seed) <= np.pi + 1e-6)


@pytest.mark.slow
@pytest.mark.parametrize("place", [[0, 0, 1.3], [1.1, 0, 0.2], [0.02, 0, 0.6]], ids=["above", "beside", "inside"])
def test_out_of_reach(ur5e, place):
    assert solve_posture(*ur5e, RigidTransform(place), HOME) is None


def test_fingers_stay(load_plant):
    finger = (
        '<link name="finger"/><joint name="slide" type="prismatic"><parent link="tool"/><child link="finger"/>'
        '<axis xyz="0 1 0"/><limit lower="0" upper="0.04" velocity="1" effort="9"/></joint>'
    )
    plant = load_plant(planar_arm(REVOLUTE, finger), "base")
    assert [joint.name() for joint in movable_joints(plant)] == ["joint0", "joint1", "joint2", "slide"]
    for position in (0.01, 0.045):  # the second a little beyond its limit, as in any simulation
        seed = np.array([0.1, 0.8, 0.3, position])
        q = solve_posture(plant, plant.GetFrameByName("tool"), planar_pose([0.2, 0.9, 0.2]), seed)
        np.testing.assert_allclose(q, [0.2, 0.9, 0.2, position], atol=2e-6)
        assert q[3] == position


def test_a_slider_does_not_turn(load_plant):
    slider = (
        '<robot name="arm"><link name="base"/><link name="tool"/><joint name="slide" type="prismatic">'
        '<parent link="base"/><child link="tool"/><axis xyz="1 0 0"/>'
        '<limit lower="-9" upper="9" velocity="1" effort="9"/></joint></robot>'
    )
    plant = load_plant(slider, "base")
    q = solve_posture(plant, plant.GetFrameByName("tool"), RigidTransform([0.5, 0, 0]), np.array([8.0]))
    np.testing.assert_allclose(q, [0.5], atol=1e-6)
