"""Intervals: published values, and how often they hold the truth."""

import numpy as np
import pytest

from gentle_grasp.episodes import mean, share


@pytest.mark.parametrize(
    ("successes", "number", "low", "high"),
    [  # Newcombe, Stat. Med. 17, 1998, 857-872, table I, method 3
        (81, 263, 0.2553, 0.3662),
        (15, 148, 0.0624, 0.1605),
        (0, 20, 0.0, 0.1611),
        (1, 29, 0.0061, 0.1718),
    ],
)
def test_shares_have_the_score_interval_of_wilson(successes, number, low, high):
    found = share(successes, number)
    assert found.value == pytest.approx(successes / number)
    assert (found.low, found.high) == pytest.approx((low, high), abs=6e-5)


def test_all_successes_leave_room_for_failures():
    found = share(100, 100)
    assert found.high == pytest.approx(1.0)
    assert found.low == pytest.approx(0.963, abs=5e-4)


def test_the_bootstrap_agrees_with_the_normal_approximation_where_that_holds():
    values = np.random.default_rng(0).normal(2.0, 0.5, 400)
    found, error = mean(values), values.std() / 20
    assert found.value == values.mean()
    assert found.low == pytest.approx(found.value - 1.96 * error, abs=0.1 * error)
    assert found.high == pytest.approx(found.value + 1.96 * error, abs=0.1 * error)


def test_the_bootstrap_is_the_same_every_time():
    values = np.random.default_rng(0).gamma(2.0, size=30)
    assert mean(values) == mean(values)
