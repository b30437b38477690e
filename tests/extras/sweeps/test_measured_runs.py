"""Measures of runs with changes."""

import pytest
from refusals import refused

from soft_gripper.extras.sweeps.measured_runs import run_and_measure


@pytest.mark.slow
def test_tasks_and_closed_loops_have_measures_of_their_own():
    steps = run_and_measure("tip_distance_steps", {"control.set_points": [0.06], "control.hold": 1.0})
    assert 0 < steps["mean_settling_s"] < 1
    task = run_and_measure("arm_motion", {"task.time_limit": 0.5})
    assert task == {"outcome": "running", "duration_s": 0.5}
    held = run_and_measure("pick_and_place_box", {"task.time_limit": 0.5})
    assert (held["success"], held["cause"][:8]) == (False, "not over")


def test_a_scenario_without_fingers_has_nothing_to_be_measured():
    with refused("models", ["package://soft_gripper/objects/table.sdf"]):
        run_and_measure(
            "box_grasp", {"models": [{"name": "table", "file": "package://soft_gripper/objects/table.sdf"}]}
        )
