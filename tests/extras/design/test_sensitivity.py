"""What matters, where it is known: independent variables share the variance by the squares of their weights."""

import numpy as np
import pytest

from soft_gripper.extras.design.sensitivity import sensitivities

COUNT = 2000


@pytest.fixture
def drawn():
    """Three variables without any correlation, also in the sample."""
    columns = np.linalg.qr(np.random.default_rng(1).standard_normal((COUNT, 3)))[0]
    return np.sqrt(COUNT) * columns.T


def cells(values):
    return [repr(float(value)) for value in values]


def of_ranks(correlation):
    """Correlation of the ranks of two normal variables (Pearson, 1907)."""
    return 6 / np.pi * np.arcsin(correlation / 2)


def test_shares_of_independent_variables(drawn):
    a, b, c = drawn
    rows = {
        row.variable: row for row in sensitivities("y", 3 * a - 4 * b, {"a": cells(a), "b": cells(b), "c": cells(c)})
    }
    assert rows["a"].explained == pytest.approx(of_ranks(0.6) ** 2, abs=0.015)
    assert rows["b"].explained == pytest.approx(of_ranks(0.8) ** 2, abs=0.015)
    assert rows["c"].explained < 0.001
    assert rows["a"].slope_of_ranks == pytest.approx(of_ranks(0.6), abs=0.015)
    assert rows["b"].slope_of_ranks == pytest.approx(-of_ranks(0.8), abs=0.015)


def test_choices_without_order():
    """Two of three choices are alike: a third of the runs has another value."""
    choices = np.random.default_rng(2).choice(["sides", "faces", "corners"], COUNT)
    noise = np.random.default_rng(3).standard_normal(COUNT)
    (kind, other) = sensitivities(
        "y", (choices == "faces") + 1e-3 * noise, {"kind": choices.tolist(), "n": cells(noise)}
    )
    assert np.isnan(kind.slope_of_ranks)
    assert kind.explained > 0.6  # the ranks of the noise within a choice are the rest
    assert kind.together > 0.99 * (kind.explained + other.explained)


def test_too_few_designs_tell_nothing():
    assert sensitivities("y", np.arange(3.0), {"a": ["1", "2", "3"]}) == []
    assert sensitivities("y", np.zeros(0), {"a": []}) == []
    assert sensitivities("y", np.ones(9), {"a": cells(range(9))}) == []
    assert len(sensitivities("y", np.arange(9.0), {"a": ["1"] * 9, "b": cells(range(9))})) == 2
