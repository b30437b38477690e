from dataclasses import replace

import pytest

from soft_gripper.extras.play.open_scenario import open_scenario
from soft_gripper.scenario.checks import check_scenario
from soft_gripper.scenario.scenario_file import load_scenario
from soft_gripper.scenario.shipped import scenario_names


@pytest.mark.parametrize("name", scenario_names())
def test_every_shipped_scenario_can_be_opened(name: str) -> None:
    scenario = load_scenario(name)
    opened = open_scenario(scenario)
    check_scenario(name, opened)
    grips = scenario.task is not None and scenario.task.grips
    closed_loop = grips or scenario.control.set_points is not None
    assert opened.external == ["opening" if closed_loop else "pressure", *["tool"] * (scenario.arm is not None)]


def test_the_user_chooses_what_commands_the_fingers() -> None:
    assert open_scenario(load_scenario("tip_distance_steps"), "pressure").external == ["pressure"]
    assert open_scenario(load_scenario("box_grasp"), "opening").external == ["opening"]


def test_a_task_that_does_not_command_the_gripper_closes_no_loop() -> None:
    scenario = load_scenario("pick_and_place_box")
    assert scenario.task is not None
    phases = [replace(phase, opening=None) for phase in scenario.task.phases]
    moving = replace(scenario, task=replace(scenario.task, phases=phases))
    assert open_scenario(moving).external == ["pressure", "tool"]
