"""Energy is conserved without damping and only ever falls with it."""

from typing import NamedTuple

import numpy as np
import pytest
from finger_plants import free_bending, uniform_finger
from pydrake.systems.analysis import ApplySimulatorConfig, Simulator, SimulatorConfig
from scipy.integrate import trapezoid

from soft_gripper.diagrams.simulation import solver_config
from soft_gripper.diagrams.station import make_station


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


@pytest.mark.slow
def test_undamped_finger_keeps_its_energy(finger_plant):
    plant = finger_plant(uniform_finger(4, relaxation_time=0.0))
    plant.mutable_gravity_field().set_gravity_vector([0.0, 0.0, -9.81])
    accurate = SimulatorConfig(integration_scheme="runge_kutta5", accuracy=1e-6, max_step_size=0.01)
    motion = release(plant, plant, accurate, angle=0.25)
    assert np.ptp(motion.energy) < 1e-3 * motion.kinetic.max()


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
def test_energy_that_is_lost_is_what_the_damping_takes():
    station, motion = free_decay(0.0005)
    damping = np.concatenate([finger.finger.damping for finger in station.fingers])
    taken = trapezoid(motion.velocities**2 @ damping, motion.time)
    assert taken == pytest.approx(motion.energy[0] - motion.energy[-1], rel=0.01)
