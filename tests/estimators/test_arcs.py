"""Equations (2)-(6), compared with exact circles and with numerically integrated curves."""

import numpy as np
import pytest

from soft_gripper.estimators.arcs import arcs_from_lengths, points_on_arcs

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
