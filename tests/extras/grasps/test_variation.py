"""Variations of a scenario: how they are spread, that each can be drawn alone, and where the object stands."""

from dataclasses import astuple

import numpy as np
import pytest
import trimesh
from refusals import refused

from soft_gripper.extras.grasps.adds import TrialsConfig
from soft_gripper.extras.grasps.trial import TrialVariation, draw, random_numbers, varied, vary
from soft_gripper.models import DIRECTORY
from soft_gripper.scenario.scenario_file import load_scenario
from soft_gripper.scenario.schema import Scenario

SCENARIOS = ["pick_and_place_box", "pick_and_place_irregular", "pick_and_place_delicate"]
NARROW = TrialsConfig(0.01, 0.2, [0.03, 0.04], [0.6, 0.7], 0.05, 1e-3, 0.01)  # as a scenario may have it
EXACT = (0.0, 0.0, 0.0)  # no error of the reported pose


def object_of(scenario: Scenario):
    return next(model for model in scenario.models if model.name == scenario.task.object)


def lowest_points(scenario: Scenario) -> tuple[float, float]:
    """Lowest point of the object where it begins and at the goal, m, by the vertices of its mesh."""
    model = object_of(scenario)
    mesh = trimesh.load(DIRECTORY / model.file.removeprefix("package://soft_gripper/"), force="mesh")
    poses = [pose.GetDeterministicValue() for pose in (model.X_PC, scenario.task.X_WGoal)]
    first, second = ((X @ (model.mesh.scale * mesh.vertices.T))[2].min() for X in poses)
    return first, second


def test_ranges_are_those_of_the_scenario():
    drawn = np.array([astuple(draw(random_numbers(1, "box", trial), NARROW)) for trial in range(500)])
    turn, error = np.degrees(0.2), np.degrees(0.01)
    low, high = [-10, -10, -turn, 30, 0.6, 0.95, -1, -1, -error], [10, 10, turn, 40, 0.7, 1.05, 1, 1, error]
    np.testing.assert_allclose(drawn.min(axis=0), low, atol=0.02 * (np.array(high) - low).max())
    assert (drawn >= low).all()
    assert (drawn <= high).all()
    assert (np.ptp(drawn, axis=0) > 0.95 * (np.array(high) - low)).all()


def test_a_trial_is_the_same_whatever_is_drawn_before_and_unlike_every_other():
    again = draw(random_numbers(3, "box", 7), TrialsConfig())
    assert again == draw(random_numbers(3, "box", 7), TrialsConfig())
    others = [
        draw(random_numbers(*key), TrialsConfig())
        for key in ((3, "box", 6), (4, "box", 7), (7, "box", 3), (3, "cup", 7))
    ]
    assert again not in others
    assert len(set(others)) == len(others)


@pytest.mark.parametrize("name", SCENARIOS)
@pytest.mark.parametrize("size", [0.9, 1.1])
def test_a_larger_or_smaller_object_stands_as_high_as_before(name, size):
    scenario = load_scenario(name)
    found = varied(scenario, TrialVariation(20, -10, 30, 25, 0.6, size, *EXACT))
    np.testing.assert_allclose(lowest_points(found), lowest_points(scenario), atol=1e-12)
    assert lowest_points(found) == pytest.approx((1e-5, 1e-5), abs=2e-5)
    assert object_of(found).mesh.scale == pytest.approx(size * object_of(scenario).mesh.scale)


def test_the_object_is_shifted_and_turned_about_its_own_vertical():
    scenario = load_scenario("pick_and_place_box")
    found = varied(scenario, TrialVariation(20, -10, 30, 25, 0.6, 1.0, *EXACT))
    assert object_of(found).X_PC.translation == pytest.approx([0.47, -0.19, 0.03001])
    rpy = np.degrees(object_of(found).X_PC.GetDeterministicValue().rotation().ToRollPitchYaw().vector())
    assert rpy == pytest.approx([0, 0, 50])
    assert found.task.X_WGoal.GetDeterministicValue().IsNearlyEqualTo(
        scenario.task.X_WGoal.GetDeterministicValue(), 1e-12
    )
    model = object_of(found)
    assert (model.mass, model.friction) == pytest.approx((0.025, 0.6))


@pytest.mark.parametrize(
    ("name", "changes"),
    [("pick_and_place_box", ["models.3.file=package://soft_gripper/objects/box.sdf"]), ("box_grasp", [])],
    ids=["no mesh", "no task"],
)
def test_a_scenario_without_a_mesh_to_handle_is_refused(name, changes):
    with refused("task.object"):
        vary(load_scenario(name, changes), random_numbers(1, name, 0))
