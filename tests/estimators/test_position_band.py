"""How uncertain joints and tip are: against fingers drawn at random."""

import numpy as np
import pytest
from fingers_in_space import WAYS, yielding

from soft_gripper.estimators.finger_shape import Places, position_std


@pytest.fixture
def covariance():
    """Of 36 joint positions, correlated, some tenths of a degree."""
    root = 1e-3 * np.random.default_rng(2).standard_normal((36, 36))
    return root @ root.T / 3


def test_std_is_that_of_the_distance_of_fingers_drawn_from_the_covariance(shipped_finger, bent, covariance):
    """40 000 fingers that only bend have it within 2 %."""
    q, covariance = bent(12), covariance[:12, :12]
    drawn = np.random.default_rng(3).multivariate_normal(q, covariance, 40_000)
    places = Places(shipped_finger, ["bending"])
    distance = np.linalg.norm(places(drawn)[0] - places(q)[0], axis=-1)
    found = position_std(shipped_finger, q, covariance)
    np.testing.assert_allclose(found, np.sqrt((distance**2).mean(axis=0)), rtol=0.02, atol=1e-12)
    assert found[0] == 0
    assert found[-1] > 1e-4


def test_variances_along_the_axes_are_those_of_fingers_drawn_in_space(shipped_finger, bent, covariance):
    finger, q = yielding(shipped_finger), bent(36) / 4
    drawn = np.random.default_rng(3).multivariate_normal(q, covariance, 20_000)
    places = Places(finger, WAYS)
    expected = ((places(drawn)[0] - places(q)[0]) ** 2).mean(axis=0)
    np.testing.assert_allclose(places.variance(q, covariance), expected, rtol=0.05, atol=1e-12)
