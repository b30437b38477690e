"""Joint control of arms, against the textbook's second-order response, their limits, and weight."""

import numpy as np
import pytest
from arm_plants import MASS, MOMENT, joint, motor, small_arm
from pydrake.common.schema import Transform
from pydrake.math import RigidTransform
from pydrake.systems.analysis import ApplySimulatorConfig, Simulator
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import TrajectorySource
from pydrake.trajectories import PiecewisePolynomial
from refusals import refused
from scenario_plants import add_scene, arm_of

from soft_gripper.arrays import Array
from soft_gripper.diagrams.arm import add_arm_control
from soft_gripper.diagrams.simulation import solver_config

# Joints that do not act on each other: up and down, and round about the same axis. The file names the last joint
# first, and the motors in yet another order.
LIFT, TURN = "prismatic_to_carriage", "revolute_to_flange"
JOINTS = joint("revolute", "carriage", "flange") + joint("prismatic", "base", "carriage")
UNCOUPLED = f'<link name="flange"/><link name="carriage"/>{JOINTS}{motor(TURN)}{motor(LIFT)}'


class Run:
    """An arm that is commanded where to be."""

    def __init__(self, scenario, desired, time_step):
        """`desired` is a trajectory of the positions; `time_step` of the plant, 0 for cenic."""
        scenario.plant_config.time_step = time_step
        builder = DiagramBuilder()
        scene = add_scene(builder, scenario)
        self.plant, self.arm = scene.plant, arm_of(scenario, scene)
        goes_in = add_arm_control(builder, self.plant, self.arm)
        source = builder.AddSystem(TrajectorySource(desired, output_derivative_order=1))
        builder.Connect(source.get_output_port(), goes_in)
        self.simulator = Simulator(builder.Build())
        ApplySimulatorConfig(solver_config(scenario), self.simulator)
        self.simulator.Initialize()
        self.context = self.plant.GetMyContextFromRoot(self.simulator.get_context())

    def state(self, time) -> Array:
        """Positions and velocities of the joints."""
        self.simulator.AdvanceTo(time)
        return self.plant.GetPositionsAndVelocities(self.context, self.arm.model)

    def positions(self, times) -> Array:
        return np.array([self.state(time)[: len(self.arm.home)] for time in times])

    @property
    def torque(self):
        """What the motors give, in their own order."""
        return self.plant.get_net_actuation_output_port(self.arm.model).Eval(self.context)


def gains(scenario):
    """Of the motors, by the names of their joints."""
    run = Run(scenario, held(*scenario.arm.home), 0.01)
    motors = (run.plant.get_joint_actuator(index) for index in run.plant.GetJointActuatorIndices(run.arm.model))
    return {motor.joint().name(): (motor.get_controller_gains().p, motor.get_controller_gains().d) for motor in motors}


def held(*positions):
    return PiecewisePolynomial(np.array(positions, dtype=float)[:, None])


def step_response(time, frequency, damping_ratio):
    """A mass on spring and damper, from 0 to 1."""
    w, z = 2 * np.pi * frequency, damping_ratio
    if z == 1:
        return 1 - np.exp(-w * time) * (1 + w * time)
    wd = w * np.sqrt(1 - z**2)
    return 1 - np.exp(-z * w * time) * (np.cos(wd * time) + z * w / wd * np.sin(wd * time))


def deviation(scenario, time_step):
    """From the textbook, as a part of the step, of both joints."""
    time, step = np.arange(0.02, 0.5, 0.02), np.array([0.1, -0.3])
    expected = step_response(time, scenario.arm.frequency, scenario.arm.damping_ratio)
    parts = Run(scenario, held(*step), time_step).positions(time) / step
    return np.abs(parts - expected[:, None]).max(axis=0)


