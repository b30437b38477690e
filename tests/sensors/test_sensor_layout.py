"""SensorLayout: which joints a sensor covers, and joint angles -> readings."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from soft_gripper.errors import InputError
from soft_gripper.fingers.kinematics import forward_kinematics, sensor_path
from soft_gripper.sensors.sensor_layout import SensorLayout, extension_ratios


def test_paths_lie_a_sensor_spacing_apart_as_deep_under_both_faces_of_the_thinner_end(shipped_finger):
    """One-sided, the inner one is not measured. Offsets are from the neutral axis."""
    two, one = SensorLayout(shipped_finger, 3), SensorLayout(shipped_finger, 3, one_sided=True)
    assert (two.paths, two.readings, one.paths, one.readings) == (2, 6, 1, 3)
    in_section = two.offsets + shipped_finger.tip.neutral_axis
    np.testing.assert_allclose(in_section, [0.0085, -0.0085], atol=1e-15)
    np.testing.assert_array_equal(one.offsets, two.offsets[1:])


def test_the_thinner_end_may_be_the_base(tapered_finger):
    turned = replace(tapered_finger, base=tapered_finger.tip, tip=tapered_finger.base)
    np.testing.assert_array_equal(SensorLayout(turned, 3).offsets, SensorLayout(tapered_finger, 3).offsets)


@pytest.mark.parametrize("sections", range(1, 13))
def test_each_joint_lies_inside_one_section(shipped_finger, sections):
    layout = SensorLayout(shipped_finger, sections)
    ends = np.concatenate([[0.0], np.cumsum(layout.rest_lengths)])
    begin, end = ends[layout.joint_sections], ends[layout.joint_sections + 1]
    s = shipped_finger.joint_arc_lengths
    assert ends[-1] == pytest.approx(0.12, rel=1e-14)
    assert np.all((begin < s) & (s < end))
    np.testing.assert_allclose(begin + layout.joint_fractions * (end - begin), s, rtol=1e-13)
    np.testing.assert_array_equal(np.bincount(layout.joint_sections), layout.joints_per_section)


@pytest.mark.parametrize("sections", [0, 13])
def test_impossible_sections(shipped_finger, sections):
    with pytest.raises(InputError, match=f"finger 'finger': sections = {sections}: give 1 to 12"):
        SensorLayout(shipped_finger, sections)


def test_ratios_are_those_of_the_sensor_paths(layout, bent):
    q = bent(12)
    chain = forward_kinematics(q, layout.finger.segment_length)
    expected = []
    for offset in layout.offsets:
        steps = np.abs(np.diff(sensor_path(chain, offset)))
        ends = 2 * layout.section_ends
        expected += [steps[a:b].sum() / (0.01 * (b - a) / 2) for a, b in pairwise(ends)]
    np.testing.assert_allclose(extension_ratios(layout, q), expected, rtol=1e-13)


def test_batch_is_the_loop(layout, bent):
    q = bent(2, 3, 12)
    ratios = extension_ratios(layout, q)
    for index in np.ndindex(2, 3):
        np.testing.assert_array_equal(ratios[index], extension_ratios(layout, q[index]))
