"""The residual of a moving finger, held against Drake's inverse dynamics and against balances known by hand."""

import xml.etree.ElementTree as ET
from dataclasses import replace

import numpy as np
import pytest
from finger_plants import uniform_finger
from pydrake.math import RigidTransform, RotationMatrix
from pydrake.multibody.math import SpatialVelocity
from pydrake.multibody.tree import MultibodyForces

from soft_gripper.contact_residual import BaseSection, Motion, contact_residual
from soft_gripper.external_torque import gravity_torque, mean_joint_angles
from soft_gripper.finger_element import FingerElement
from soft_gripper.finger_links import finger_to_urdf, joint_name
from soft_gripper.sensor_layout import SensorLayout

GRAVITY = np.array([1.0, -2.0, -9.0])  # m/s^2
TIME = 0.3  # s
Y = np.array([0.0, 1.0, 0.0])
TILTED = np.array([2.0, 1.0, -2.0]) / 3


def wave(time, order, size, rate, phase=0.0):
    """A sine of time, or its derivative of that order."""
    return size * rate**order * np.sin(rate * time + phase + order * np.pi / 2)


def position(time, order=0):
    """Of the base, m, (3,): some m/s^2."""
    return np.array([wave(time, order, 0.02, 13.0), wave(time, order, 0.01, 20.0, 1.0), wave(time, order, 0.03, 9.0)])


def turn(axis, time):
    """Rotation of the base about an axis that turns about another, with its angular velocity and acceleration."""
    spin, tilt = (lambda order: wave(time, order, 0.4, 9.0)), (lambda order: wave(time, order, 0.2, 7.0, 0.5))
    first = RotationMatrix(rotation(Y, spin(0)))
    carried = first.multiply(axis)
    w_first = Y * spin(1)
    w, alpha = w_first + carried * tilt(1), Y * spin(2) + carried * tilt(2) + np.cross(w_first, carried) * tilt(1)
    return first.matrix() @ rotation(axis, tilt(0)), w, alpha


def rotation(axis, angle):
    """Rodrigues' formula."""
    cross = np.cross(np.eye(3), axis)
    return np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross


def bend(sections, time, order=0):
    """Of the sections, rad, (S,)."""
    return wave(time, order, 0.25, 15.0 + 4 * np.arange(sections), np.arange(sections))


def pressure(time):
    return 60e3 + wave(time, 0, 30e3, 20.0)


def motion(layout, axis, period):
    """Five samples around TIME."""
    times = TIME + np.arange(-2, 3) * period
    X_WB = [np.column_stack([turn(axis, time)[0], position(time)]) for time in times]
    theta = [bend(layout.sections, time) for time in times]
    return Motion(np.array(theta), np.array([pressure(time) for time in times]), np.array(X_WB))


def at_rest(theta, pressure, R):
    """Five samples of a finger that does not move."""
    X_WB = np.column_stack([R, [1.0, 2.0, 3.0]])
    return Motion(np.tile(theta, (5, 1)), np.full(5, pressure), np.tile(X_WB, (5, 1, 1)))


def residual(layout, axis, period):
    return contact_residual(BaseSection(layout), motion(layout, axis, period), GRAVITY, period)


@pytest.fixture
def inverse_dynamics(load_plant):
    """Drake's torques at the joints that pressure does not explain, of the motion above; (N,) N m."""

    def solve(layout, axis):
        finger = layout.finger
        robot = ET.Element("robot", name="robot")
        ET.SubElement(robot, "link", name="palm")
        elements = finger_to_urdf(FingerElement(finger, "palm"))
        robot.extend(element for element in elements if "spring" not in element.tag)  # they are not quite linear
        plant = load_plant(ET.tostring(robot, encoding="unicode"))
        plant.mutable_gravity_field().set_gravity_vector(GRAVITY)
        context = plant.CreateDefaultContext()
        joints = [plant.GetJointByName(joint_name(finger.name, i)) for i in range(finger.segments)]
        palm = plant.GetBodyByName("palm")
        R, w, alpha = turn(axis, TIME)

        def move(angular, linear, rates):
            plant.SetFreeBodySpatialVelocity(context=context, body=palm, V_JpJc=SpatialVelocity(angular, linear))
            for joint, rate in zip(joints, rates, strict=True):
                joint.set_angular_rate(context, rate)
            return plant.GetVelocities(context)

        q, qdot, qddot = (mean_joint_angles(layout, bend(layout.sections, TIME, order)) for order in range(3))
        vdot = move(alpha, position(TIME, 2), qddot)
        plant.SetFreeBodyPose(context, palm, RigidTransform(RotationMatrix(R), position(TIME)))
        for joint, angle in zip(joints, q, strict=True):
            joint.set_angle(context, angle)
        move(w, position(TIME, 1), qdot)
        forces = MultibodyForces(plant)
        plant.CalcForceElementsContribution(context, forces)
        torque = plant.CalcInverseDynamics(context, vdot, forces)
        starts = [joint.velocity_start() for joint in joints]
        return torque[starts] + finger.stiffness * q - pressure(TIME) * finger.pressure_gain

    return solve


