"""Widths of bands that grow with the distance from fitted states."""

import numpy as np
import pytest

from soft_gripper.extras.hardware.fitted_range import LeftOut, learned_widths


def test_widths_hold_brownian_errors_at_every_distance():
    """Errors whose variance is 1 + 4 d: widths learned from some regions hold 95 % in others, near and far."""
    rng = np.random.default_rng(1)

    def region(d, count=4000):
        return LeftOut(np.abs(rng.normal(0, np.sqrt(1 + 4 * d), (count, 1))), np.full((count, 1), np.sqrt(d)))

    fitted = np.abs(rng.normal(0, 1, (4000, 1)))
    widths = learned_widths(fitted, [region(d) for d in np.linspace(1.0, 8.0, 12)])
    assert widths.floor[0] == pytest.approx(1.96, rel=0.05)
    assert widths.growth == pytest.approx(2 * 1.96, rel=0.05)
    for d in (0.0, 1.0, 4.0, 12.0):
        errors, by_distance = region(d)
        assert (errors <= widths.band(by_distance)).mean() == pytest.approx(0.95, abs=0.015)


def test_a_region_counts_the_same_however_long_it_was_stayed_in():
    fitted = np.zeros((10, 1))
    calm, wild = (
        LeftOut(np.full((count, 1), error), np.ones((count, 1))) for count, error in ((10000, 1.0), (10, 5.0))
    )
    assert learned_widths(fitted, [calm, wild]).growth == pytest.approx(5.0)
    assert learned_widths(fitted, [*[calm] * 30, wild]).growth == pytest.approx(1.0)


def test_without_regions_the_distance_is_not_taken_to_matter():
    widths = learned_widths(np.ones((10, 2)), [])
    np.testing.assert_allclose(widths.band(np.array([[0.0, 5.0]])), 1.0)
