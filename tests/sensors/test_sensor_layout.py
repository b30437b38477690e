"""Layouts of sensors: paths, responses, and bends from readings."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from refusals import refused

from soft_gripper.errors import InputError
from soft_gripper.fingers.kinematics import forward_kinematics, sensor_path
from soft_gripper.sensors.measurement import UNKNOWN
from soft_gripper.sensors.response_curve import CalibratedResponse, ResponseCurve
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


NOISE = 1e-4
CURVE = ResponseCurve(((0.5, -0.6), (0.9, -0.1), (1.0, 0.0), (1.5, 0.3)))
LAYOUTS = {
    "one": {"sections": 1},
    "four": {"sections": 4},
    "unequal": {"sections": 3, "borders": (0.25, 0.4)},
    "one-sided": {"sections": 4, "one_sided": True},
    "curved response": {"sections": 3, "response": CURVE},
    "a section a joint": {"sections": 12},
}


@pytest.fixture(params=LAYOUTS.values(), ids=LAYOUTS)
def divided(request, shipped_finger):
    return SensorLayout(shipped_finger, **request.param)


def readings(divided, q):
    return divided.response.reading(extension_ratios(divided, q))


def by_path(divided, values):
    return values.reshape(*values.shape[:-1], divided.paths, divided.sections)


@pytest.mark.parametrize("degrees", [-270.0, -90.0, -1.0, 0.0, 30.0, 180.0, 270.0])
def test_joints_that_bend_alike_are_found_exactly(divided, degrees):
    """By both paths together, and by each alone."""
    q = np.full(12, np.radians(degrees) / 12)
    read = readings(divided, q)
    np.testing.assert_allclose(divided.linear(read, NOISE).values, divided.sums(q), rtol=0, atol=1e-9)
    for path in range(divided.paths):
        alone = by_path(divided, np.full_like(read, np.nan))
        alone[path] = by_path(divided, read)[path]
        found = divided.linear(alone.reshape(-1), NOISE)
        np.testing.assert_allclose(found.values, divided.sums(q), rtol=0, atol=1e-9)
        assert (found.variance < UNKNOWN).all()


@pytest.mark.parametrize("missing", [np.nan, np.inf, -np.inf])
def test_a_section_that_reads_nothing_is_unknown_and_no_other(divided, missing):
    read = readings(divided, np.full(12, 0.1))
    known = divided.linear(read, NOISE)
    spoiled = by_path(divided, read.copy())
    spoiled[:, -1] = missing
    found = divided.linear(spoiled.reshape(-1), NOISE)
    assert (found.values[-1], found.variance[-1]) == (0.0, UNKNOWN)
    np.testing.assert_array_equal(found.values[:-1], known.values[:-1])
    np.testing.assert_array_equal(found.variance[:-1], known.variance[:-1])


@pytest.mark.parametrize("lost", [None, 0, 1])
def test_variance_is_that_of_noisy_readings(shipped_finger, lost):
    """About a nearly straight finger, with both paths or either; 20 000 samples have it within 5 %."""
    divided = SensorLayout(shipped_finger, 3, borders=(0.25, 0.4))
    ratios = extension_ratios(divided, np.full(12, 0.01))
    ratios = ratios + NOISE * np.random.default_rng(7).standard_normal((20_000, divided.readings))
    if lost is not None:
        by_path(divided, ratios)[:, lost] = np.nan
    found = divided.linear(divided.response.reading(ratios), NOISE)
    np.testing.assert_allclose(found.values.var(axis=0), found.variance[0], rtol=0.05)
    np.testing.assert_allclose(found.values.mean(axis=0), divided.sums(np.full(12, 0.01)), atol=2e-4)


@pytest.mark.parametrize("angle", [0.0, 0.1])
def test_a_path_on_the_neutral_axis_reads_nothing(shipped_finger, angle):
    divided = SensorLayout(replace(shipped_finger, sensor_spacing=2 * float(shipped_finger.tip.neutral_axis)), 2)
    assert divided.offsets[0] == 0
    q = np.full(12, angle)
    np.testing.assert_allclose(divided.linear(readings(divided, q), NOISE).values, divided.sums(q), atol=1e-9)
    lost = readings(divided, q)
    lost[2:] = np.nan
    assert (divided.linear(lost, NOISE).variance == UNKNOWN).all()


@pytest.mark.parametrize("wild", [-1.0, -0.9, 5.0, 100.0])
def test_readings_that_no_bend_has_give_finite_bends(shipped_finger, wild):
    divided = SensorLayout(shipped_finger, 4)
    found = divided.linear(np.full(8, wild), NOISE)
    assert (np.abs(found.values) <= 2 * np.pi * divided.joints_per_section).all()


@pytest.mark.parametrize(
    "points",
    [
        [],
        [[1.0, 0.0]],
        [[1.0, 0.0], [1.0, 1.0]],
        [[1.0, 0.0], [2.0, 0.0]],
        [[2.0, 0.0], [1.0, 1.0]],
        [[1.0, 0.0], [2.0, float("nan")]],
        [[1.0, 0.0], [2.0]],
        [[1.0, 0.0, 2.0], [1.0, 3.0, 2.0]],
    ],
    ids=str,
)
def test_what_is_no_curve(points):
    with pytest.raises(InputError) as caught:
        ResponseCurve(points)
    assert str(caught.value).startswith(f"sensor: response = {points!r}: give at least two finite [")


def test_a_calibrated_response_and_its_inverse():
    response = CalibratedResponse(ResponseCurve(((0.9, -0.3), (1.0, 0.0), (1.1, 0.2))), (1.1, 0.9), (0.01, -0.01))
    reading = response.reading(np.array([[1.0, 1.1], [0.95, 1.0]]))
    np.testing.assert_allclose(reading, [[0.02, 0.16], [-0.135, -0.03]], rtol=0, atol=1e-14)
    np.testing.assert_allclose(response.ratio(reading), [[1.0, 1.1], [0.95, 1.0]], rtol=0, atol=1e-14)


def test_a_curvature_is_undone_and_does_not_fold():
    response = CalibratedResponse(ResponseCurve(), (1.1, 0.9), (0.01, -0.01), curvature=-0.3)
    ratios = np.array([[1.0, 1.5], [0.7, 1.01]])
    strain = ratios - 1
    expected = np.array([1.1, 0.9]) * (strain - 0.3 * strain**2) + [0.01, -0.01]
    np.testing.assert_allclose(response.reading(ratios), expected, rtol=0, atol=1e-14)
    np.testing.assert_allclose(response.ratio(expected), ratios, rtol=0, atol=1e-14)
    assert np.isfinite(response.ratio(np.array([10.0, 10.0]))).all()


def test_it_fits_a_layout_of_as_many_readings(shipped_finger):
    response = CalibratedResponse(ResponseCurve(), (1.0,) * 4, (0.0,) * 4)
    assert SensorLayout(shipped_finger, 2, response=response).readings == 4
    with refused("gains", [1.0, 1.0, 1.0, 1.0]):
        SensorLayout(shipped_finger, 3, response=response)
