"""Criteria of success: their text, what meets them, and that shipped scenarios have some."""

import math

import pytest
from refusals import refused

from soft_gripper.runs.success import success_criteria
from soft_gripper.scenario.scenario_file import load_scenario
from soft_gripper.scenario.schema import read_criterion


@pytest.mark.parametrize(
    ("text", "measured", "met"),
    [
        ("slid_mm at most 1", 1.0, True),
        ("slid_mm at most 1", 1.01, False),
        ("largest_bend_deg at least 1.2e2", 120.0, True),
        ("largest_bend_deg at least 1.2e2", 119.9, False),
        ("slid_mm at most 1", math.nan, False),
        ("slid_mm at least 1", math.nan, False),
        ("grasp is held", "held", True),
        ("grasp is held", "dropped", False),
        ("grasp is never touched", "never touched", True),
        ("dropped is False", False, True),
    ],
)
def test_a_measure_meets_a_criterion_or_does_not(text, measured, met):
    criterion = read_criterion(text)
    assert criterion is not None
    assert criterion.text == text
    assert criterion.is_met(measured) is met


@pytest.mark.parametrize(
    "text", ["", "slid_mm", "slid_mm at most", "slid_mm at most many", "slid_mm at most nan", "slid_mm below 1"]
)
def test_other_texts_are_refused_with_what_would_be_right(text):
    with refused("success[1]") as error:
        load_scenario("box_grasp", [f"success=[grasp is held, {text!r}]"])
    assert "MEASURE at most NUMBER" in str(error.value)


def test_a_measure_that_runs_do_not_have_is_refused():
    with refused("success[0]") as error:
        success_criteria(load_scenario("free_bending", ["success=[grasp is held]"]))
    assert "max_pose_error_mm" in str(error.value)


def test_the_text_of_a_task_has_the_limits_that_it_is_judged_by():
    texts = success_criteria(
        load_scenario("pick_and_place_box", ["task.force_limit=0.75", "task.squeeze_limit=0.0015"])
    )
    assert "no finger presses with more than 0.75 N" in texts
    assert "the object is squeezed by at most 1.5 mm" in texts
    assert not any("squeezed" in text for text in success_criteria(load_scenario("pick_and_place_box")))
