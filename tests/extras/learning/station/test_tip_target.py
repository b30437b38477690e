"""TipTarget: on what the tip can reach, swinging as its parameters say."""

import numpy as np
import pytest

from soft_gripper.extras.learning.station import TipTarget
from soft_gripper.fingers.kinematics import as_points, forward_kinematics
from soft_gripper.fingers.statics import resting_angles

GRAVITY = 9.81 + 0j
LIMITS = (-20e3, 120e3)


@pytest.fixture(scope="module")
def target(shipped_finger):
    return TipTarget(shipped_finger, GRAVITY, LIMITS)


def tip(finger, pressure):
    return as_points(forward_kinematics(resting_angles(finger, pressure, GRAVITY), finger.segment_length).tip)


@pytest.mark.parametrize("time", [0.0, 0.5, 1.3])
def test_it_is_where_the_tip_rests_under_the_pressure_of_that_time(target, shipped_finger, time):
    context = target.CreateDefaultContext()
    target.swing(context, 50e3, 40e3, 2.0, 0.7)
    context.SetTime(time)
    pressure = 50e3 + 40e3 * np.sin(np.pi * time + 0.7)
    np.testing.assert_allclose(target.get_output_port().Eval(context), tip(shipped_finger, pressure), atol=2e-5)


def test_it_comes_back_after_a_period(target):
    context = target.CreateDefaultContext()
    target.swing(context, 50e3, 40e3, 2.0, 0.7)
    first = target.get_output_port().Eval(context)
    context.SetTime(2.0)
    np.testing.assert_allclose(target.get_output_port().Eval(context), first)
