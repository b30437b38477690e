"""How an object is turned from its goal: rotations that are put together from a tilt and a turn."""

import numpy as np
import pytest
from pydrake.common.eigen_geometry import AngleAxis
from pydrake.math import RotationMatrix

from soft_gripper.runs.scores.recorded_task import angle, tilt, yaw


def rotation(tilted: float, toward: float, turned: float) -> RotationMatrix:
    """A turn about the own z axis, which is then tilted toward a side, rad."""
    axis = [-np.sin(toward), np.cos(toward), 0.0]
    return RotationMatrix(AngleAxis(tilted, axis)) @ RotationMatrix.MakeZRotation(turned)


@pytest.mark.parametrize("toward", [0.0, 0.7, 3.0, -2.0])
@pytest.mark.parametrize("tilted", [0.0, 1e-6, 0.1, 1.5, 3.0])
@pytest.mark.parametrize("turned", [0.0, 0.2, -1.5, 3.1, -3.1])
def test_tilt_and_turn_are_separated(tilted, toward, turned):
    R = rotation(tilted, toward, turned)
    assert tilt(R) == pytest.approx(tilted, abs=1e-9)
    assert yaw(R) == pytest.approx(turned, abs=1e-6)
    # Half-angle formula of the product of two rotations about axes at right angles.
    assert np.cos(angle(R) / 2) == pytest.approx(np.cos(tilted / 2) * np.cos(turned / 2), abs=1e-9)
