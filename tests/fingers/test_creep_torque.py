"""Creep: internal angles against integrals, and torques in a plant."""

import xml.etree.ElementTree as ET
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from finger_plants import uniform_finger
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import AddMultibodyPlantSceneGraph
from pydrake.systems.analysis import ApplySimulatorConfig, Simulator, SimulatorConfig
from pydrake.systems.framework import DiagramBuilder
from refusals import refused
from scipy.integrate import quad
from scipy.linalg import expm

from soft_gripper.diagrams.wiring.drive import add_pressure_drive
from soft_gripper.fingers.creep import CreepTorque, PressureSoftening, advance, memory_torque
from soft_gripper.fingers.finger_element import FingerElement
from soft_gripper.fingers.finger_links import finger_to_urdf
from soft_gripper.fingers.finger_parts import CreepBranch, PressureLaw
from soft_gripper.fingers.plant_finger import PlantFinger
from soft_gripper.scenario.schema import PressureConfig

BRANCHES = (CreepBranch(0.2, 0.3), CreepBranch(0.1, 4.0))
PRESSURE = 100e3  # Pa
TIMES = [0.1, 0.2, 0.4, 0.8, 1.6, 3.2, 6.4, 12.8]  # s
CENIC = SimulatorConfig(integration_scheme="cenic", max_step_size=0.01, accuracy=1e-5)


class Creeping:
    """A finger with its drive, without gravity; all joints begin at `q` and all internal angles at `z` rad."""

    def __init__(self, finger, time_step, q=0.0, z=0.0, pressure=0.0):
        builder = DiagramBuilder()
        plant, _ = AddMultibodyPlantSceneGraph(builder, time_step)
        self.plant, robot = plant, ET.Element("robot", name="robot")
        robot.extend(finger_to_urdf(FingerElement(finger, "world")))
        (model,) = Parser(plant).AddModelsFromString(ET.tostring(robot, encoding="unicode"), "urdf")
        plant.mutable_gravity_field().set_gravity_vector([0.0, 0.0, 0.0])
        plant.Finalize()
        drive = add_pressure_drive(builder, [PlantFinger(finger, plant, model)], PressureConfig(time_constant=0.0))
        builder.ExportInput(drive.commands[finger.name], "pressure")
        self.diagram = builder.Build()
        self.simulator = Simulator(self.diagram)
        if plant.time_step() == 0:
            ApplySimulatorConfig(CENIC, self.simulator)
        self.root = self.simulator.get_mutable_context()
        self.diagram.GetInputPort("pressure").FixValue(self.root, [pressure])
        self.context = plant.GetMyMutableContextFromRoot(self.root)
        angles = np.full(finger.segments, q)
        plant.SetPositions(self.context, angles)
        if finger.creep:
            creep = self.diagram.GetSubsystemByName(f"{finger.name}.creep")
            internal = np.full((len(finger.creep), finger.segments), z)
            creep.set_internal_angles(creep.GetMyMutableContextFromRoot(self.root), internal, angles)

    def angles(self, times):
        """Joint angles at times, s, (T, N) rad."""
        found = []
        for time in times:
            self.simulator.AdvanceTo(time)
            found.append(self.plant.GetPositions(self.context).copy())
        return np.array(found)


def creeping(segments, branches=BRANCHES):
    """Short, so that it has come to rest before it has crept."""
    return replace(uniform_finger(segments, relaxation_time=0.0065), length=0.03, creep=branches)


def solid(share, time, times):
    """Angle of a standard linear solid under a torque that began at 0, over the angle at once: in closed form."""
    return 1 + share / (1 - share) * (1 - np.exp(-(1 - share) * np.array(times) / time))


def exact_angle(finger, torque, times):
    """Of one joint, by the matrix exponential: M q'' + d q' + k q = torque + k sum share z, z' = (q - z) / time."""
    ((mass,),), (k,), (d,) = finger.mass_matrix(), finger.stiffness, finger.damping
    branches = len(finger.creep)
    rates = np.zeros((3 + branches, 3 + branches))  # of q, q', the internal angles, and 1
    rates[0, 1] = 1.0
    rates[1, :2], rates[1, -1] = (-k / mass, -d / mass), torque / mass
    for i, branch in enumerate(finger.creep, start=2):
        rates[1, i] = branch.share * k / mass
        rates[i, 0], rates[i, i] = 1 / branch.time, -1 / branch.time
    start = np.eye(3 + branches)[-1]
    return np.array([(expm(rates * time) @ start)[0] for time in times])


