"""The spline: of all shapes with the measured bends the smoothest."""

import numpy as np
import pytest

from soft_gripper.estimators.spline import SplineShape
from soft_gripper.sensors.sensor_layout import SensorLayout, extension_ratios

LAYOUTS = {
    "two": {"sections": 2},
    "four": {"sections": 4},
    "unequal": {"sections": 3, "borders": (0.25, 0.6)},
    "one-sided": {"sections": 3, "one_sided": True},
    "a section a joint": {"sections": 12},
}
NOTHING = np.zeros(12)  # N m


@pytest.fixture(params=LAYOUTS.values(), ids=LAYOUTS)
def layout(request, shipped_finger):
    return SensorLayout(shipped_finger, **request.param)


def readings(layout, q):
    return layout.response.reading(extension_ratios(layout, q))


def estimated(layout, read):
    return SplineShape(layout)(read, np.broadcast_to(NOTHING, (*read.shape[:-1], 12)), np.zeros(3)).q


def smoothest(layout, theta, known):
    """By Lagrange's multipliers: the least sum of squared differences with the sums of the known sections."""
    joints = layout.finger.segments
    sums = np.array([layout.joint_sections == section for section in np.flatnonzero(known)], dtype=float)
    differences = np.diff(np.eye(joints), axis=0)
    zero = np.zeros((len(sums), len(sums)))
    system = np.block([[2 * differences.T @ differences, sums.T], [sums, zero]])
    return np.linalg.lstsq(system, np.concatenate([np.zeros(joints), theta[known]]), rcond=None)[0][:joints]


def test_sums_are_those_that_are_read_and_nothing_is_smoother(layout, bent):
    read = readings(layout, bent(20, 12))
    theta = layout.linear(read, 1e-5).values
    q = estimated(layout, read)
    np.testing.assert_allclose(layout.sums(q), theta, atol=1e-6)
    known = np.full(layout.sections, True)
    np.testing.assert_allclose(q, [smoothest(layout, bends, known) for bends in theta], atol=1e-6)


@pytest.mark.parametrize("missing", range(4))
def test_a_missing_section_is_bridged(shipped_finger, missing):
    layout, q = SensorLayout(shipped_finger, 4), np.linspace(0.0, 0.2, 12)
    read = readings(layout, q)
    theta = layout.linear(read, 1e-5).values
    read[[missing, missing + 4]] = np.nan
    found, known = estimated(layout, read), np.arange(4) != missing
    np.testing.assert_allclose(found, smoothest(layout, theta, known), atol=1e-5)
    if missing in (1, 2):
        np.testing.assert_allclose(found, q, atol=1e-2)
