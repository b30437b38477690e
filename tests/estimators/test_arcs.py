"""Arcs of sections, and the estimators made of them and of splines, on circles and on the chain."""

from dataclasses import replace

import numpy as np
import pytest

from soft_gripper.estimators.arc_shapes import ArcShape, ConstantCurvatureShape
from soft_gripper.estimators.arcs import arcs_from_lengths, arcs_from_readings, joints_on_arcs, points_on_arcs
from soft_gripper.estimators.spline import SplineShape
from soft_gripper.fingers.kinematics import forward_kinematics
from soft_gripper.fingers.statics import free_bending_angles
from soft_gripper.sensors.sensor_layout import SensorLayout, extension_ratios

LENGTH, SPACING = 0.12, 0.018  # m
EXACT = 1e-15  # m, rounding on the scale of a finger


def sensed(theta, length, axis_at=0.5):
    """Arcs found from the exact lengths of paths beside arcs of bend `theta` whose axes are `length` long."""
    theta, length = np.asarray(theta, dtype=float), np.asarray(length, dtype=float)
    inner = length - axis_at * SPACING * theta
    return arcs_from_lengths(inner, inner + SPACING * theta, SPACING, axis_at)


def on_circle(bend, s):
    """Point z + i x at arc length `s` of an arc that bends by `bend` over LENGTH."""
    if bend == 0:
        return s + 0j
    radius = LENGTH / bend
    return radius * (np.sin(s / radius) + 1j * (1 - np.cos(s / radius)))


def integrated(theta, length):
    """End of the curve of piecewise constant curvature: the integral of exp(i heading) ds."""
    nodes, weights = np.polynomial.legendre.leggauss(30)
    heading, end = 0.0, 0.0 + 0.0j
    for bend, span in zip(theta, length, strict=True):
        end += span / 2 * (weights @ np.exp(1j * (heading + bend * (nodes + 1) / 2)))
        heading += bend
    return end


@pytest.mark.parametrize("axis_at", [0.0, 0.5])
@pytest.mark.parametrize("shares", [[1], [0.5, 0.5], [0.25, 0.4, 0.35], [0.1, 0.2, 0.3, 0.4]], ids=len)
@pytest.mark.parametrize("bend", np.deg2rad(np.arange(-270, 271, 45)), ids=lambda bend: f"{np.rad2deg(bend):.0f}")
def test_circle_in_sections_is_exact(bend, shares, axis_at):
    shares = np.array(shares)
    arcs = sensed(bend * shares, LENGTH * shares, axis_at)
    fraction = np.array([0.0, 0.3, 1.0])
    for i, share in enumerate(shares):
        s = LENGTH * (shares[:i].sum() + share * fraction)
        points = points_on_arcs(arcs, np.full(3, i), fraction)
        np.testing.assert_allclose(points, [on_circle(bend, at) for at in s], atol=EXACT)
    np.testing.assert_allclose(arcs.end[:-1], arcs.start[1:], atol=EXACT)
    np.testing.assert_allclose(arcs.kappa, bend / LENGTH, rtol=1e-12)
    assert arcs.tip_heading == pytest.approx(bend, abs=1e-13)


@pytest.mark.parametrize("theta", [[1.0, -1.2], [-0.5, 2.0, -3.0], [0.0, 1.5, 0.0, -1.5]])
def test_s_shapes_follow_the_integrated_curve(theta):
    length = np.linspace(0.02, 0.05, len(theta))
    arcs = sensed(theta, length)
    for n in range(1, len(theta) + 1):
        assert arcs.end[n - 1] == pytest.approx(integrated(theta[:n], length[:n]), abs=EXACT)


def test_centers_are_equally_far_from_every_point_and_on_the_inner_side():
    theta = np.array([0.7, -1.1, 1e-3])
    arcs = sensed(theta, [0.03, 0.04, 0.05])
    radius = np.array([0.03, 0.04, 0.05]) / theta
    for fraction in (0.0, 0.4, 1.0):
        points = points_on_arcs(arcs, np.arange(3), np.full(3, fraction))
        toward_center = (arcs.centers - points) / np.exp(1j * (arcs.heading + fraction * theta))
        np.testing.assert_allclose(toward_center, 1j * radius, rtol=1e-10)


