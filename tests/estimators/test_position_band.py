"""How uncertain joints and tip are: against finite differences, and against fingers drawn at random."""

import numpy as np
import pytest

from soft_gripper.estimators.uncertainty import position_std
from soft_gripper.fingers.kinematics import forward_kinematics


def points(finger, q):
    chain = forward_kinematics(q, finger.segment_length)
    return np.append(chain.joints, chain.tip)


@pytest.fixture
def covariance():
    """Of 12 joint angles, correlated, some tenths of a degree."""
    root = 1e-3 * np.random.default_rng(2).standard_normal((12, 12))
    return root @ root.T


def test_std_is_that_of_fingers_drawn_from_the_covariance(shipped_finger, bent, covariance):
    """Across the link that ends at the point: 40 000 fingers have it within 2 %."""
    q = bent(12)
    drawn = np.random.default_rng(3).multivariate_normal(q, covariance, 40_000)
    chain = forward_kinematics(drawn, shipped_finger.segment_length)
    places = np.concatenate([chain.joints, chain.tip[:, None]], axis=-1)
    headings = np.append(0.0, np.cumsum(q))
    across = (places - points(shipped_finger, q)) * np.conj(1j * np.exp(1j * headings))
    expected = across.real.std(axis=0)
    found = position_std(shipped_finger, q, covariance)
    np.testing.assert_allclose(found, expected, rtol=0.02, atol=1e-12)
    assert found[0] == 0
    assert found[-1] > 1e-4


def test_only_what_lies_before_a_point_moves_it(shipped_finger):
    covariance = np.zeros((12, 12))
    covariance[5, 5] = 1e-4
    found = position_std(shipped_finger, np.zeros(12), covariance)
    s = np.append(shipped_finger.joint_arc_lengths, shipped_finger.length)
    np.testing.assert_allclose(found, 1e-2 * np.maximum(s - s[5], 0), atol=1e-15)


def test_a_batch_is_its_samples(shipped_finger, bent, covariance):
    q, scale = bent(3, 2, 12), np.linspace(1, 2, 6).reshape(3, 2, 1, 1)
    found = position_std(shipped_finger, q, scale * covariance)
    for index in np.ndindex(3, 2):
        alone = position_std(shipped_finger, q[index], scale[index] * covariance)
        np.testing.assert_allclose(found[index], alone, rtol=1e-12)
