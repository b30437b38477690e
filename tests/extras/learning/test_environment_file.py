"""load_environment: files, changes, mistakes."""

import pytest
from refusals import refused

from soft_gripper.errors import InputError
from soft_gripper.extras.learning.config import environment_names, load_environment


@pytest.mark.parametrize("name", environment_names())
def test_what_is_shipped_loads(name):
    environment = load_environment(name)
    assert environment.config.description
    assert environment.scenario.external[0] == "pressure"


@pytest.mark.parametrize("name", [None, 3, ["free_bending"], float("nan"), "soft_gasp"])
def test_a_name_is_that_of_a_file_or_shipped(name):
    with refused("name", name):
        load_environment(name)


def test_changes_reach_the_environment_and_its_scenario():
    changes = {"variation.mass": [0.1, 0.2], "scenario.sensor.sections": 4, "action.grip": "opening"}
    environment = load_environment("soft_grasp", changes)
    assert environment.config.variation.mass == [0.1, 0.2]
    assert environment.scenario.sensor.sections == 4
    assert environment.scenario.external == ["opening", "joints"]


def test_a_file_of_ones_own_names_its_scenario_beside_it(tmp_path):
    text = "scenario: free_bending\nobservation: [{signal: left_finger.tip_pose}]\nreach: {}\n"
    path = tmp_path / "own.yaml"
    path.write_text(text)
    assert len(load_environment(str(path)).scenario.models) == 2


@pytest.mark.parametrize(
    ("changes", "field"),
    [
        ({"action.range": [1.0, 0.0]}, "action.range"),
        ({"action.range": [2e4, 2e4], "action.rest": 2e4}, "action.range"),
        ({"action.joints": {"z": [0.0, 0.0]}}, "action.joints.z"),
        ({"action.rest": 1e6}, "action.rest"),
        ({"variation.gripper": "hand"}, "variation.gripper"),
        ({"scenario.models.1.fingers": {"all": {"youngs_modulus": "5e5"}}}, "variation.youngs_modulus"),
        ({"scenario.nominal.finger.youngs_modulus": "+30 %"}, "variation.youngs_modulus"),
        ({"grasp.object": "apple"}, "grasp.object"),
        ({"reach": {}}, "reach"),
        ({"observation": []}, "observation"),
        ({"time_step": 0.01}, "time_step"),
        ({"duration": 0.01}, "duration"),
        ({"nothing.here.at.all.0": 1}, "nothing"),
    ],
)
def test_mistakes_are_named(changes, field):
    with pytest.raises(InputError) as caught:
        load_environment("soft_grasp", changes)
    assert caught.value.field == field