@pytest.mark.parametrize(("frequency", "damping_ratio"), [(10.0, 1.0), (4.0, 0.5)])
def test_steps_are_answered_as_frequency_and_damping_say(tmp_path, frequency, damping_ratio):
    """By every joint, whatever moves with it. An implicit PD converges to the textbook with the plant's step."""
    scenario = small_arm(tmp_path, UNCOUPLED, [0.0, 0.0], frequency=frequency, damping_ratio=damping_ratio)
    coarse, fine = (deviation(scenario, time_step) for time_step in (0.002, 0.001))
    assert fine.max() < 0.01
    np.testing.assert_allclose(coarse / fine, 2, rtol=0.05)


def test_gains_are_for_the_inertia_at_home(tmp_path):
    """The hand hangs on two links; how far it is from the first joint depends on the second."""
    reach, bend, frequency, damping_ratio = np.array([0.5, 0.3]), 1.2, 3.0, 0.7
    upper = joint("revolute", "base", "upper")
    lower = joint("revolute", "upper", "flange", xyz=f"{reach[0]} 0 0")
    links = f'<link name="upper"/><link name="flange"/>{upper}{lower}'
    scenario = small_arm(tmp_path, links, [0.4, bend], frequency=frequency, damping_ratio=damping_ratio)
    scenario.models[1].X_PC = Transform(RigidTransform([reach[1], 0, 0]))
    found, pulsation = gains(scenario), 2 * np.pi * frequency
    distance = abs(reach[0] + reach[1] * np.exp(1j * bend))
    for name, arm in (("revolute_to_upper", distance), ("revolute_to_flange", reach[1])):
        inertia = MOMENT + MASS * arm**2
        assert found[name] == pytest.approx((inertia * pulsation**2, 2 * damping_ratio * inertia * pulsation), rel=1e-3)


@pytest.mark.parametrize("time_step", [0.001, 0.0])
def test_motions_are_followed_without_a_lag(tmp_path, time_step):
    """What is wanted comes with its velocity; only a step of the solver is lost."""
    ramp = PiecewisePolynomial.FirstOrderHold([0.0, 1.0], [[0.0, 0.5], [0.0, 1.0]])
    scenario = small_arm(tmp_path, UNCOUPLED, [0.0, 0.0])
    scenario.simulator_config.max_step_size = 0.001
    run = Run(scenario, ramp, time_step)
    np.testing.assert_allclose(run.positions([0.4])[-1], ramp.value(0.4)[:, 0], atol=3e-3)


@pytest.mark.parametrize("time_step", [0.001, 0.0])
@pytest.mark.parametrize("way", [1, -1])
def test_each_motor_gives_its_limit_and_no_more(tmp_path, time_step, way):
    """Far from where it is wanted, a joint accelerates by its effort limit, of which its weight takes a part."""
    lift, turn = 40.0, 5.0  # N, N m
    joints = joint("revolute", "carriage", "flange", effort=turn) + joint("prismatic", "base", "carriage", effort=lift)
    arm = f'<link name="flange"/><link name="carriage"/>{joints}{motor(TURN)}{motor(LIFT)}'
    run = Run(small_arm(tmp_path, arm, [0.0, 0.0]), held(5.0 * way, 5.0 * way), time_step)
    time = 0.05
    expected = np.array([way * lift / MASS - 9.81, way * turn / MOMENT]) * time
    np.testing.assert_allclose(run.state(time)[2:], expected, rtol=2e-3)
    if time_step:
        np.testing.assert_allclose(run.torque, [way * turn, way * lift], rtol=1e-12)  # in the order of the motors


def test_a_joint_without_a_motor_is_refused(tmp_path):
    (tmp_path / "arm.sdf").write_text(
        """<sdf version="1.7"><model name="arm"><link name="base"/><link name="flange"/>
        <joint name="shoulder" type="revolute"><parent>base</parent><child>flange</child>
        <axis><xyz>0 0 1</xyz><limit><effort>0</effort></limit></axis></joint></model></sdf>"""
    )
    scenario = small_arm(tmp_path, "", [0.0])
    scenario.models[0].file = str(tmp_path / "arm.sdf")
    with refused("limit.effort", 0.0):
        Run(scenario, held(0.0), 0.01)
