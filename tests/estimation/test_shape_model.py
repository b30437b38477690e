"""Shape models on synthetic grasps: what they tell apart, and what they refuse."""

from dataclasses import replace

import numpy as np
import pytest

from soft_gripper.errors import InputError
from soft_gripper.estimation.shape_model import grasp_features
from soft_gripper.estimation.shape_training import discriminant, train_shape_model

LEVELS, FINGERS, JOINTS = 3, 2, 4
SHAPES = ("ball", "can", "brick")
CENTERS = np.random.default_rng(1).normal(0.0, 0.1, (3, 2, LEVELS, 1, JOINTS))


def synthetic(number, seed):
    """Labels, angles and torques of so many grasps of each shape."""
    rng = np.random.default_rng(seed)
    noise = rng.normal(0.0, 0.05, (number, 3, 2, LEVELS, FINGERS, JOINTS))
    grasps = (CENTERS + noise).reshape(-1, *noise.shape[2:])
    return list(SHAPES) * number, grasps[:, 0], 0.1 * grasps[:, 1]


def trained(**changes):
    labels, angles, torques = synthetic(50, 2)
    return replace(train_shape_model(labels, angles, torques, [1e3, 2e3, 3e3], 2), **changes)


def test_features_do_not_ask_which_finger_is_the_first():
    _, angles, torques = synthetic(1, 3)
    swapped = grasp_features(angles[:, :, ::-1], torques[:, :, ::-1])
    np.testing.assert_allclose(grasp_features(angles, torques), swapped)


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
    right = np.array(SHAPES)[probabilities.argmax(axis=-1)] == labels
    assert right.mean() > 0.95
    np.testing.assert_allclose(probabilities.sum(axis=-1), 1.0)


def test_probabilities_are_the_posterior_of_two_normal_distributions():
    """Of one feature with means -1 and 1 and variance 1 the log odds are twice the feature."""
    residuals = np.random.default_rng(5).normal(size=(100_000, 1))
    weights, biases = discriminant(np.array([[-1.0], [1.0]]), residuals)
    np.testing.assert_allclose(np.diff(weights, axis=0), 2.0, rtol=0.02)
    np.testing.assert_allclose(np.diff(biases), 0.0, atol=1e-12)


def test_a_feature_that_does_not_vary_has_no_weight():
    residuals = np.random.default_rng(6).normal(size=(100, 2)) * [1.0, 0.0]
    weights, _ = discriminant(np.array([[0.0, 1.0], [1.0, 1.0]]), residuals)
    np.testing.assert_array_equal(weights[:, 1], 0.0)


def test_leading_axes_are_a_batch():
    _, angles, torques = synthetic(4, 7)
    model, shape = trained(), (2, 6, LEVELS, FINGERS, JOINTS)
    batch = model.probabilities(angles.reshape(shape), torques.reshape(shape))
    one = [model.probabilities(*grasp) for grasp in zip(angles, torques, strict=True)]
    np.testing.assert_allclose(batch.reshape(-1, 3), one)


def test_nan_makes_probabilities_nan():
    _, angles, torques = synthetic(1, 8)
    angles[0, 0, 0, 0] = np.nan
    found = trained().probabilities(angles, torques)
    assert np.isnan(found[0]).all()
    assert np.isfinite(found[1:]).all()


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"weights": np.zeros((3, 47))}, ["weights", "(3, 47)", "(3, 48)"]),
        ({"biases": np.zeros(2)}, ["biases", "(2,)", "(3,)"]),
        ({"biases": np.array([0.0, np.nan, 0.0])}, ["biases", "NaN"]),
    ],
)
def test_a_model_that_does_not_fit_is_refused(changes, words):
    with pytest.raises(InputError) as error:
        trained(**changes)
    assert all(word in str(error.value) for word in words)


def test_training_refuses_what_is_not_finite_and_shapes_that_are_too_few():
    labels, angles, torques = synthetic(3, 9)
    torques[4] = np.inf
    with pytest.raises(InputError, match=r"grasps\[4\]"):
        train_shape_model(labels, angles, torques, [1e3, 2e3, 3e3], 2)
    with pytest.raises(InputError, match="two shapes or more"):
        train_shape_model(["ball"] * 9, angles, torques, [1e3, 2e3, 3e3], 2)
