"""Scenarios are values: copies and pickles of them are equal, and changes show."""

import copy
import pickle

import pytest

import soft_gripper as sg


@pytest.mark.parametrize("name", sg.scenario_names())
def test_a_scenario_survives_a_pickle_and_a_copy(name):
    scenario = sg.load_scenario(name)
    for again in (pickle.loads(pickle.dumps(scenario)), copy.deepcopy(scenario), sg.load_scenario(name)):
        assert again == scenario
        assert sg.dump_scenario(again) == sg.dump_scenario(scenario)


@pytest.mark.parametrize(
    "change",
    [
        "models.gripper.X_PC.translation=[0, 0, 0.5]",
        "models.gripper.X_PC.rotation=!Rpy {deg: [180, 0, 1]}",
        "plant_config.time_step=0.004",
        "simulator_config.accuracy=1e-4",
        "task.X_WGoal.translation=[0.5, 0.1, 0.2]",
        "sensor.sections=3",
    ],
)
def test_a_change_makes_another_scenario(change):
    assert sg.load_scenario("pick_and_place_box", [change]) != sg.load_scenario("pick_and_place_box")
