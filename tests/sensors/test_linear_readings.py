"""The bend of sections from readings: exact for joints bent alike, with whatever paths read anything, and how sure."""

from dataclasses import replace

import numpy as np
import pytest

from soft_gripper.sensors.measurement import UNKNOWN
from soft_gripper.sensors.response_curve import ResponseCurve
from soft_gripper.sensors.sensor_layout import SensorLayout, extension_ratios

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
def layout(request, shipped_finger):
    return SensorLayout(shipped_finger, **request.param)


def readings(layout, q):
    return layout.response.reading(extension_ratios(layout, q))


def by_path(layout, values):
    return values.reshape(*values.shape[:-1], layout.paths, layout.sections)


@pytest.mark.parametrize("degrees", [-270.0, -90.0, -1.0, 0.0, 30.0, 180.0, 270.0])
def test_joints_that_bend_alike_are_found_exactly(layout, degrees):
    """By both paths together, and by each alone."""
    q = np.full(12, np.radians(degrees) / 12)
    read = readings(layout, q)
    np.testing.assert_allclose(layout.linear(read, NOISE).values, layout.sums(q), rtol=0, atol=1e-9)
    for path in range(layout.paths):
        alone = by_path(layout, np.full_like(read, np.nan))
        alone[path] = by_path(layout, read)[path]
        found = layout.linear(alone.reshape(-1), NOISE)
        np.testing.assert_allclose(found.values, layout.sums(q), rtol=0, atol=1e-9)
        assert (found.variance < UNKNOWN).all()


@pytest.mark.parametrize("missing", [np.nan, np.inf, -np.inf])
def test_a_section_that_reads_nothing_is_unknown_and_no_other(layout, missing):
    read = readings(layout, np.full(12, 0.1))
    known = layout.linear(read, NOISE)
    spoiled = by_path(layout, read.copy())
    spoiled[:, -1] = missing
    found = layout.linear(spoiled.reshape(-1), NOISE)
    assert (found.values[-1], found.variance[-1]) == (0.0, UNKNOWN)
    np.testing.assert_array_equal(found.values[:-1], known.values[:-1])
    np.testing.assert_array_equal(found.variance[:-1], known.variance[:-1])


@pytest.mark.parametrize("lost", [None, 0, 1])
def test_variance_is_that_of_noisy_readings(shipped_finger, lost):
    """About a nearly straight finger, with both paths or either; 20 000 samples have it within 5 %."""
    layout = SensorLayout(shipped_finger, 3, borders=(0.25, 0.4))
    ratios = extension_ratios(layout, np.full(12, 0.01))
    ratios = ratios + NOISE * np.random.default_rng(7).standard_normal((20_000, layout.readings))
    if lost is not None:
        by_path(layout, ratios)[:, lost] = np.nan
    found = layout.linear(layout.response.reading(ratios), NOISE)
    np.testing.assert_allclose(found.values.var(axis=0), found.variance[0], rtol=0.05)
    np.testing.assert_allclose(found.values.mean(axis=0), layout.sums(np.full(12, 0.01)), atol=2e-4)


@pytest.mark.parametrize("angle", [0.0, 0.1])
def test_a_path_on_the_neutral_axis_reads_nothing(shipped_finger, angle):
    layout = SensorLayout(replace(shipped_finger, sensor_spacing=2 * float(shipped_finger.tip.neutral_axis)), 2)
    assert layout.offsets[0] == 0
    q = np.full(12, angle)
    np.testing.assert_allclose(layout.linear(readings(layout, q), NOISE).values, layout.sums(q), atol=1e-9)
    lost = readings(layout, q)
    lost[2:] = np.nan
    assert (layout.linear(lost, NOISE).variance == UNKNOWN).all()


@pytest.mark.parametrize("wild", [-1.0, -0.9, 5.0, 100.0])
def test_readings_that_no_bend_has_give_finite_bends(shipped_finger, wild):
    layout = SensorLayout(shipped_finger, 4)
    found = layout.linear(np.full(8, wild), NOISE)
    assert (np.abs(found.values) <= 2 * np.pi * layout.joints_per_section).all()