@pytest.mark.parametrize("unknown", range(4))
@pytest.mark.parametrize("side", ["inner", "outer"])
def test_what_hangs_on_an_unknown_arc_is_unknown(unknown, side):
    lengths = {"inner": np.full(4, 0.029), "outer": np.full(4, 0.031)}
    known = arcs_from_lengths(lengths["inner"], lengths["outer"], SPACING)
    lengths[side][unknown] = np.nan
    arcs = arcs_from_lengths(lengths["inner"], lengths["outer"], SPACING)
    index = np.arange(4)
    np.testing.assert_array_equal(arcs.theta, np.where(index == unknown, np.nan, known.theta))
    np.testing.assert_array_equal(np.isnan(arcs.start), index >= unknown)
    np.testing.assert_array_equal(np.isnan(arcs.end), index >= unknown)
    np.testing.assert_array_equal(arcs.end[:unknown], known.end[:unknown])
    assert np.isnan(arcs.tip_heading)


DRIVING = np.linspace(0.05, 0.02, 12)  # N m


def test_constant_curvature_shares_equally_on_the_curve_of_arcs(layout, bent):
    strain = layout.read(bent(5, 12))
    found, arcs = (
        make(layout)(strain, DRIVING, np.array([9.81, 0.0, 0.0])) for make in (ConstantCurvatureShape, ArcShape)
    )
    np.testing.assert_array_equal(found.curve.joints, arcs.curve.joints)
    for section in range(layout.sections):
        shared = found.q[:, layout.joint_sections == section]
        np.testing.assert_array_equal(shared, np.broadcast_to(shared[:, :1], shared.shape))
    np.testing.assert_allclose(layout.sums(found.q), arcs.curve.theta, atol=1e-14)


def test_free_bending_of_an_even_finger_is_no_torque(shipped_finger):
    """Whatever the number of sections; under a load at the joints, the torque is that load."""
    even = replace(shipped_finger, tip=shipped_finger.base)
    pressure, load = np.array([-3e4, 0.0, 8e4]), np.array([-0.02, 0.01, 0.03])[:, None]
    driving = even.pressure_torque(pressure)
    for sections in (1, 4):
        estimate = ConstantCurvatureShape(SensorLayout(even, sections))
        free = estimate(estimate.layout.read(free_bending_angles(even, pressure)), driving, np.zeros(3))
        np.testing.assert_allclose(free.external_torque, np.zeros((3, 12)), atol=1e-4)
        loaded = estimate(estimate.layout.read(even.angle(driving + load)), driving, np.zeros(3))
        np.testing.assert_allclose(loaded.external_torque, np.broadcast_to(load, (3, 12)), atol=1e-4)


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


LAYOUTS = {
    "two": {"sections": 2},
    "four": {"sections": 4},
    "unequal": {"sections": 3, "borders": (0.25, 0.6)},
    "one-sided": {"sections": 3, "one_sided": True},
    "a section a joint": {"sections": 12},
}
NOTHING = np.zeros(12)  # N m


@pytest.fixture(params=LAYOUTS.values(), ids=LAYOUTS)
def divided(request, shipped_finger):
    return SensorLayout(shipped_finger, **request.param)


def readings(divided, q):
    return divided.response.reading(extension_ratios(divided, q))


def estimated(divided, read):
    return SplineShape(divided)(read, np.broadcast_to(NOTHING, (*read.shape[:-1], 12)), np.zeros(3)).q


def smoothest(divided, theta, known):
    """By Lagrange's multipliers: the least sum of squared differences with the sums of the known sections."""
    joints = divided.finger.segments
    sums = np.array([divided.joint_sections == section for section in np.flatnonzero(known)], dtype=float)
    differences = np.diff(np.eye(joints), axis=0)
    zero = np.zeros((len(sums), len(sums)))
    system = np.block([[2 * differences.T @ differences, sums.T], [sums, zero]])
    return np.linalg.lstsq(system, np.concatenate([np.zeros(joints), theta[known]]), rcond=None)[0][:joints]


def test_sums_are_those_that_are_read_and_nothing_is_smoother(divided, bent):
    read = readings(divided, bent(20, 12))
    theta = divided.linear(read, 1e-5).values
    q = estimated(divided, read)
    np.testing.assert_allclose(divided.sums(q), theta, atol=1e-6)
    known = np.full(divided.sections, True)
    np.testing.assert_allclose(q, [smoothest(divided, bends, known) for bends in theta], atol=1e-6)


@pytest.mark.parametrize("missing", range(4))
def test_a_missing_section_is_bridged(shipped_finger, missing):
    divided, q = SensorLayout(shipped_finger, 4), np.linspace(0.0, 0.2, 12)
    read = readings(divided, q)
    theta = divided.linear(read, 1e-5).values
    read[[missing, missing + 4]] = np.nan
    found, known = estimated(divided, read), np.arange(4) != missing
    np.testing.assert_allclose(found, smoothest(divided, theta, known), atol=1e-5)
    if missing in (1, 2):
        np.testing.assert_allclose(found, q, atol=1e-2)
