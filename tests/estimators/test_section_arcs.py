"""Readings -> arcs -> joints, on circles and on the chain."""

from dataclasses import replace

import numpy as np
import pytest

from soft_gripper.estimators.arcs import arcs_from_readings, joints_on_arcs
from soft_gripper.fingers.kinematics import forward_kinematics
from soft_gripper.sensors.sensor_layout import SensorLayout, extension_ratios


@pytest.mark.parametrize("one_sided", [False, True])
def test_estimate_of_a_chain_converges_with_the_square_of_the_segment(shipped_finger, one_sided):
    bend, errors = 2.0, []
    for segments in (12, 24, 48):
        layout = SensorLayout(replace(shipped_finger, segments=segments), 4, one_sided)
        q = np.full(segments, bend / segments)
        arcs = arcs_from_readings(layout, extension_ratios(layout, q) - 1)
        joints = forward_kinematics(q, layout.finger.segment_length).joints
        errors.append((abs(arcs.tip_heading - bend), np.abs(joints_on_arcs(layout, arcs) - joints).max()))
    order = np.log2(np.divide(errors[:-1], errors[1:]))
    np.testing.assert_allclose(order, 2, atol=0.1)
