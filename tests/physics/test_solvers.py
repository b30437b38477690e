"""Solvers: energy, divergence, implicit springs."""

from typing import NamedTuple

import numpy as np
import pytest
from finger_plants import free_bending, uniform_finger
from pydrake.systems.analysis import ApplySimulatorConfig, Simulator, SimulatorConfig
from refusals import refused
from scipy.integrate import trapezoid

from soft_gripper.diagrams.simulation import simulate, solver_config
from soft_gripper.diagrams.station import make_station
from soft_gripper.errors import InputError, SimulationDivergedError
from soft_gripper.fingers.kinematics import forward_kinematics


def settled_tips(*overrides):
    """Both fingertips at the end of two pressures, m in their B, complex."""
    station = make_station(free_bending([150e3, 200e3], 1.0, *overrides))
    recording = simulate(station.scenario)
    return np.array(
        [
            forward_kinematics(angles.sel(time=[1.0, 2.0]).values, finger.finger.segment_length).tip
            for finger in station.fingers
            for angles in [recording[f"{finger.name}.sampled_joint_angles"]]
        ]
    )


@pytest.mark.slow
def test_cenic_and_discrete_plant_settle_at_the_same_tip():
    continuous = settled_tips("plant_config.time_step=0")
    for time_step in (0.01, 0.002):
        discrete = settled_tips(f"plant_config.time_step={time_step}")
        assert np.abs(discrete - continuous).max() < 1e-4


def test_infeasible_time_step_is_refused_with_both_numbers():
    scenario = free_bending([0.0], 0.1, "plant_config.time_step=0.0135")
    limit = r"0\.0135: .*stable_time_step\(\) = 0\.013 s of finger 'left_finger'"
    with pytest.raises(InputError, match=limit):
        make_station(scenario)


def test_divergence_names_time_state_and_cause():
    explicit = (
        "plant_config.time_step=0",
        "simulator_config.integration_scheme=explicit_euler",
        "simulator_config.use_error_control=false",
    )
    with pytest.raises(SimulationDivergedError) as caught:
        simulate(free_bending([150e3], 1.0, *explicit))
    message = str(caught.value)
    assert "the simulation diverged before t = 0." in message
    assert "in state left_finger_" in message
    assert "likely cause: a time step too long" in message


FINGERS = ("left_finger", "right_finger")
IMPLICIT = [f"models.{finger}.springs=implicit" for finger in FINGERS]
WAYS = ("bending", "bending sideways twist", "bending sideways twist stretch")


def of_both(field, value):
    return [f"models.{finger}.fingers.all.{field}={value}" for finger in FINGERS]


@pytest.mark.parametrize("ways", WAYS)
def test_they_rest_where_linear_springs_do(ways):
    """Up to the regularisation of Drake's solver, in the plane and across it.

    Without the layer, whose stretch it would not solve as stiff as it is.
    """
    soft = [*of_both("layer_thickness", 0), *of_both("layer_modulus", 0), *of_both("chamber_center", -3e-3)]
    common = [*soft, *of_both("yields", ways), *of_both("relaxation_time", 0.02), "gravity=[1.0, 2.0, -6.0]"]
    linear, implicit = (simulate(free_bending([10e3], 4.0, *common, *more)) for more in ((), IMPLICIT))
    tips = [recording["left_finger.true_tip_position"].values[-1] for recording in (linear, implicit)]
    np.testing.assert_allclose(tips[1], tips[0], atol=1e-4)


@pytest.mark.parametrize("ways", WAYS)
@pytest.mark.parametrize("relaxation_time", [0.0, 1e-3])
def test_a_step_is_never_too_long(ways, relaxation_time, caplog):
    """Where it is too long for linear springs, implicit ones are chosen, and that is said."""
    little = [*of_both("yields", ways), *of_both("relaxation_time", relaxation_time)]
    with refused("time_step", 0.01):
        make_station(free_bending([80e3], 1.0, *little, *(f"models.{finger}.springs=linear" for finger in FINGERS)))
    with caplog.at_level("WARNING"):
        recording = simulate(free_bending([80e3, 0.0], 1.0, *little))
    assert "springs are implicit" in caplog.text
    bend = recording["left_finger.sampled_joint_angles"].values.sum(axis=-1)
    assert np.abs(bend).max() < np.radians(120)  # the bend at rest is 60 degrees


def test_they_need_a_discrete_plant():
    with refused("springs", "implicit"):
        make_station(free_bending([80e3], 1.0, "plant_config.time_step=0", *IMPLICIT))


class Motion(NamedTuple):
    """What every step of a simulation left behind."""

    time: np.ndarray  # (T) s
    velocities: np.ndarray  # (T, joints) rad/s
    kinetic: np.ndarray  # (T) J
    energy: np.ndarray  # (T) J, kinetic, gravity and springs


def release(system, plant, config, angle):
    """One second of motion from rest, all joints at `angle` rad."""
    simulator = Simulator(system)
    ApplySimulatorConfig(config, simulator)
    context = plant.GetMyMutableContextFromRoot(simulator.get_mutable_context())
    plant.SetPositions(context, np.full(plant.num_positions(), angle))
    steps = []

    def watch(root):
        context = plant.GetMyContextFromRoot(root)
        kinetic, potential = plant.CalcKineticEnergy(context), plant.CalcPotentialEnergy(context)
        steps.append((root.get_time(), plant.GetVelocities(context), kinetic, kinetic + potential))

    simulator.set_monitor(watch)
    simulator.Initialize()
    simulator.AdvanceTo(1.0)
    return Motion(*map(np.array, zip(*steps, strict=True)))


def free_decay(time_step):
    """A station whose fingers swing under their weight, without pressure, and its motion."""
    scenario = free_bending([0.0], 1.0, f"plant_config.time_step={time_step}")
    station = make_station(scenario)
    return station, release(station.diagram, station.plant, solver_config(scenario), angle=0.15)


@pytest.mark.parametrize("time_step", [0.01, 0.002, 0.0])
def test_energy_never_rises_in_free_decay(time_step):
    """The slowest mode, of natural frequency w, is damped at the rate beta w^2 / 2, and its energy at twice that."""
    station, motion = free_decay(time_step)
    rounding = 1e-9 * (motion.energy[0] - motion.energy[-1])
    assert np.diff(motion.energy).max() < rounding
    finger = station.fingers[0].finger
    slowest = np.linalg.eigvals(np.linalg.solve(finger.mass_matrix(), np.diag(finger.stiffness))).real.min()
    since = motion.time[-1] - motion.time[motion.kinetic.argmax()]
    remains = np.exp(-finger.relaxation_time * slowest * since)
    assert motion.kinetic[-1] < remains * motion.kinetic.max()


@pytest.mark.slow
def test_undamped_finger_keeps_its_energy(finger_plant):
    plant = finger_plant(uniform_finger(4, relaxation_time=0.0))
    plant.mutable_gravity_field().set_gravity_vector([0.0, 0.0, -9.81])
    accurate = SimulatorConfig(integration_scheme="runge_kutta5", accuracy=1e-6, max_step_size=0.01)
    motion = release(plant, plant, accurate, angle=0.25)
    assert np.ptp(motion.energy) < 1e-3 * motion.kinetic.max()


@pytest.mark.slow
def test_energy_that_is_lost_is_what_the_damping_takes():
    station, motion = free_decay(0.0005)
    damping = np.concatenate([finger.finger.damping for finger in station.fingers])
    taken = trapezoid(motion.velocities**2 @ damping, motion.time)
    assert taken == pytest.approx(motion.energy[0] - motion.energy[-1], rel=0.01)