def base_mean(layout, torque):
    return torque[: layout.joints_per_section[0]].mean()


@pytest.mark.parametrize("sections", [1, 2, 5])
def test_converges_to_drakes_inverse_dynamics(tapered_finger, inverse_dynamics, sections):
    """With the square of the period, for any motion of the base in the plane of bending."""
    layout = SensorLayout(replace(tapered_finger, relaxation_time=0.0), sections)
    truth = base_mean(layout, inverse_dynamics(layout, Y))
    errors = [residual(layout, Y, period).torque - truth for period in (2e-3, 1e-3, 5e-4)]
    assert abs(truth) > 0.01
    assert abs(errors[-1]) < 1e-4 * abs(truth) + 1e-6
    np.testing.assert_allclose(np.divide(errors[:-1], errors[1:]), 4.0, rtol=0.02)


def test_damping_converges_with_the_period(tapered_finger, inverse_dynamics):
    layout = SensorLayout(tapered_finger, 2)
    truth = base_mean(layout, inverse_dynamics(layout, Y))
    errors = [residual(layout, Y, period).torque - truth for period in (5e-5, 2.5e-5)]
    assert errors[0] / errors[1] == pytest.approx(2.0, rel=0.01)
    assert abs(errors[1]) < 1e-4 * abs(truth)


def test_damping_is_taken_a_quarter_of_a_period_late_and_tolerated_as_much_both_ways(tapered_finger):
    period, undamped_finger = 1e-3, replace(tapered_finger, relaxation_time=0.0)
    damped, undamped = (SensorLayout(finger, 2) for finger in (tapered_finger, undamped_finger))
    torque, tolerance = np.subtract(residual(damped, Y, period), residual(undamped, Y, period))
    rates = mean_joint_angles(damped, bend(2, TIME + period / 4, 1))
    changes = mean_joint_angles(damped, bend(2, TIME, 2)) * period / 4
    assert torque == pytest.approx(base_mean(damped, tapered_finger.damping * rates), rel=5e-4)
    assert tolerance == pytest.approx(abs(base_mean(damped, tapered_finger.damping * changes)), rel=5e-4)


def test_turning_about_any_axis_is_found_but_for_the_thickness_of_the_links(shipped_finger, inverse_dynamics):
    layout = SensorLayout(shipped_finger, 4)
    truth = base_mean(layout, inverse_dynamics(layout, TILTED))
    assert abs(truth) > 0.05
    assert residual(layout, TILTED, 2e-4).torque == pytest.approx(truth, abs=1e-4)


def test_free_sway_is_not_felt():
    """All terms are smoothed alike: without damping, elastic torque and inertia cancel at any phase."""
    layout, period = SensorLayout(replace(uniform_finger(1), relaxation_time=0.0), 1), 0.01
    (stiffness,), ((inertia,),) = layout.finger.stiffness, layout.finger.mass_matrix()
    rate, size = np.sqrt(stiffness / inertia), 0.01  # rad/s, rad
    for phase in np.linspace(0, np.pi, 5):
        theta = size * np.cos(rate * period * np.arange(-2, 3) + phase)[:, None]
        swaying = at_rest([0.0], 0.0, np.eye(3))._replace(theta=theta)
        torque, _ = contact_residual(BaseSection(layout), swaying, 0 * GRAVITY, period)
        assert torque == pytest.approx(0, abs=1e-3 * stiffness * size)


