"""Random objects: what is drawn, and where the object stands."""

from dataclasses import replace

import numpy as np
import pytest
from pydrake.common.schema import Transform
from pydrake.math import RigidTransform, RollPitchYaw

from soft_gripper.extras.grasps.trial import RandomObject
from soft_gripper.scenario.scenario_file import load_scenario
from studies.benchmark.random_objects import SHAPES, draw, free_model, lowest_height, replace_object

DRAWN = RandomObject(x_mm=2.0, y_mm=-3.0, yaw_deg=15.0, mass_g=25.0, friction=0.6, size=1.1)


@pytest.fixture(scope="module")
def scenario():
    return load_scenario("probing_grasp", ["sensor.errors=null"])


def test_what_is_drawn_follows_from_seed_set_number_and_shape_alone():
    cases = [(1, "train", 0, "box"), (1, "test", 0, "box"), (1, "train", 1, "box"), (1, "train", 0, "ball")]
    drawn = [draw(*case) for case in [*cases, (2, "train", 0, "box")]]
    assert len(set(drawn)) == 5
    assert draw(*cases[0]) == drawn[0]


@pytest.mark.parametrize("shape", SHAPES)
def test_another_object_stands_as_high_as_that_of_the_scenario(scenario, shape):
    model = free_model(replace_object(scenario, shape, DRAWN))
    X_WO = model.X_PC.GetDeterministicValue()
    foot = X_WO.translation()[2] + model.mesh.scale * lowest_height(model.file, X_WO.rotation())
    assert foot == pytest.approx(1e-5, abs=1e-9)
    np.testing.assert_allclose(X_WO.translation()[:2], [2e-3, -3e-3], atol=1e-12)
    assert np.degrees(RollPitchYaw(X_WO.rotation()).yaw_angle()) == pytest.approx(15.0)
    scale = pytest.approx(1.1 * (0.7 if shape == "irregular" else 1.0))
    assert (model.mesh.scale, model.mass, model.friction) == (scale, pytest.approx(0.025), 0.6)
    assert free_model(scenario).file.endswith("box.obj"), "the scenario itself is left as it was"


def test_a_support_at_another_height_is_stood_on(scenario):
    box = free_model(scenario)
    raised = replace(box, X_PC=Transform(RigidTransform([0.1, 0.0, 0.23])))
    found = free_model(replace_object(replace(scenario, models=[raised]), "sphere", DRAWN))
    assert found.X_PC.GetDeterministicValue().translation()[2] == pytest.approx(0.2 + 1.1 * 0.023, abs=1e-5)
