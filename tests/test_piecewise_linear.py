"""PiecewiseLinear: through its points, straight on beyond them, and exactly invertible; one curve or many."""

import numpy as np
import pytest

from soft_gripper.piecewise_linear import PiecewiseLinear

X = np.array([-2.0, -0.5, 0.25, 3.0])
Y = np.array([-7.0, -1.0, 0.5, 0.75])
ACROSS = np.linspace(-10, 10, 401)  # far beyond both ends
CURVES = PiecewiseLinear(np.array([X, 2 * X + 1, X**3]), np.array([Y, Y - 4, 3 * Y]))
SIDE_BY_SIDE = [PiecewiseLinear(x, y) for x, y in zip(CURVES.x, CURVES.y, strict=True)]


def test_is_straight_from_point_to_point():
    between = np.linspace(-2, 3, 101)
    np.testing.assert_allclose(PiecewiseLinear(X, Y)(between), np.interp(between, X, Y), rtol=1e-13)


def test_end_pieces_go_on():
    curve = PiecewiseLinear(X, Y)
    np.testing.assert_allclose(curve(np.array([-3.5, 5.75])), [2 * Y[0] - Y[1], 2 * Y[3] - Y[2]], rtol=1e-15)


@pytest.mark.parametrize("points", [2, 4])
def test_slopes_are_those_of_the_pieces(points):
    curve, small = PiecewiseLinear(X[:points], Y[:points]), 1e-4
    rises = (curve(ACROSS + 0.01 + small) - curve(ACROSS + 0.01 - small)) / (2 * small)  # clear of the corners
    np.testing.assert_allclose(curve.slope(ACROSS + 0.01), rises, rtol=1e-9)
    np.testing.assert_array_equal(curve.slope(X[:points])[1:], curve.slopes)  # at a corner, of the piece before it


@pytest.mark.parametrize("points", [2, 3, 4])
def test_inverse_is_exact(points):
    curve = PiecewiseLinear(X[:points], Y[:points])
    np.testing.assert_allclose(curve.inverse()(curve(ACROSS)), ACROSS, rtol=1e-13, atol=1e-13)


@pytest.mark.parametrize("shape", [(3,), (50, 3), (4, 2, 3)])
def test_curves_side_by_side_are_those_curves(shape):
    x = np.random.default_rng(1).uniform(-10, 10, shape)
    alone = np.stack([curve(x[..., i]) for i, curve in enumerate(SIDE_BY_SIDE)], axis=-1)
    slopes = np.stack([curve.slope(x[..., i]) for i, curve in enumerate(SIDE_BY_SIDE)], axis=-1)
    np.testing.assert_array_equal(CURVES(x), alone)
    np.testing.assert_array_equal(CURVES.slope(x), slopes)
    np.testing.assert_allclose(CURVES.inverse()(CURVES(x)), x, rtol=1e-13, atol=1e-13)


@pytest.mark.parametrize("points", [2, 4])
def test_nan_stays_where_it_is(points):
    values = PiecewiseLinear(X[:points], Y[:points])(np.array([np.nan, X[0]]))
    assert np.isnan(values[0])
    assert values[1] == Y[0]
