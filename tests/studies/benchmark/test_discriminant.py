"""Shape models on synthetic grasps: what they tell apart, and what they refuse."""

import numpy as np
import pytest
from scipy.stats import multivariate_normal

from studies.benchmark.discriminant import (
    ObjectClassifier,
    grasp_features,
    principal_components,
    train_object_classifier,
)

LEVELS, FINGERS, JOINTS = 3, 2, 4
SHAPES = ("ball", "can", "brick")
CENTERS = np.random.default_rng(1).normal(0.0, 0.1, (3, 2, LEVELS, 1, JOINTS))


def synthetic(number, seed):
    """Labels, angles and torques of so many grasps of each shape."""
    rng = np.random.default_rng(seed)
    noise = rng.normal(0.0, 0.05, (number, 3, 2, LEVELS, FINGERS, JOINTS))
    grasps = (CENTERS + noise).reshape(-1, *noise.shape[2:])
    return list(SHAPES) * number, grasps[:, 0], 0.1 * grasps[:, 1]


def trained():
    return train_object_classifier(*synthetic(50, 2))


def test_features_are_means_and_deviations_at_every_level():
    angles, torques = np.zeros((2, 2, LEVELS, FINGERS, JOINTS))
    angles[1, 2, :, 3] = 0.1, 0.3
    torques[0, 1, :, 0] = -0.4, -0.4
    found = grasp_features(angles, torques).reshape(2, LEVELS, 4, JOINTS)
    expected = np.zeros_like(found)
    expected[1, 2, 0, 3], expected[1, 2, 2, 3], expected[0, 1, 1, 0] = 0.2, 0.1, -0.4
    np.testing.assert_allclose(found, expected, atol=1e-15)


def test_unseen_grasps_are_recognized():
    labels, angles, torques = synthetic(100, 4)
    probabilities = trained().probabilities(angles, torques)
    right = np.array(trained().answers)[probabilities.argmax(axis=-1)] == labels
    assert right.mean() > 0.85
    assert 0.01 < (probabilities.argmax(axis=-1) == len(SHAPES)).mean() < 0.15, "of known shapes, 5 % count as unknown"
    np.testing.assert_allclose(probabilities.sum(axis=-1), 1.0)


def test_probabilities_are_the_posterior_of_normal_distributions():
    """Compared with scipy's densities of the components."""
    model = trained()
    _, angles, torques = synthetic(1, 5)
    parts = (grasp_features(angles, torques) - model.center) @ model.components.T
    densities = [multivariate_normal(*of).pdf(parts) for of in zip(model.means, model.covariances, strict=True)]
    narrowest = min(model.covariances, key=np.linalg.det)
    at_limit = np.sqrt(model.limit) * np.linalg.cholesky(narrowest)[:, :1].T / 1.0
    density = multivariate_normal(np.zeros(len(narrowest)), narrowest).pdf(at_limit)
    densities.append(np.full(len(parts), density))
    expected = np.array(densities).T / np.sum(densities, axis=0)[:, None]
    np.testing.assert_allclose(model.probabilities(angles, torques), expected, atol=1e-9)


@pytest.mark.parametrize(("at", "expected"), [(0.0, 2 / 3), (2.0, np.exp(-2) / (np.exp(-2) + np.exp(-0.5) / 2))])
def test_of_two_shapes_of_one_mean_the_narrow_one_is_likelier_near_it(at, expected):
    """Normal densities of the standard deviations 1 and 2, by hand; in one component, the first angle."""
    first = np.zeros((1, 4))
    first[0, 0] = 1.0
    wide = np.array([1.0, 4.0]).reshape(2, 1, 1)
    model = ObjectClassifier(("narrow", "wide"), np.zeros(4), first, np.zeros((2, 1)), wide, 1e3)
    angles = np.full((1, 2, 1), at)
    np.testing.assert_allclose(
        model.probabilities(angles, np.zeros((1, 2, 1))), [expected, 1 - expected, 0], atol=1e-12
    )


def test_covariances_are_shrunk_by_a_tenth_toward_that_of_all():
    """Those of each shape as NumPy finds them about its own mean; as many grasps of each, so all have their mean."""
    labels, angles, torques = synthetic(20, 10)
    model = train_object_classifier(labels, angles, torques)
    parts = (grasp_features(angles, torques) - model.center) @ model.components.T
    own = np.array([np.cov(parts[np.array(labels) == shape].T, bias=True) for shape in SHAPES])
    expected = 0.9 * own + 0.1 * own.mean(axis=0) + 1e-6 * np.eye(parts.shape[1])
    np.testing.assert_allclose(model.covariances, expected, atol=1e-12)


def test_components_of_the_training_grasps_are_not_correlated_and_vary_by_one():
    features = np.random.default_rng(7).normal(size=(50, 6)) @ np.diag([1, 10, 1e-3, 1, 1, 0])
    features[:, 1] += features[:, 0]
    center, components = principal_components(features)
    parts = (features - center) @ components.T
    assert components.shape == (5, 6)
    np.testing.assert_allclose(np.cov(parts.T, bias=True), np.eye(5), atol=1e-12)
    np.testing.assert_array_equal(components[:, 5], 0.0)


def test_nan_makes_probabilities_nan():
    _, angles, torques = synthetic(1, 8)
    angles[0, 0, 0, 0] = np.nan
    found = trained().probabilities(angles, torques)
    assert np.isnan(found[0]).all()
    assert np.isfinite(found[1:]).all()
