"""Shape models in files: the same after reading, and what is refused."""

import json

import numpy as np
import pytest
from refusals import refused

from soft_gripper.errors import InputError
from soft_gripper.extras.recognition.object_classifier import (
    ObjectClassifier,
    load_object_classifier,
    save_object_classifier,
)

RNG = np.random.default_rng(1)
MODEL = ObjectClassifier(
    ("ball", "can"),
    fingers=2,
    joints=3,
    sections=4,
    pressures=np.array([50e3, 80e3]),
    center=RNG.normal(size=24),
    components=RNG.normal(size=(2, 24)),
    means=RNG.normal(size=(2, 2)),
    covariances=np.array([np.eye(2), 2 * np.eye(2)]),
    limit=12.5,
)


@pytest.fixture
def file(tmp_path):
    save_object_classifier(MODEL, tmp_path / "shapes.json")
    return tmp_path / "shapes.json"


def test_a_model_is_the_same_after_reading(file):
    found = load_object_classifier(file)
    assert (found.shapes, found.fingers, found.joints, found.sections) == (("ball", "can"), 2, 3, 4)
    assert (found.limit, found.answers) == (12.5, ("ball", "can", "unknown"))
    for name in ("pressures", "center", "components", "means", "covariances"):
        np.testing.assert_allclose(getattr(found, name), getattr(MODEL, name), rtol=1e-8)


def test_the_shipped_model_is_of_the_shipped_gripper():
    found = load_object_classifier("package://soft_gripper/grippers/two_finger_objects.json")
    assert found.shapes == ("sphere", "cylinder", "box", "irregular")
    assert (found.fingers, found.joints, found.sections) == (2, 12, 4)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"components": [[1.0] * 23] * 2}, ["components", "(2, 23)", "(2, 24)"]),
        ({"means": [[1.0], [1.0, 2.0]]}, ["means", "list"]),
        ({"center": [float("nan")] * 24}, ["center", "NaN"]),
        ({"limit": "far"}, ["limit", "far", "a number"]),
        ({"limit": -1.0}, ["limit", "-1", "above 0"]),
        ({"joints": "many"}, ["joints", "many", "whole number"]),
        ({"shapes": 3}, ["shapes", "3", "list"]),
        ({"colour": "red"}, ["fields", "colour", "covariances"]),
    ],
)
def test_a_field_that_is_wrong_is_named(file, change, words):
    file.write_text(json.dumps(json.loads(file.read_text()) | change))
    with pytest.raises(InputError) as error:
        load_object_classifier(file)
    assert all(word in str(error.value) for word in [str(file), *words])


@pytest.mark.parametrize(
    ("text", "field", "value"), [("weights: 1", "file", "shapes.json"), ("[1, 2]", "fields", "list")]
)
def test_a_file_that_is_no_model_is_refused(file, text, field, value):
    file.write_text(text)
    with refused(field, value):
        load_object_classifier(str(file))


def test_an_unknown_file_is_named(tmp_path):
    with refused("file", "nosuch.json"):
        load_object_classifier(tmp_path / "nosuch.json")
