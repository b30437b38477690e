"""What the example of slipping measures of a lifted object."""

import numpy as np
import pytest

from slip import creep

TIME = 0.01 * np.arange(800)  # s


def test_creep_is_the_speed_at_which_a_lifted_object_sinks():
    height = np.interp(TIME, [2.0, 3.0], [0.0, 0.08]) - 1e-4 * np.maximum(TIME - 3.0, 0.0)
    assert creep(TIME, height) == pytest.approx(0.1)


def test_what_stays_behind_has_slipped():
    assert np.isnan(creep(TIME, np.interp(TIME, [2.0, 3.0], [0.0, 0.03])))
