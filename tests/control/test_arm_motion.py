"""Motions of the arm, compared with sliders and pendulums of the textbook and the arm's equations of motion."""

from dataclasses import replace

import numpy as np
import pytest
from pydrake.common.eigen_geometry import AngleAxis
from pydrake.math import RigidTransform, RollPitchYaw, RotationMatrix
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import MultibodyPlant

from soft_gripper.control.arm_motion import (
    MIN_DURATION,
    ArmLimits,
    LimitError,
    UnreachableError,
    joint_path,
    straight_path,
    timed,
    tool_pose,
)
from soft_gripper.models import DIRECTORY

HOME = np.array([0, -1.5, 1.5, -1.5, -1.5, 0])  # rad, of the UR5e
Q1 = np.array([1, -1.2, 1.1, -1, -2.5, 2])
MASS, STROKE = 2.0, 0.5  # kg, m, of a slider


def make_arm(text):
    plant = MultibodyPlant(0.0)
    Parser(plant).AddModelsFromString(text, "urdf")
    plant.WeldFrames(plant.world_frame(), plant.GetFrameByName("base_link"))
    plant.Finalize()
    return plant


def one_joint(kind="prismatic", axis="1 0 0", damping=0.0, effort=1000, velocity=1000, arm=0.0, limit=2):
    """A mass on a joint, which lies `arm` m out along x."""
    return make_arm(f"""<robot name="arm"><link name="base_link"/>
      <link name="mass"><inertial><origin xyz="{arm} 0 0"/><mass value="{MASS}"/>
        <inertia ixx="1e-3" iyy="1e-3" izz="1e-3" ixy="0" ixz="0" iyz="0"/></inertial></link>
      <joint name="slide" type="{kind}"><parent link="base_link"/><child link="mass"/><axis xyz="{axis}"/>
        <limit lower="-{limit}" upper="{limit}" velocity="{velocity}" effort="{effort}"/>
        <dynamics damping="{damping}"/></joint>
      <transmission name="t"><type>transmission_interface/SimpleTransmission</type>
        <joint name="slide"/><actuator name="slide"/></transmission></robot>""")


@pytest.fixture(scope="module")
def ur5e():
    plant = make_arm((DIRECTORY / "arms/ur5e.urdf").read_text())
    return plant, plant.GetFrameByName("tool0"), ArmLimits.of_plant(plant, acceleration=10.0)


def duration(plant, acceleration=1000.0, start=0.0, stroke=STROKE):
    path = joint_path(np.array([start]), np.array([start + stroke]))
    return timed(plant, path, ArmLimits.of_plant(plant, acceleration)).end_time()


def minimum_jerk(x, order):
    """Derivative of the motion from 0 to 1 in 1 s, from the textbook."""
    return np.polyval(([6, -15, 10, 0, 0, 0], [30, -60, 30, 0, 0], [120, -180, 60, 0])[order], x)


def sampled(motion, points):
    t = np.linspace(0, motion.end_time(), points)
    return motion.vector_values(t).T, *(motion.MakeDerivative(order).vector_values(t).T for order in (1, 2))


def use_of_limits(plant, limits, motion):
    """The largest part of the limits of velocity, acceleration and effort that the motion takes."""
    context, efforts = plant.CreateDefaultContext(), []
    q, v, vdot = sampled(motion, 3001)
    for k in range(len(q)):
        plant.SetPositionsAndVelocities(context, [*q[k], *v[k]])
        inertia = plant.CalcMassMatrix(context) @ vdot[k]
        efforts.append(inertia + plant.CalcBiasTerm(context) - plant.CalcGravityGeneralizedForces(context))
    pairs = ((v, limits.velocity), (vdot, limits.acceleration), (np.array(efforts), limits.effort))
    return [(np.abs(values) / limit).max() for values, limit in pairs]


def test_a_file_without_a_limit_of_velocity():
    with pytest.raises(LimitError, match=r"joint 'slide': a limit of velocity of 0"):
        ArmLimits.of_plant(one_joint(velocity=0), 10.0)


def test_profile_is_the_minimum_jerk_polynomial():
    plant = one_joint()
    motion = timed(plant, joint_path(np.zeros(1), np.ones(1)), ArmLimits.of_plant(plant, 4.0))
    t = np.linspace(0, 1, 101)
    for order, values in enumerate(sampled(motion, 101)):
        np.testing.assert_allclose(values[:, 0] * motion.end_time() ** order, minimum_jerk(t, order), atol=1e-12)


