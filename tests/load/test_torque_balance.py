"""The external torque of a moving finger, compared with Drake's inverse dynamics and with balances known by hand."""

import xml.etree.ElementTree as ET
from dataclasses import replace

import numpy as np
import pytest
from finger_motion import TILTED, Y, at_rest, bend, chamber_pressure, moving, position, turn
from pydrake.math import RigidTransform, RotationMatrix
from pydrake.multibody.math import SpatialVelocity
from pydrake.multibody.tree import MultibodyForces

from soft_gripper.fingers.finger_element import FingerElement
from soft_gripper.fingers.finger_links import finger_to_urdf, joint_name
from soft_gripper.fingers.finger_parts import ElasticLaw, TipLoad
from soft_gripper.load.force_estimator import TorqueBalance

GRAVITY = np.array([1.0, -2.0, -9.0])  # m/s^2
NO_GRAVITY = np.zeros(3)
TIME = 0.3  # s
LAW = ElasticLaw(curvature=(-30.0, 0.0, 30.0), base_moment=(-0.5, 0.0, 0.2), tip_moment=(-0.2, 0.0, 0.3))


def external(finger, axis, period):
    """External torque of the finger in motion around TIME."""
    return TorqueBalance(finger).external_torque(moving(finger, axis, TIME, period), GRAVITY, period)


@pytest.fixture
def inverse_dynamics(load_plant):
    """Drake's torques at the joints that pressure does not explain, of the motion at TIME; (N,) N m."""

    def solve(finger, axis):
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

        q, qdot, qddot = (bend(finger.segments, TIME, order) for order in range(3))
        vdot = move(alpha, position(TIME, 2), qddot)
        plant.SetFreeBodyPose(context, palm, RigidTransform(RotationMatrix(R), position(TIME)))
        for joint, angle in zip(joints, q, strict=True):
            joint.set_angle(context, angle)
        move(w, position(TIME, 1), qdot)
        forces = MultibodyForces(plant)
        plant.CalcForceElementsContribution(context, forces)
        torque = plant.CalcInverseDynamics(context, vdot, forces)
        starts = [joint.velocity_start() for joint in joints]
        return torque[starts] + finger.stiffness * q - chamber_pressure(TIME) * finger.pressure_gain

    return solve


@pytest.mark.parametrize("load", [None, TipLoad(0.01, 0.015, -0.004)])
@pytest.mark.parametrize("segments", [1, 2, 5, 12])
def test_converges_to_drakes_inverse_dynamics(tapered_finger, inverse_dynamics, segments, load):
    """At every joint with the square of the period, for any motion of the base in the plane of bending."""
    finger = replace(tapered_finger, relaxation_time=0.0, segments=segments, tip_load=load)
    truth = inverse_dynamics(finger, Y)
    errors = np.array([external(finger, Y, period).torque - truth for period in (2e-3, 1e-3, 5e-4)])
    assert abs(truth[0]) > 0.01
    assert (np.abs(errors[-1]) < 1e-4 * np.abs(truth) + 1.5e-5 * np.abs(truth).max()).all()
    np.testing.assert_allclose(errors[:-1] / errors[1:], 4.0, rtol=0.02)


def test_damping_is_taken_a_quarter_of_a_period_late_and_tolerated_as_much_both_ways(tapered_finger):
    period, undamped = 1e-3, replace(tapered_finger, relaxation_time=0.0)
    damped, free = external(tapered_finger, Y, period), external(undamped, Y, period)
    torque, tolerance = damped.torque - free.torque, damped.tolerance - free.tolerance
    rates, changes = bend(5, TIME + period / 4, 1), bend(5, TIME, 2) * period / 4
    np.testing.assert_allclose(torque, tapered_finger.damping * rates, rtol=5e-4)
    np.testing.assert_allclose(tolerance, np.abs(tapered_finger.damping * changes), rtol=5e-4)


@pytest.mark.parametrize("law", [None, LAW], ids=["linear", "law"])
def test_at_rest_it_is_what_the_static_balance_lacks(tapered_finger, bent, drake_weight, law):
    """Whatever the shape: elastic torque less what drives the finger and Drake's weight."""
    finger, R = replace(tapered_finger, elastic_law=law), turn(TILTED, TIME)[0]
    for q, driving in zip(bent(20, 5), 0.1 * bent(20, 5), strict=True):
        known = driving + drake_weight(finger, q, R.T @ GRAVITY)
        found = TorqueBalance(finger).external_torque(at_rest(finger, q, driving, R), GRAVITY, 0.01)
        torque, tolerance = found.torque, found.tolerance
        np.testing.assert_allclose(torque, finger.elastic_torque(q) - known, atol=1e-11)
        np.testing.assert_allclose(tolerance, 0.0, atol=1e-11)


def test_what_drives_a_finger_may_change(shipped_finger):
    balance, still = TorqueBalance(shipped_finger), at_rest(shipped_finger, np.zeros(12))
    for change in (-40e3, 40e3):
        changing = still._replace(driving=shipped_finger.pressure_torque(change * np.array([0.0, 0.0, 0.0, 0.5, 1.0])))
        tolerance = balance.external_torque(changing, NO_GRAVITY, 0.01).tolerance
        np.testing.assert_allclose(tolerance, 0.15 * 40e3 * shipped_finger.pressure_gain, rtol=1e-9)