@pytest.mark.parametrize("sections", [1, 3, 12])
def test_at_rest_it_is_what_the_static_balance_lacks(shipped_finger, bent, sections):
    layout, R = SensorLayout(shipped_finger, sections), turn(TILTED, TIME)[0]
    x, _, z = R.T @ GRAVITY
    for theta, p in zip(bent(5, sections), 1e5 * bent(5), strict=True):
        q = mean_joint_angles(layout, theta)
        known = p * shipped_finger.pressure_gain + gravity_torque(shipped_finger, q, complex(z, x))
        torque, tolerance = contact_residual(BaseSection(layout), at_rest(theta, p, R), GRAVITY, 0.01)
        assert torque == pytest.approx(base_mean(layout, shipped_finger.elastic_torque(q) - known), abs=1e-11)
        assert tolerance == pytest.approx(0.0, abs=1e-11)


def test_free_fall_takes_weight_away(shipped_finger):
    """Of a straight finger; the tolerance is then a tenth of the weight's torque."""
    section, period = BaseSection(SensorLayout(shipped_finger, 4)), 0.01
    resting = at_rest(np.zeros(4), 0.0, np.eye(3))
    fall = 0.5 * GRAVITY * (np.arange(5) * period)[:, None] ** 2
    falling = resting._replace(X_WB=np.dstack([resting.X_WB[:, :, :3], fall[:, :, None]]))
    weight, _ = contact_residual(section, resting, GRAVITY, period)
    torque, tolerance = contact_residual(section, falling, GRAVITY, period)
    assert abs(weight) > 1e-3
    assert torque == pytest.approx(0, abs=1e-12)
    assert tolerance == pytest.approx(0.1 * abs(weight), rel=1e-9)


@pytest.mark.parametrize("sections", [1, 5])
def test_mass_points_have_the_inertia_of_the_links(tapered_finger, sections):
    section = BaseSection(SensorLayout(tapered_finger, sections))
    joints = 5 // sections
    about_joints = section.levers[:, ::-1].cumsum(axis=-1)[:, ::-1]  # m, of each point about each joint, straight
    inertia = np.array([section.moments.sum(axis=-1) @ column for column in about_joints.T])
    np.testing.assert_allclose(inertia, tapered_finger.mass_matrix()[:joints].mean(axis=0), rtol=1e-12)


def test_pressure_that_changes_is_tolerated(shipped_finger):
    section, still = BaseSection(SensorLayout(shipped_finger, 4)), at_rest(np.zeros(4), 0.0, np.eye(3))
    for change in (-40e3, 40e3):
        changing = still._replace(pressure=change * np.array([0.0, 0.0, 0.0, 0.5, 1.0]))
        _, tolerance = contact_residual(section, changing, 0 * GRAVITY, 0.01)
        assert tolerance == pytest.approx(0.15 * 40e3 * shipped_finger.pressure_gain[:3].mean(), rel=1e-9)


def test_noise_of_the_strain_is_what_the_detector_says(shipped_finger):
    """0.24 mN m for 1e-4, which is a bend of rest length / spacing * sqrt(2) times as much."""
    layout, samples = SensorLayout(shipped_finger, 4), 4000
    scale = 1e-4 * layout.rest_lengths * np.sqrt(2) / shipped_finger.sensor_spacing
    theta = np.random.default_rng(2).standard_normal((samples, 5, 4)) * scale
    noisy = Motion(theta, np.zeros((samples, 5)), np.tile(np.eye(3, 4), (samples, 5, 1, 1)))
    torque, _ = contact_residual(BaseSection(layout), noisy, 0 * GRAVITY, 0.01)
    assert torque.std() == pytest.approx(0.24e-3, rel=0.05)


def test_a_batch_is_its_samples():
    layout = SensorLayout(uniform_finger(6), 3)
    motions = [motion(layout, TILTED, period) for period in (1e-3, 2e-3, 3e-3, 4e-3)]
    batch = Motion(*(np.array(field).reshape(2, 2, *field[0].shape) for field in zip(*motions, strict=True)))
    together = contact_residual(BaseSection(layout), batch, GRAVITY, 0.01)
    for i, alone in enumerate(motions):
        expected = contact_residual(BaseSection(layout), alone, GRAVITY, 0.01)
        found = [field[divmod(i, 2)] for field in together]
        np.testing.assert_allclose(found, expected, rtol=1e-12)
