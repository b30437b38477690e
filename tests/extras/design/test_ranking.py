"""Scores, the Pareto front and the best design, on cases that are known."""

import numpy as np
import pytest

from soft_gripper.extras.design.ranking import find_best, pareto_front, score, summarize_runs
from soft_gripper.extras.design.study_file import EndConfig, LimitConfig

FORCE = EndConfig("force", "least", "mean")
NAN = float("nan")


def rows(*forces, grasp="held"):
    return [{"grasp": grasp, "force": str(force)} for force in forces]


@pytest.mark.parametrize(
    ("end", "forces", "expected"),
    [
        (FORCE, [1.0, 3.0], 2.0),
        (EndConfig("force", "least", "worst"), [1.0, 3.0], 3.0),
        (EndConfig("force", "most", "worst"), [1.0, 3.0], 1.0),
        (FORCE, [1.0, NAN], NAN),
        (FORCE, [], NAN),
    ],
)
def test_ends_are_means_or_the_worst(end, forces, expected):
    assert summarize_runs([*rows(*forces), *rows(9.0, grasp="dropped")], [end])[1] == pytest.approx(
        (expected,), nan_ok=True
    )


@pytest.mark.parametrize(
    ("limit", "excess"),
    [
        (LimitConfig(most=2.5), 0.2),
        (LimitConfig(most=4.0), -0.2),
        (LimitConfig(least=2.0), 0.5),
        (LimitConfig(1, 3), 0),
    ],
)
def test_limits_are_of_the_worst_run(limit, excess):
    found = score(rows(1.0, 3.0), [FORCE], {"force": limit})
    assert max(found.excess.values()) == pytest.approx(max(excess, 0.0))
    assert found.is_allowed == (excess <= 0)


def test_front_of_a_quarter_circle():
    """Of points inside and on a circle round the origin, those on it dominate: less is better, so turn them round."""
    angles = np.linspace(0, np.pi / 2, 9)
    on = -np.column_stack([np.cos(angles), np.sin(angles)])
    inside = 0.9 * on[1:-1]
    assert pareto_front(np.concatenate([on, inside])) == list(range(9))


def test_the_best_is_that_of_the_first_end_then_of_the_next():
    assert find_best(np.array([[2.0, 0.0], [1.0, 5.0], [1.0, 4.0], [NAN, NAN]])) == 2
    assert find_best(np.full((2, 1), NAN)) is None
    assert find_best(np.empty((0, 1))) is None
