"""Problems of least squares whose fits are known: of straight lines, and of an exponential."""

import numpy as np
import pytest
from refusals import refused

from soft_gripper.errors import InputError
from soft_gripper.extras.hardware.least_squares import Fit, Problem, fit

PLACES = np.linspace(-1, 1, 41)
LINE = np.column_stack([np.ones_like(PLACES), PLACES])
RANDOM = np.random.default_rng(0)
NOISY = LINE @ [1.0, 2.0] + RANDOM.normal(0, 0.1, len(PLACES))


def line(**fields):
    return Problem(np.asarray, lambda x: LINE @ x - NOISY, lambda x, residuals: LINE, **fields)


def test_a_line_is_fitted_as_by_linear_least_squares():
    weights = np.linspace(0.5, 2, len(PLACES))
    found = fit(line(weights=weights), [0.0, 0.0])
    expected = np.polynomial.polynomial.polyfit(PLACES, NOISY, 1, w=weights)
    np.testing.assert_allclose(found.model, expected, rtol=1e-6)
    np.testing.assert_allclose(found.residuals, LINE @ expected - NOISY, atol=1e-6)
    weighted = weights[:, None] * LINE
    np.testing.assert_allclose(found.covariance, np.linalg.inv(weighted.T @ weighted), rtol=1e-9)


def test_without_some_residuals_it_is_the_fit_to_the_others():
    kept = PLACES < 0.5
    whole = fit(line(), [0.0, 0.0])
    np.testing.assert_allclose(
        whole.x + whole.change_without(kept), np.linalg.lstsq(LINE[kept], NOISY[kept], rcond=None)[0], rtol=1e-6
    )


def test_an_unknown_that_what_is_left_hardly_shows_stays_where_it_is():
    """One of two is seen by a millionth in the rows that are kept: it moves by all that they ask, or not at all."""
    slopes, residuals = np.array([[1.0, 0.0], [0.0, 1e-6], [0.0, 1.0]]), np.array([-0.5, 1e-3, 0.0])
    found = Fit(np.asarray, np.zeros(2), residuals, slopes, np.ones(3), 0.0, 0.0, True)
    kept = np.array([True, True, False])
    np.testing.assert_allclose(found.change_without(kept), [0.5, -1000])
    np.testing.assert_allclose(found.change_without(kept, 1e-3), [0.5, 0.0], atol=1e-12)
    np.testing.assert_allclose(found.change_without(kept, 1e-3, [1.0, 1e6]), [0.5, -1000])


def test_an_outlier_does_little_harm_and_weights_say_by_how_much():
    """Ordinary least squares with the weights of the result have their minimum in the same place."""
    off = np.where(np.arange(len(PLACES)) == 7, 30.0, 0.0)
    problem = Problem(np.asarray, lambda x: LINE @ x - NOISY - off, lambda x, residuals: LINE, outlier=0.1)
    found = fit(problem, [0.0, 0.0])
    np.testing.assert_allclose(found.x, [1.0, 2.0], atol=0.1)
    assert found.weights[7] < 0.1
    np.testing.assert_allclose(found.change_without(np.full(len(PLACES), True)), 0.0, atol=1e-3)


def test_unknowns_of_no_interest_follow_the_others():
    """The deviation of a slope is the same, whether the offset of the line is in the fit or was taken out of it."""
    problem = Problem(np.asarray, lambda x: LINE[:, ::-1] @ x - NOISY, lambda x, residuals: LINE[:, ::-1])
    found = fit(problem, [0.0, 0.0])
    profile = found.profile(1)
    np.testing.assert_allclose(profile.x, found.x[:1])
    np.testing.assert_allclose(profile.covariance, found.covariance[:1, :1], rtol=1e-9)
    np.testing.assert_allclose(found.profile(2).slopes, found.slopes)


def test_residuals_that_are_not_to_be_had_count_as_said_and_not_in_the_report():
    def residuals(x):
        return np.where(PLACES > 0.9, np.nan, LINE @ x - NOISY)

    reports = []
    problem = Problem(
        np.asarray,
        residuals,
        lambda x, residuals: LINE * np.isfinite(residuals)[:, None],
        missing=0.5,
        error=lambda residuals: float(np.nanmean(residuals**2)),
    )
    found = fit(problem, [0.9, 1.9], reports.append)
    assert [report.step for report in reports] == list(range(1, len(reports) + 1))
    assert {report.missing for report in reports} == {3}
    assert reports[-1].error == pytest.approx(np.mean(found.residuals[:-3] ** 2))
    np.testing.assert_array_equal(found.residuals[-3:], 0.5)


def test_the_best_of_the_fits_that_come_near_is_kept():
    """(x^2 - 4)^2 has two minima; from above 5 the unknown cannot be had, and below -5 the fit comes nowhere near."""

    def residuals(x):
        if x[0] > 5:
            raise InputError("finger", "length", x[0], "at most 5")
        return np.array([x[0] ** 2 - 4, 0.1 * (x[0] - 2)]) if x[0] > -5 else np.full(2, 10.0)

    problem = Problem(np.asarray, residuals, error=lambda residuals: float(np.abs(residuals).max()))
    with_slopes = [[-3.0], [9.0], [1.0], [-9.0]]
    assert fit(problem, with_slopes).x == pytest.approx([2.0])
    with refused("length", 9.0):
        fit(problem, [[-9.0], [9.0]])
    with refused("residual"):
        fit(problem, [[9.0], [-9.0]])