@pytest.mark.parametrize("time_step", [0.001, 0.005, 0.0])
@pytest.mark.parametrize("share", [0.1, 0.5])
def test_a_finger_that_is_bent_at_once_creeps_as_a_standard_linear_solid(time_step, share):
    finger = creeping(1, (CreepBranch(share, 10.0),))  # slower by far than the damping
    at_once = (finger.pressure_torque(PRESSURE) / finger.stiffness)[0]
    angles = Creeping(finger, time_step, q=at_once, pressure=PRESSURE).angles(TIMES)[:, 0]
    np.testing.assert_allclose(angles, at_once * solid(share, 10.0, TIMES), rtol=1e-3)


@pytest.mark.slow
@pytest.mark.parametrize("time_step", [0.001, 0.0])
@pytest.mark.parametrize("branches", [(), BRANCHES[:1], BRANCHES])
def test_a_step_of_pressure_is_followed_as_by_the_equation_of_motion(time_step, branches):
    finger = creeping(1, branches)
    angles = Creeping(finger, time_step, pressure=PRESSURE).angles(TIMES)[:, 0]
    np.testing.assert_allclose(angles, exact_angle(finger, finger.pressure_torque(PRESSURE)[0], TIMES), rtol=1e-3)


@pytest.mark.parametrize("time_step", [0.005, 0.0])
def test_a_widening_chamber_multiplies_what_creeps_too(time_step):
    """Held, by the share of a linear finger; emptied, what stays is of the pressure and not of the bend."""
    share, time, widens = 0.2, 1.0, 3.0
    law = PressureLaw((0.0, 0.5 * PRESSURE, PRESSURE), (0.0, 0.5 * PRESSURE, widens * PRESSURE))
    finger = replace(creeping(1, (CreepBranch(share, time),)), pressure_law=law)
    by_chamber = PRESSURE * finger.pressure_gain[0] / finger.stiffness[0]
    held = Creeping(finger, time_step, q=widens * by_chamber, pressure=PRESSURE)
    times = np.array([0.5, 1.0, 12.0])
    crept = widens * by_chamber * solid(share, time, times)
    np.testing.assert_allclose(held.angles(times)[:, 0], crept, rtol=2e-3)
    held.diagram.GetInputPort("pressure").FixValue(held.root, [0.0])
    left = share * by_chamber / (1 - share) * np.exp(-(1 - share) * np.array([0.5, 1.0]) / time)
    np.testing.assert_allclose(held.angles([12.5, 13.0])[:, 0], left, rtol=0.03)  # damped, it takes a moment to unbend


def test_softening_is_that_of_the_law_at_every_pressure():
    """Below no pressure, between all points and beyond them."""
    law = PressureLaw((-5e4, 0.0, 1e5, 2e5), (-4e4, 0.0, 1.05e5, 2.3e5))
    block, pressures = PressureSoftening(law), np.array([-9e4, -5e4, -0.5, 0.0, 0.9, 1.1, 7e4, 1e5, 1.7e5, 4e5])
    context, found = block.CreateDefaultContext(), []
    for pressure in pressures:
        block.get_input_port().FixValue(context, [pressure])
        found.append(block.get_output_port().Eval(context)[0])
    np.testing.assert_allclose(found, law.softening(pressures), rtol=1e-11)  # at 1 Pa, of what 50 kPa round off


def test_output_is_the_memory_torque_of_angles_that_are_linear_between_steps(finger_plant):
    finger = creeping(3)
    plant = finger_plant(finger, 0.004)
    block = CreepTorque(PlantFinger(finger, plant, plant.GetModelInstanceByName("robot")))
    context, angles = block.CreateDefaultContext(), np.random.default_rng(1).uniform(-0.4, 0.4, (30, 3))
    z = np.random.default_rng(2).uniform(-0.4, 0.4, (2, 3))
    block.set_internal_angles(context, z, angles[0])
    for before, after in zip(angles, [*angles[1:], None], strict=True):
        block.get_input_port().FixValue(context, np.append(before, np.zeros(3)))
        torque = block.get_output_port().Eval(context)
        np.testing.assert_allclose(torque, memory_torque(finger, z), atol=1e-12)
        if after is not None:
            context.SetDiscreteState(block.EvalUniquePeriodicDiscreteUpdate(context))
            z = advance(finger.creep, z, before, after, 0.004)