@pytest.mark.parametrize(
    ("binding", "change"),
    [(0, {"velocity": 0.3}), (1, {"acceleration": 1.0}), (2, {"acceleration": 1e3, "velocity": 1e3})],
    ids=["velocity", "acceleration", "effort"],
)
@pytest.mark.parametrize("straight", [False, True])
def test_a_motion_takes_the_whole_of_one_limit_and_no_more(ur5e, binding, change, straight):
    plant, tool, limits = ur5e
    limits = replace(limits, **{name: np.full(6, value) for name, value in change.items()})
    goal = RigidTransform(RollPitchYaw(0, 0, 0.5), [0.05, -0.1, 0.1]) @ tool_pose(plant, tool, HOME)
    path = straight_path(plant, tool, HOME, goal) if straight else joint_path(HOME, Q1)
    use = use_of_limits(plant, limits, timed(plant, path, limits))
    assert np.argmax(use) == binding
    assert 0.99 < max(use) <= 1


def test_staying_is_a_motion_too(ur5e):
    plant, tool, limits = ur5e
    for path in (joint_path(HOME, HOME), straight_path(plant, tool, HOME, tool_pose(plant, tool, HOME))):
        motion = timed(plant, path, limits)
        assert motion.end_time() == MIN_DURATION
        np.testing.assert_allclose(motion.value(MIN_DURATION / 3)[:, 0], HOME, atol=1e-8)


def test_an_arm_too_heavy_for_its_motor():
    plant = one_joint("revolute", "0 1 0", effort=9.8, arm=0.5)  # level at 0: 2 kg g 0.5 m = 9.81 N m
    with pytest.raises(
        LimitError, match=r"joint 'slide': effort at rest -9\.81 is outside of its limits, -9\.8 to 9\.8"
    ):
        timed(plant, joint_path(np.array([-1.0]), np.array([1.0])), ArmLimits.of_plant(plant, 1.0))
    assert duration(plant, 1.0, start=0.2) < 10


def test_a_path_beyond_a_joints_limits():
    with pytest.raises(LimitError, match=r"joint 'slide': position 2\.4 is outside of its limits, -2 to 2"):
        duration(one_joint(), start=1.9)


@pytest.mark.parametrize(
    ("direction", "rpy"),
    [([0.1, 0, 0], [0, 0, 0]), ([0, 0, 0], [0, 0, 2]), ([-0.05, 0.3, 0.1], [0.2, -0.3, 0.8])],
    ids=["straight", "on the spot", "both"],
)
def test_the_tool_goes_straight_and_turns_evenly(ur5e, direction, rpy):
    plant, tool, _ = ur5e
    X_WStart = tool_pose(plant, tool, HOME)
    turn = RollPitchYaw(rpy).ToRotationMatrix().ToAngleAxis()
    goal = RigidTransform(RotationMatrix(turn) @ X_WStart.rotation(), X_WStart.translation() + direction)
    path = straight_path(plant, tool, HOME, goal)
    for s in np.linspace(0, 1, 301):
        X_WTool = tool_pose(plant, tool, path.value(s)[:, 0])
        assert np.linalg.norm(X_WTool.translation() - X_WStart.translation() - s * np.array(direction)) < 1e-4
        R_W = RotationMatrix(AngleAxis(s * turn.angle(), turn.axis())) @ X_WStart.rotation()
        assert (X_WTool.rotation().inverse() @ R_W).ToAngleAxis().angle() < 1e-4


def test_a_straight_path_out_of_reach_tells_how_far_it_gets():
    plant = one_joint(limit=2)
    start, X_WGoal = np.array([1.5]), RigidTransform([2.5, 0, 0])
    with pytest.raises(UnreachableError, match=r"^at 51% of a straight path, \[2.01, 0.0, 0.0\] m is out of reach$"):
        straight_path(plant, plant.GetFrameByName("mass"), start, X_WGoal)


def test_a_straight_path_does_not_turn_a_joint_back_by_a_turn():
    """Two thirds of the way from 3.1 to 3.3 rad lie before the limit; beyond it there is -3 rad."""
    plant = one_joint("revolute", "0 0 1", limit=3.22)
    X_WGoal = RigidTransform(RotationMatrix.MakeZRotation(3.3), [0, 0, 0])
    with pytest.raises(UnreachableError, match=r"^at 67% of a straight path, .* m takes a jump of the joints$"):
        straight_path(plant, plant.GetFrameByName("mass"), np.array([3.1]), X_WGoal)
