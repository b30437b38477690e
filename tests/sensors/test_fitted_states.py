"""Distances from fitted states."""

import numpy as np
import pytest

from soft_gripper.sensors.calibrated_states import CalibratedStates, state_spreads
from soft_gripper.sensors.fitted_states import FittedStates, Widths

LINE = FittedStates(np.column_stack([np.linspace(0, 1, 101), np.zeros(101)]), np.array([1.0, 2.0]))


def test_distance_is_that_to_the_nearest_state_in_spreads():
    np.testing.assert_allclose(
        LINE.distance(np.array([[0.5, 4.0], [2.0, 0.0], [0.3, 0.0]])), [2.0, 1.0, 0.0], atol=1e-12
    )


@pytest.mark.parametrize(("gravity", "distance"), [((0, 0, 9.81), np.sqrt(2)), ((-9.81, 0, 0), 2.0)])
def test_a_finger_turned_from_its_only_pose_is_as_far_as_gravity_changed_over_g(gravity, distance):
    strains, drive = np.zeros((5, 4)), np.tile([0.02, 9.81, 0.0], (5, 1))
    fitted = FittedStates(np.hstack([strains, drive]), state_spreads(strains, drive))
    states = CalibratedStates(fitted, Widths(np.array([1e-3]), 1e-3), np.inf, sections=2)
    assert states.distances(strains[0], drive[0, :1], np.array(gravity)).drive == pytest.approx(distance, rel=1e-3)


@pytest.mark.parametrize("region", [LINE.regions(4), LINE.halves(4)])
def test_regions_are_equal_pieces_of_a_line(region):
    assert set(region) == {0, 1, 2, 3}
    for number in range(4):
        rows = np.flatnonzero(region == number)
        assert (np.diff(rows) == 1).all(), "a region is connected"
        assert 10 <= len(rows) <= 40
    assert LINE.leave_out(region == 0).distance(LINE.states[region == 0]).min() > 0


def test_a_few_states_that_lie_apart_are_no_halves_of_their_own():
    cloud = np.random.default_rng(2).normal(size=(800, 3))
    states = FittedStates(np.concatenate([cloud, [[50.0, 0, 0], [0, 50.0, 0]]]), np.ones(3))
    assert set(np.bincount(states.halves())) <= {100, 101}


def test_states_that_repeat_stay_together():
    """As of recordings at one pressure each: one of them may have most of the samples."""
    states = FittedStates(np.repeat([[1.0], [2.0], [3.0]], [3, 5, 22], axis=0), np.ones(1))
    for region in (states.regions(), states.halves()):
        np.testing.assert_array_equal(np.sort(np.bincount(region)), [3, 5, 22])


def test_local_size_is_that_of_the_errors_nearby():
    """Errors of 1 on one side of the line, and of 10 on the other."""
    size = LINE.local_size(np.where(LINE.states[:, :1] < 0.5, 1.0, 10.0))
    np.testing.assert_allclose(size[[0, -1], 0], [1.0, 10.0])
    assert 1 < size[50, 0] < 10
    assert LINE.nearest(np.array([[0.303, 0.0]])) == [30]


def test_far_is_where_the_distance_makes_more_of_a_band_than_all_else():
    np.testing.assert_array_equal(Widths(np.array([1.0]), 2.0).is_far(np.array([[0.4], [0.6]])), [[False], [True]])
