"""Where the tool is wanted, and where an object is reported."""

import numpy as np
import pytest
from arm_plants import joint, small_arm, ur5e
from pydrake.common.schema import Transform
from pydrake.common.value import Value
from pydrake.math import RigidTransform, RollPitchYaw
from refusals import refused

from soft_gripper.diagrams.simulation import make_simulator
from soft_gripper.diagrams.station import make_station
from soft_gripper.diagrams.task_plan import reported_pose
from soft_gripper.scenario.schema import ModelConfig, PoseErrorConfig, TaskConfig

BACK = (RigidTransform([-0.01, 0.03, -0.02]), RollPitchYaw(-0.05, 0.1, -0.1))
FAR = (RigidTransform([0.1, -0.15, -0.1]), RollPitchYaw(0.2, -0.1, 0.4))


class Follower:
    """The UR5e with its gripper, whose tool is commanded."""

    def __init__(self):
        scenario = ur5e()
        scenario.external = ["tool"]
        self.station = make_station(scenario)
        self.simulator = make_simulator(self.station)
        self.context = self.simulator.get_mutable_context()
        self.start = self.pose()

    def pose(self):
        plant = self.station.plant
        return plant.GetFrameByName("tool0").CalcPoseInWorld(plant.GetMyContextFromRoot(self.context))

    def go(self, shift, turn, duration):
        """Commands a pose; how far the tool is from it `duration` s later, m and rad."""
        wanted = shift @ self.start @ RigidTransform(turn, [0, 0, 0])
        self.station.diagram.GetInputPort("arm.X_WTool").FixValue(self.context, Value(wanted))
        self.simulator.AdvanceTo(self.context.get_time() + duration)
        missing = self.pose().inverse() @ wanted
        return np.linalg.norm(missing.translation()), missing.rotation().ToAngleAxis().angle()

    def signal(self, name):
        return self.station.recording(self.context)[f"arm.{name}"].values


@pytest.mark.filterwarnings("ignore::RuntimeWarning")
def test_a_pose_that_is_not_finite_brakes_and_is_not_remembered():
    follower = Follower()
    follower.go(*FAR, 0.2)
    for hostile in (np.nan, np.inf, 1e308):
        follower.station.diagram.GetInputPort("arm.X_WTool").FixValue(
            follower.context, Value(RigidTransform([hostile, 0.0, 0.0]))
        )
        follower.simulator.AdvanceTo(follower.context.get_time() + 0.1)
    assert np.abs(follower.signal("desired_state")[-1, 6:]).max() < 1e-9
    follower.go(*FAR, 0.2)
    assert np.abs(follower.signal("desired_state")[-1, 6:]).max() > 0.05


def test_joints_keep_their_velocity_limits():
    follower = Follower()
    follower.go(*FAR, 1.0)
    velocities = follower.signal("desired_state")[:, 6:]
    assert np.abs(velocities).max() <= np.pi * (1 + 1e-6)
    assert np.abs(velocities).max() > 0.05


@pytest.mark.slow
def test_joints_keep_their_acceleration_limits():
    follower = Follower()
    follower.go(*FAR, 1.0)
    follower.go(*BACK, 1.0)
    period, limit = follower.station.scenario.sensor.period, follower.station.scenario.arm.acceleration
    assert np.abs(np.diff(follower.signal("desired_state")[:, 6:], axis=0)).max() / period <= limit * 1.01


def test_an_arm_without_limits_is_refused(tmp_path):
    scenario = small_arm(tmp_path, "<link name='flange'/>" + joint("revolute", "base", "flange"), [0.0])
    path = tmp_path / "arm.urdf"
    path.write_text(path.read_text().replace('velocity="50"', 'velocity="0"'))
    scenario.external = ["tool"]
    with refused("limit.velocity", 0.0):
        make_station(scenario)


X_WO = RigidTransform(RollPitchYaw(0.3, -0.2, 0.5), [0.4, -0.1, 0.03])
MODELS = [ModelConfig("table"), ModelConfig("box", X_PC=Transform(X_WO), free=True)]


def test_an_error_shifts_and_turns_it_on_the_table():
    found = reported_pose(TaskConfig("box", pose_error=PoseErrorConfig(0.003, -0.002, 0.1)), MODELS)
    np.testing.assert_allclose(found.translation(), [0.403, -0.102, 0.03], atol=1e-12)
    turn = (found.rotation() @ X_WO.rotation().inverse()).ToAngleAxis()
    assert turn.angle() * turn.axis()[2] == pytest.approx(0.1)
    np.testing.assert_allclose(turn.axis()[:2], 0, atol=1e-9)