@pytest.mark.parametrize("time_step", [0.005, 0.0])
def test_energy_never_grows_in_a_finger_without_load(time_step):
    """That of the plant's own springs, less what the branches have given up: k sum share (z^2 / 2 - q z)."""
    finger = creeping(4)
    swinging = Creeping(finger, time_step, q=0.2)
    block = swinging.diagram.GetSubsystemByName("finger.creep")
    energies = []

    def watch(root):
        context = swinging.plant.GetMyContextFromRoot(root)
        q, state = swinging.plant.GetPositions(context), block.GetMyContextFromRoot(root)
        z = (state.get_discrete_state_vector() if time_step else state.get_continuous_state_vector()).CopyToVector()
        z = z.reshape(2, 4) + block._new_gain * q
        share = np.array([[0.2], [0.1]])
        memory = (share * finger.stiffness * (z**2 / 2 - q * z)).sum()
        energies.append(
            swinging.plant.CalcKineticEnergy(context) + swinging.plant.CalcPotentialEnergy(context) + memory
        )

    swinging.simulator.set_monitor(watch)
    swinging.simulator.Initialize()
    swinging.simulator.AdvanceTo(3.0)
    assert np.diff(energies).max() < 1e-9 * energies[0]
    assert energies[-1] < 0.01 * energies[0]


def test_the_stable_time_step_is_that_without_creep():
    """Creep takes stiffness away: near the limit a finger comes to rest, and above it the step is refused."""
    finger = creeping(4, (CreepBranch(0.5, 0.02), CreepBranch(0.2, 1.0)))
    limit = finger.stable_time_step()
    resting = Creeping(finger, 0.98 * limit, q=0.1).angles([10.0])
    assert np.abs(resting).max() < 1e-3
    with refused("time_step"):
        Creeping(finger, 1.02 * limit)


BRANCH_TIMES = np.array([[0.3], [4.0]])  # s, of the branches


@pytest.mark.parametrize("period", [1e-3, 1.0])
def test_internal_angles_are_exact_where_angles_are_linear_between_samples(period):
    """Against the integral of  exp(-(t - s) / time) q(s) / time , at the end of a path of 20 pieces."""
    angles = np.random.default_rng(1).standard_normal((21, 3))
    z, end = np.zeros((2, 3)), 20 * period
    for before, after in pairwise(angles):
        z = advance(BRANCHES, z, before, after, period)
    for branch, joint in np.ndindex(2, 3):
        time = BRANCH_TIMES[branch, 0]

        def kernel(s, time=time, joint=joint):
            return np.exp((s - end) / time) / time * np.interp(s, np.arange(21) * period, angles[:, joint])

        pieces = [quad(kernel, i * period, (i + 1) * period, epsabs=1e-15, epsrel=1e-13)[0] for i in range(20)]
        assert z[branch, joint] == pytest.approx(sum(pieces), abs=1e-12)


def test_the_step_is_right_from_a_ten_millionth_of_a_time_to_a_million_times():
    branches = tuple(CreepBranch(0.1, time) for time in (1e-6, 1e7))
    z = advance(branches, np.zeros((2, 1)), np.array([0.0]), np.array([1.0]), 1.0)
    np.testing.assert_allclose(z[:, 0], [1 - 1e-6, 0.5e-7], rtol=1e-7)


def test_leading_axes_are_free(tapered_finger):
    rng = np.random.default_rng(2)
    z, before, after = rng.standard_normal((4, 7, 2, 5)), rng.standard_normal((4, 7, 5)), rng.standard_normal((4, 7, 5))
    finger = replace(tapered_finger, creep=BRANCHES)
    later = advance(BRANCHES, z, before, after, 0.2)
    torque = memory_torque(finger, later)
    assert torque.shape == (4, 7, 5)
    np.testing.assert_array_equal(later[2, 3], advance(BRANCHES, z[2, 3], before[2, 3], after[2, 3], 0.2))
    expected = (0.2 * later[2, 3, 0] + 0.1 * later[2, 3, 1]) * finger.stiffness
    np.testing.assert_allclose(torque[2, 3], expected, rtol=1e-12)
