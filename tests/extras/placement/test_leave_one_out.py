"""A run has no say in the placement that is tried in it."""

import numpy as np
import pytest

from soft_gripper.extras.placement.place_sensors import leave_one_out

WANTED = {"a": 2, "b": 3, "c": 10}  # the border at which each run errs least


def errors(placement, spoiled=None):
    """Errors of the runs, m; those of one may be nonsense."""
    found = np.array([1e-3 * (1 + (placement[0] - wanted) ** 2) for wanted in WANTED.values()])
    if spoiled is not None:
        found[spoiled] = 1e3 * placement[0] ** 5 % 7.0
    return found


def test_each_is_left_out_in_turn_and_then_scored():
    a, b, c = leave_one_out(errors, list(WANTED), 12, (6,))
    assert [row.run for row in (a, b, c)] == list(WANTED)
    assert [row.placement for row in (a, b, c)] == [(6,), (6,), (2,)]  # nearest to the mean of the others' wishes
    assert [row.equal for row in (a, b, c)] == pytest.approx([17e-3, 10e-3, 17e-3])
    assert [row.placed for row in (a, b, c)] == pytest.approx([17e-3, 10e-3, 65e-3])


@pytest.mark.parametrize("segments", [12, 700])
def test_what_happens_in_a_run_does_not_move_its_placement(segments):
    """Whether all placements are tried, or borders are exchanged."""
    clean = leave_one_out(errors, list(WANTED), segments, (6,))
    for i in range(3):
        spoiled = leave_one_out(lambda placement, i=i: errors(placement, i), list(WANTED), segments, (6,))
        assert spoiled[i].placement == clean[i].placement
        assert [row.placement for row in spoiled] != [row.placement for row in clean]


def test_a_single_run_leaves_none_to_place_by():
    assert leave_one_out(lambda placement: np.ones(1), ["a"], 12, (6,)) == []
