"""Agreement of runs in two engines, measure by measure."""

import math

import pytest

from soft_gripper.extras.sweeps.agreement import agreement, draw_indices


def test_words_are_counted_and_numbers_compared():
    found = [{"grasp": "held", "force": "1.0", "area": "nan"}, {"grasp": "held", "force": "2.5", "area": "nan"}]
    in_drake = [{"grasp": "held", "force": "1.1", "area": "50"}, {"grasp": "dropped", "force": "2.0", "area": "60"}]
    words, numbers = agreement(found, in_drake)  # an area that only one of them knows is not compared
    assert (words.measure, words.runs, words.alike) == ("grasp", 2, 1)
    assert (numbers.measure, numbers.runs, numbers.in_drake) == ("force", 2, pytest.approx(1.55))
    assert numbers.median_difference == pytest.approx(0.3)
    assert numbers.largest_difference == pytest.approx(0.5)
    assert math.isnan(numbers.alike)


def test_the_same_seed_repeats_the_same_runs():
    assert draw_indices(50, 5, 1) == draw_indices(50, 5, 1) != draw_indices(50, 5, 2)
    assert len(set(draw_indices(50, 5, 1))) == 5
    assert draw_indices(3, 100, 1) == [0, 1, 2]
