"""What the example of slipping measures of a lifted object."""

import numpy as np
import pytest

from slip import IN_DRAKE, in_drake, raised_and_creep

TIME = 0.01 * np.arange(800)  # s


def test_creep_is_the_speed_at_which_a_lifted_object_sinks():
    height = np.interp(TIME, [2.0, 3.0], [0.0, 0.08]) - 1e-4 * np.maximum(TIME - 3.0, 0.0)
    raised, creep = raised_and_creep(TIME, height)
    assert creep == pytest.approx(0.1)
    assert raised == pytest.approx(80 - 0.1 * 4.99)


def test_what_stays_behind_has_slipped():
    raised, creep = raised_and_creep(TIME, np.interp(TIME, [2.0, 3.0], [0.0, 0.03]))
    assert raised == pytest.approx(30)
    assert np.isnan(creep)


@pytest.mark.slow
def test_points_creep_more_than_surfaces():
    (_, surface), (_, points) = in_drake({}), in_drake(IN_DRAKE["contact at 4 points"])
    assert 0 < surface < points
