"""GravityCompensation against textbook weights, and alone against the fall of an arm."""

import numpy as np
import pytest
from arm_plants import POSTURES, ur5e
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import MultibodyPlant
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder
from scenario_plants import add_scene, arm_of

from soft_gripper.control.arm_motion import GravityCompensation

G = 9.81  # m/s^2
MASSES, LENGTHS = (0.7, 0.4), (0.3, 0.2)  # kg, m, of two links
PENDULUM = f"""<robot name="pendulum"><link name="base"/>
<link name="upper"><inertial><origin xyz="{LENGTHS[0]} 0 0"/><mass value="{MASSES[0]}"/>
<inertia ixx="0.01" iyy="0.01" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial></link>
<link name="lower"><inertial><origin xyz="{LENGTHS[1]} 0 0"/><mass value="{MASSES[1]}"/>
<inertia ixx="0.01" iyy="0.01" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial></link>
<joint name="shoulder" type="continuous"><parent link="base"/><child link="upper"/><axis xyz="0 -1 0"/></joint>
<joint name="elbow" type="continuous"><parent link="upper"/><child link="lower"/>
<origin xyz="{LENGTHS[0]} 0 0"/><axis xyz="0 -1 0"/></joint></robot>"""


def torque(compensation, positions, velocities):
    context = compensation.CreateDefaultContext()
    compensation.GetInputPort("state").FixValue(context, [*positions, *velocities])
    return compensation.GetOutputPort("torque").Eval(context)


def pendulum():
    plant = MultibodyPlant(0.0)
    Parser(plant).AddModelsFromString(PENDULUM, "urdf")
    plant.WeldFrames(plant.world_frame(), plant.GetFrameByName("base"))
    plant.Finalize()
    return plant


@pytest.mark.parametrize("angles", [(0.0, 0.0), (0.5, -1.1), (np.pi / 2, 0.0), (2.0, 2.5)])
def test_weight_of_a_double_pendulum(angles):
    """Both angles turn upwards; what hangs at an angle pulls with its lever's projection."""
    level = np.cos(np.cumsum(angles))
    elbow = MASSES[1] * G * LENGTHS[1] * level[1]
    shoulder = (MASSES[0] + MASSES[1]) * G * LENGTHS[0] * level[0] + elbow
    np.testing.assert_allclose(torque(GravityCompensation(pendulum()), angles, (0, 0)), [shoulder, elbow], atol=1e-12)


def fall(home, is_compensated):
    """Where the joints of the shipped arm, with its gripper, are 0.3 s after they were let go; no PD holds them."""
    scenario = ur5e(home)
    arm = arm_of(scenario, add_scene(DiagramBuilder(), scenario))
    builder = DiagramBuilder()
    builder.AddSystem(arm.plant)
    compensation = builder.AddSystem(GravityCompensation(arm.plant))
    if is_compensated:
        builder.Connect(arm.plant.get_state_output_port(), compensation.get_input_port())
        builder.Connect(compensation.get_output_port(), arm.plant.get_applied_generalized_force_input_port())
    simulator = Simulator(builder.Build())
    context = arm.plant.GetMyMutableContextFromRoot(simulator.get_mutable_context())
    arm.plant.SetPositions(context, home)
    simulator.AdvanceTo(0.3)
    return arm.plant.GetPositions(context)


@pytest.mark.parametrize("home", POSTURES[1:5:2])
def test_an_arm_that_is_only_compensated_does_not_move(home):
    np.testing.assert_allclose(fall(home, is_compensated=True), home, atol=1e-9)
