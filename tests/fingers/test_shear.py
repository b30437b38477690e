"""A finger that shears, in Drake's plant: Timoshenko's cantilever, and blocks that need not know."""

from dataclasses import replace

import numpy as np
import pytest
from pydrake.multibody.tree import JacobianWrtVariable, MultibodyForces

from soft_gripper.fingers.cross_section import CrossSection
from soft_gripper.fingers.finger import Finger
from soft_gripper.fingers.plant_finger import PlantFinger

KAPPA = 0.857  # Cowper (1966) for a rectangle: 10 (1 + nu) / (12 + 11 nu), nu = 1 / 2
SIDE, MODULUS = 0.02, 3e5  # m, Pa
FORCE = 1e-4  # N


def bar(thicknesses, segments):
    """Solid rubber, so many thicknesses long."""
    section = CrossSection(SIDE, SIDE, MODULUS, 1000.0)
    return Finger("bar", thicknesses * SIDE, section, section, 0.018, segments, 0.0065, shear_factor=KAPPA)


def spring_forces(plant, q):
    context, forces = plant.CreateDefaultContext(), MultibodyForces(plant)
    plant.SetPositions(context, q)
    plant.CalcForceElementsContribution(context, forces)
    return plant.CalcGeneralizedForces(context, forces)


def deflection(finger, plant):
    """Of the tip of a straight finger under FORCE across it, m, by the springs in Drake and its Jacobian."""
    small, context = 1e-6, plant.CreateDefaultContext()
    columns = [spring_forces(plant, small * direction) / -small for direction in np.eye(plant.num_positions())]
    tip, world = plant.GetFrameByName(f"{finger.name}_tip"), plant.world_frame()
    wrt = JacobianWrtVariable.kV
    (across, _, _) = plant.CalcJacobianTranslationalVelocity(context, wrt, tip, np.zeros(3), world, world)
    return float(across @ np.linalg.solve(np.column_stack(columns), across * FORCE))


def book(thicknesses):
    """P L^3 / (3 E I) of bending and P L / (kappa G A) of shear, m."""
    length = thicknesses * SIDE
    bending = FORCE * length**3 / (3 * MODULUS * SIDE**4 / 12)
    return bending, FORCE * length / (KAPPA * MODULUS / 3 * SIDE**2)


@pytest.mark.parametrize("thicknesses", [1.0, 3.3, 10.0])
def test_a_cantilever_converges_to_timoshenkos(finger_plant, thicknesses):
    expected = sum(book(thicknesses))
    fingers = [bar(thicknesses, segments) for segments in (5, 10, 20)]
    errors = [deflection(finger, finger_plant(finger)) / expected - 1 for finger in fingers]
    np.testing.assert_allclose(np.divide(errors[:-1], errors[1:]), 4, rtol=0.01)
    assert abs(errors[-1]) < 1e-3


def test_springs_of_shear_are_linear_and_leave_bending_alone(tapered_finger, finger_plant):
    finger = replace(tapered_finger, shear_factor=KAPPA)
    plant = finger_plant(finger)
    robot = PlantFinger(finger, plant, plant.GetModelInstanceByName("robot"))
    bending = [joint.position_start() for joint in robot.joints]
    shear = [plant.GetJointByName(f"tapered_shear_{i}").position_start() for i in range(5)]
    assert sorted(bending + shear) == list(range(10))
    q = np.zeros(10)
    q[bending], q[shear] = 0.1, np.linspace(-5e-3, 5e-3, 5)
    section = finger.section(finger.joint_arc_lengths)
    stiffness = KAPPA * section.youngs_modulus / 3 * section.area / finger.segment_length
    forces = spring_forces(plant, q)
    np.testing.assert_allclose(forces[shear], -stiffness * q[shear], rtol=1e-9, atol=1e-12)
    np.testing.assert_allclose(forces[bending], -0.1 * finger.stiffness, rtol=1e-6)
    damping = [plant.GetJointByName(f"tapered_shear_{i}").default_damping() for i in range(5)]
    np.testing.assert_allclose(damping, 0.0065 * stiffness, rtol=1e-12)
