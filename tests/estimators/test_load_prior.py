"""The prior of the load: the covariance of the torques that random forces along a finger have."""

from dataclasses import replace

import numpy as np
import pytest

from soft_gripper.estimators.mechanics import TIP_SHARE, SpatialMechanics, torque_covariance
from soft_gripper.estimators.uncertainty import Uncertainty
from soft_gripper.scenario.schema import SensorConfig
from soft_gripper.scenario.sensor_presets import sensor_layout

LOAD_PRESSURE = 1.5e5  # Pa


def test_covariance_is_that_of_forces_drawn_along_the_finger_and_on_the_tip(shipped_finger):
    """White noise of forces is added up by quadrature, not drawn: a force a cell, in 12 000 cells."""
    s, length, cells = shipped_finger.joint_arc_lengths, shipped_finger.length, 12_000
    x = (np.arange(cells) + 0.5) * length / cells
    levers = np.maximum(x - s[:, None], 0)
    along = levers @ levers.T
    along /= (x**2).sum()  # 1 at the base
    tip = np.outer(length - s, length - s) / length**2
    usual = LOAD_PRESSURE * shipped_finger.pressure_gain[0]
    expected = usual**2 * (TIP_SHARE * tip + (1 - TIP_SHARE) * along)
    np.testing.assert_allclose(torque_covariance(shipped_finger, LOAD_PRESSURE), expected, rtol=1e-6)


def test_a_third_of_the_variance_or_so_is_due_to_the_tip(shipped_finger):
    """At half of the length: 0.3 u^2 + 0.7 u^3, by hand."""
    finger = replace(shipped_finger, segments=3)  # the second of three joints lies in the middle
    usual = LOAD_PRESSURE * finger.pressure_gain[0]
    assert torque_covariance(finger, LOAD_PRESSURE)[1, 1] == pytest.approx((0.3 / 4 + 0.7 / 8) * usual**2)


@pytest.mark.parametrize("name", ["shipped_finger", "tapered_finger"])
def test_it_is_a_covariance(request, name):
    covariance = torque_covariance(request.getfixturevalue(name), LOAD_PRESSURE)
    np.testing.assert_array_equal(covariance, covariance.T)
    assert np.linalg.eigvalsh(covariance).min() > 0


def test_no_load_is_certain(shipped_finger):
    assert not torque_covariance(shipped_finger, 0.0).any()


def test_a_joint_that_slides_deviates_as_far_as_one_that_turns_moves_its_segment(shipped_finger):
    """The number of segments does not matter."""
    for segments in (6, 12):
        finger = replace(shipped_finger, segments=segments, yields=("bending", "stretch"))
        layout = sensor_layout(finger, SensorConfig(layout="four_faces", sections=2))
        ways, angle = layout.ways, 1e-3
        assert ways == ("bending", "stretch")
        stds = np.sqrt(np.diagonal(SpatialMechanics(layout, Uncertainty(angle=angle)).deviations))
        turned, slid = stds.reshape(2, segments)
        np.testing.assert_allclose(turned, angle)
        np.testing.assert_allclose(slid, angle * finger.length / segments)
