"""The maths of feeling: weight against Drake's, and known loads that are found again."""

from dataclasses import replace

import numpy as np
import pytest
from finger_plants import LENGTH, uniform_finger

from soft_gripper.external_torque import external_torque, free_bending_angles, gravity_torque, mean_joint_angles
from soft_gripper.finger import ElasticLaw
from soft_gripper.sensor_layout import SensorLayout

PRESSURE = 60e3  # Pa
LAW = ElasticLaw(curvature=(-30.0, 0.0, 30.0), base_moment=(-0.5, 0.0, 0.2), tip_moment=(-0.2, 0.0, 0.3))
SECTIONS = [1, 2, 3, 4, 6, 12]


@pytest.fixture
def weight(finger_plant):
    """Drake's torques of a finger's weight, by joint angles, rad, and gravity in B, (3,) m/s^2."""

    def evaluate(finger, q, gravity):
        plant = finger_plant(finger)
        plant.mutable_gravity_field().set_gravity_vector(gravity)
        context = plant.CreateDefaultContext()
        plant.SetPositions(context, q)
        return plant.CalcGravityGeneralizedForces(context)

    return evaluate


def in_plane(gravity):
    """z + i x of a vector in B."""
    return complex(gravity[2], gravity[0])


def under_load(finger, torque):
    """Joint angles of a finger at PRESSURE in balance with external torques, rad, without weight."""
    return (torque + PRESSURE * finger.pressure_gain) / finger.stiffness


def felt(finger, sections, q):
    """External torque that sensors find in the bends of their sections, without weight."""
    layout = SensorLayout(finger, sections)
    theta = np.add.reduceat(q, layout.section_ends[:-1])
    return external_torque(layout, theta, np.array(PRESSURE), 0.0)


def from_force(s, where, force):
    """Torque of a force, N, that presses across a straight finger at `where`, m, on its joints at `s`, m."""
    return force * np.maximum(where - s, 0)


@pytest.mark.parametrize("gravity", [[0, 0, -9.81], [0, 0, 9.81], [9.81, 0, 0], [3.0, -5.0, 7.0]], ids=str)
def test_weight_is_that_of_drake(tapered_finger, bent, weight, gravity):
    shapes = 2 * bent(20, 5)
    torques = gravity_torque(tapered_finger, shapes, in_plane(gravity))
    for q, torque in zip(shapes, torques, strict=True):
        np.testing.assert_allclose(torque, weight(tapered_finger, q, gravity), atol=1e-15)


@pytest.mark.parametrize("law", [None, LAW], ids=["linear", "law"])
def test_a_sensor_a_joint_finds_what_the_balance_lacks(tapered_finger, bent, weight, law):
    """Whatever the shape: elastic torque less those of the pressure and of Drake's weight."""
    finger, gravity = replace(tapered_finger, elastic_law=law), [-4.0, 1.0, -8.0]
    layout = SensorLayout(finger, finger.segments)
    for q in bent(20, 5):
        known = PRESSURE * finger.pressure_gain + weight(finger, q, gravity)
        torque = external_torque(layout, q, np.array(PRESSURE), in_plane(gravity))
        np.testing.assert_allclose(torque, finger.elastic_torque(q) - known, atol=1e-14)


@pytest.mark.parametrize("sections", SECTIONS)
def test_force_at_the_tip_is_found_exactly(sections):
    """Its torque falls straight from base to tip, which is what any number of sensors can tell."""
    finger = uniform_finger(12)
    torque = from_force(finger.joint_arc_lengths, LENGTH, -0.3)
    np.testing.assert_allclose(felt(finger, sections, under_load(finger, torque)), torque, rtol=1e-10)


@pytest.mark.parametrize("where", [0.05, 0.075, 0.1])
def test_force_between_base_and_tip_is_found_better_by_more_sensors(where):
    finger = uniform_finger(12)
    torque = from_force(finger.joint_arc_lengths, where, -0.5)
    q = under_load(finger, torque)
    errors = [np.abs(felt(finger, sections, q) - torque).max() for sections in (1, 2, 4, 12)]
    assert sorted(errors, reverse=True) == errors
    assert errors[-1] < 1e-14


@pytest.mark.parametrize("sections", SECTIONS)
def test_nothing_is_found_where_nothing_is(sections):
    finger = uniform_finger(12)
    assert np.abs(felt(finger, sections, free_bending_angles(finger, np.array(PRESSURE)))).max() < 1e-14


def test_free_bending_is_pressure_torque_over_stiffness(tapered_finger):
    pressures = np.array([[-50e3, 0.0], [100e3, 200e3]])
    expected = pressures[..., None] * tapered_finger.pressure_gain / tapered_finger.stiffness
    np.testing.assert_allclose(free_bending_angles(tapered_finger, pressures), expected, rtol=1e-14)


def test_joints_share_the_bend_of_their_section(tapered_finger, bent):
    layout = SensorLayout(tapered_finger, 2)
    theta = bent(7, 2)
    q = mean_joint_angles(layout, theta)
    np.testing.assert_allclose(np.add.reduceat(q, layout.section_ends[:-1], axis=-1), theta, rtol=1e-15)
    assert [len(np.unique(row)) for row in q] == [2] * 7


def test_a_batch_is_its_samples(tapered_finger, bent):
    layout = SensorLayout(tapered_finger, 3)
    theta, pressure = bent(4, 2, 3), 1e5 * bent(4, 2)
    torque = external_torque(layout, theta, pressure, 1 - 9j)
    for index in np.ndindex(4, 2):
        alone = external_torque(layout, theta[index], pressure[index], 1 - 9j)
        np.testing.assert_allclose(torque[index], alone, rtol=1e-12, atol=1e-16)
