"""Elastic laws, and fingers that shear."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from finger_plants import free_bending
from pydrake.multibody.tree import JacobianWrtVariable, MultibodyForces

from soft_gripper.diagrams.simulation import simulate
from soft_gripper.fingers.cross_section import CrossSection
from soft_gripper.fingers.finger import Finger
from soft_gripper.fingers.finger_parts import ElasticLaw
from soft_gripper.fingers.plant_finger import PlantFinger
from soft_gripper.fingers.statics import elastic_law_block
from soft_gripper.models import DIRECTORY

LAW = ElasticLaw(
    curvature=(-50.0, -10.0, 5.0, 12.0, 40.0),
    base_moment=(-0.6, -0.1, 0.08, 0.1, 0.5),
    tip_moment=(-0.3, -0.1, 0.04, 0.09, 0.2),
)
STIFFENING = ([-0.3, -0.1, 0.0, 0.1, 0.3], [-0.5, -0.12, 0.0, 0.12, 0.5], [-0.44, -0.1, 0.0, 0.1, 0.44])  # rad, N m
PRESSURES = [210e3, 100e3, -50e3]
FINGERS = ("left_finger", "right_finger")


def with_law(text: str, law) -> str:
    """The text of a gripper file whose fingers get an elastic law."""
    columns = [column if isinstance(column, str) else " ".join(map(str, column)) for column in law]
    element = '<elastic_law angle="{}" base_torque="{}" tip_torque="{}"/>'.format(*columns)
    return text.replace("<sensors", element + "<sensors")


@pytest.fixture
def gripper(tmp_path):
    """Writes a shipped gripper with an elastic law beside the test."""

    def write(name: str, law) -> Path:
        (tmp_path / name).write_text(with_law((DIRECTORY / "grippers" / name).read_text(), law))
        return tmp_path / name

    return write


def at_joints(finger, base, tip):
    """What runs from base to tip, (M,) each, at every joint, (N, M)."""
    along = (np.arange(finger.segments)[:, None] + 0.5) / finger.segments
    return (1 - along) * np.array(base) + along * np.array(tip)


def straight_on(x, x_points, y_points):
    """np.interp, but with end pieces that go on."""
    slopes, far = np.diff(y_points) / np.diff(x_points), 1e3
    first, last = y_points[0] - far * slopes[0], y_points[-1] + far * slopes[-1]
    return np.interp(x, [x_points[0] - far, *x_points, x_points[-1] + far], [first, *y_points, last])


def run(file, *overrides):
    """Free bending with other fingers, and the ends of its PRESSURES, s."""
    files = [f"models.{i}.file={file}" for i in (0, 1)]
    return simulate(free_bending(PRESSURES, 1.0, *files, *overrides)), [1.0, 2.0, 3.0]


def test_block_is_what_turns_the_springs_into_the_law(tapered_finger):
    finger = replace(tapered_finger, elastic_law=LAW)
    block = elastic_law_block(finger)
    context = block.CreateDefaultContext()
    angles, laws = np.array(LAW.curvature) * 0.12 / 5, at_joints(finger, LAW.base_moment, LAW.tip_moment)
    for q in np.random.default_rng(1).uniform(-3, 3, (200, 5)):  # the points end at -1.2 and 0.96 rad
        block.GetInputPort("x").FixValue(context, q)
        law = [straight_on(angle, angles, torques) for angle, torques in zip(q, laws, strict=True)]
        torque = block.GetOutputPort("y").Eval(context)
        np.testing.assert_allclose(torque, finger.stiffness * q - law, atol=1e-12)


@pytest.mark.slow
def test_estimators_know_the_law(gripper):
    recording, ends = run(gripper("finger.urdf", STIFFENING), "plant_config.time_step=0.005")
    for finger in FINGERS:
        estimated = recording[f"{finger}.external_torque"].sel(time=ends, method="nearest")
        assert np.abs(estimated).max() < 2e-3


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
