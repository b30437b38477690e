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


def test_ratios_are_those_of_the_sensor_paths(layout, bent):
    q = bent(12)
    chain = forward_kinematics(q, layout.finger.segment_length)
    expected = []
    for offset in layout.offsets:
        steps = np.abs(np.diff(sensor_path(chain, offset)))
        ends = 2 * layout.section_ends
        expected += [steps[a:b].sum() / (0.01 * (b - a) / 2) for a, b in pairwise(ends)]
    np.testing.assert_allclose(extension_ratios(layout, q), expected, rtol=1e-13)


@pytest.mark.parametrize(
    ("borders", "ends"),
    [((0.25, 0.5), [0, 3, 6, 12]), ((0.3, 0.95), [0, 4, 11, 12]), ((1 / 3, 2 / 3), [0, 4, 8, 12])],
)
def test_borders_are_taken_to_the_nearest_end_of_a_segment(shipped_finger, borders, ends):
    layout = SensorLayout(shipped_finger, 3, borders=borders)
    assert layout.section_ends.tolist() == ends
    assert layout.joints_per_section.tolist() == np.diff(ends).tolist()
    np.testing.assert_allclose(layout.rest_lengths, 0.01 * np.diff(ends), rtol=1e-14)


@pytest.mark.parametrize(
    ("borders", "expected"),
    [
        ((0.5,), "give 2 increasing shares of the length"),
        ((0.5, 0.25), "give 2 increasing shares"),
        ((0.5, 0.51), "each at another end of 12 segments"),
        ((0.5, 0.99), "give 2 increasing shares"),
    ],
)
def test_impossible_borders(shipped_finger, borders, expected):
    with pytest.raises(InputError) as caught:
        SensorLayout(shipped_finger, 3, borders=borders)
    assert expected in caught.value.expected
    assert (caught.value.where, caught.value.field, caught.value.value) == ("sensor", "borders", borders)


@pytest.mark.parametrize("border", [np.nan, np.inf, "half", None])
def test_borders_are_numbers(shipped_finger, border):
    with pytest.raises(InputError) as caught:
        SensorLayout(shipped_finger, 3, borders=(0.5, border))
    assert (caught.value.where, caught.value.field) == ("sensor", "borders[1]")


@pytest.mark.parametrize("borders", [None, (0.25, 0.6)])
def test_sums_and_equal_shares_are_of_each_section(shipped_finger, bent, borders):
    layout, q = SensorLayout(shipped_finger, 3, borders=borders), bent(2, 5, 12)
    sums = layout.sums(q)
    for section, (begin, end) in enumerate(pairwise(layout.section_ends)):
        np.testing.assert_allclose(sums[..., section], q[..., begin:end].sum(axis=-1), atol=1e-15)
    shared = layout.shared_equally(sums)
    np.testing.assert_allclose(layout.sums(shared), sums, atol=1e-15)
    for begin, end in pairwise(layout.section_ends):
        assert (np.ptp(shared[..., begin:end], axis=-1) == 0).all()
