"""A finger that touches nothing reports next to no torque, however its base is moved: inertia is no contact."""

import numpy as np
import pytest
from arm_plants import joint, small_arm
from pydrake.common.schema import Transform
from pydrake.math import RigidTransform, RollPitchYaw
from pydrake.polynomial import Polynomial
from pydrake.systems.analysis import ApplySimulatorConfig, Simulator
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import TrajectorySource
from pydrake.trajectories import PiecewisePolynomial

from soft_gripper.diagrams.recording import Recording, read_logs
from soft_gripper.diagrams.signal_logs import add_logs
from soft_gripper.diagrams.simulation import simulate, solver_config
from soft_gripper.diagrams.station import add_station
from soft_gripper.load.force_estimator import SAMPLES
from soft_gripper.scenario.scenario_file import load_scenario
from soft_gripper.scenario.schema import ModelConfig

pytestmark = pytest.mark.slow

FINGER = "package://soft_gripper/grippers/finger.urdf"
SLIDE = "<link name='flange'/>" + joint("prismatic", "base", "flange", "1 0 0", effort=1e5)
LARGEST = 2e-3  # N m, at the base joint
ACCELERATION = 10.0  # m/s^2, of the base
BEGIN, REST = 0.5, 0.3  # s, when the base begins to move, and how long it rests between there and back
SIDEWAYS, ALONG = RollPitchYaw(np.pi, 0, 0), RollPitchYaw(np.pi, np.pi / 2, 0)  # how the finger hangs on the slide
PERIOD = 0.01  # s


def swing(frequency):
    """There and back; the acceleration is one period of a sine each."""
    w = 2 * np.pi * frequency
    time = np.arange(0.0, BEGIN + 2 * (1 / frequency + REST) + 1e-9, 1e-3)

    def travelled(since):
        phase = w * np.clip(since, 0.0, 1 / frequency)
        return ACCELERATION / w**2 * (phase - np.sin(phase))

    positions = travelled(time - BEGIN) - travelled(time - BEGIN - 1 / frequency - REST)
    return PiecewisePolynomial.CubicWithContinuousSecondDerivatives(time, positions[None, :], True)


def jerk(half):
    """There and back at full acceleration, `half` s with it and `half` s against it."""
    pieces, breaks, x, v = [], [0.0], 0.0, 0.0
    there = [(half, ACCELERATION), (half, -ACCELERATION), (REST, 0.0)]
    for duration, a in [(BEGIN, 0.0), *there, *((duration, -a) for duration, a in there)]:
        pieces.append(np.array([[Polynomial([x, v, a / 2])]]))
        breaks.append(breaks[-1] + duration)
        x, v = x + v * duration + a / 2 * duration**2, v + a * duration
    return PiecewisePolynomial(pieces, breaks)


def moved(folder, motion, time_step, pressure=0.0, hanging=SIDEWAYS) -> Recording:
    """What is recorded of a finger whose base follows a motion, m."""
    scenario = small_arm(folder, SLIDE, [0.0], frequency=30.0)
    place = Transform(RigidTransform(hanging, [0, 0, 0]))
    scenario.models.append(ModelConfig("finger", FINGER, parent="hand::hand", X_PC=place))
    scenario.external, scenario.pressure.steps = ["joints"], {"all": [pressure]}
    scenario.simulator_config.max_step_size = 5e-3  # s, of cenic, which watches positions: the base jerks with longer
    scenario.estimator.contact_threshold, scenario.plant_config.time_step = 2.5e-3, time_step
    builder = DiagramBuilder()
    station = add_station(builder, scenario)
    source = builder.AddSystem(TrajectorySource(motion, output_derivative_order=1))
    builder.Connect(source.get_output_port(), station.inputs["arm.desired_state"])
    logs = add_logs(builder, station.signals, PERIOD)
    simulator = Simulator(builder.Build())
    ApplySimulatorConfig(solver_config(scenario), simulator)
    simulator.AdvanceTo(motion.end_time() - PERIOD / 2)
    return read_logs(logs, simulator.get_context())


def check_free(recording, finger):
    """From the first estimate on."""
    torque = recording[f"{finger}.external_torque"].values
    assert np.isnan(torque[:SAMPLES]).all()
    assert not recording[f"{finger}.true_external_torque"].values.any()
    assert np.abs(torque[SAMPLES:, 0]).max() < LARGEST
    assert not recording[f"{finger}.contact"].values.any()


def acceleration(recording):
    """Of the base, largest, m/s^2."""
    return np.abs(np.diff(recording["arm.joint_velocities"].values[:, 0])).max() / PERIOD


@pytest.mark.parametrize("time_step", [0.01, 0.002, 0.0])
@pytest.mark.parametrize("pressure", [0.0, 100e3])
@pytest.mark.parametrize("frequency", [1.0, 3.0, 5.0])
def test_a_free_finger_that_is_swung_sideways(tmp_path, frequency, pressure, time_step):
    recording = moved(tmp_path, swing(frequency), time_step, pressure)
    assert acceleration(recording) == pytest.approx(ACCELERATION, rel=0.06)
    assert np.ptp(recording["finger.sampled_joint_angles"].values.sum(axis=1)[50:]) > 0.15  # rad, that it sways
    check_free(recording, "finger")


@pytest.mark.parametrize("hanging", [SIDEWAYS, ALONG], ids=["sideways", "along"])
@pytest.mark.parametrize("time_step", [0.01, 0.005])
@pytest.mark.parametrize("half", [0.1, 0.3])
def test_a_free_finger_whose_acceleration_jumps(tmp_path, half, time_step, hanging):
    recording = moved(tmp_path, jerk(half), time_step, hanging=hanging)
    assert acceleration(recording) == pytest.approx(ACCELERATION, rel=0.06)
    check_free(recording, "finger")


def test_the_inertia_is_many_times_as_much(shipped_finger):
    torque = shipped_finger.link_masses.sum() * ACCELERATION * shipped_finger.length / 2
    assert torque > 10 * LARGEST


def test_the_fingers_of_an_arm_at_full_speed():
    recording = simulate(load_scenario("arm_motion"))
    for finger in ("left_finger", "right_finger"):
        check_free(recording, finger)
