"""What is measured of a closed loop, from steps that are made up."""

from types import SimpleNamespace

import pytest

from soft_gripper.runs.scores.steps import StepRow
from soft_gripper.runs.sweep import measures as module
from soft_gripper.runs.sweep.measures import measure
from soft_gripper.scenario.scenario_file import load_scenario

STEPS = [  # step, from, to, overshoot, crossings, settling, steady errors estimated and true
    StepRow(0, 90.0, 60.0, 1.0, 2, 0.2, -0.1, 0.5),
    StepRow(1, 60.0, 50.0, 7.0, 3, 0.4, 0.3, -0.9),
]


def test_a_closed_loop_is_measured_over_all_of_its_steps(monkeypatch):
    """Sizes of the steady errors, lest an error to one side make up for one to the other."""
    monkeypatch.setattr(module, "step_table", lambda *_: STEPS)
    found = measure(SimpleNamespace(scenario=load_scenario("tip_distance_steps")), None)
    assert found["mean_settling_s"] == pytest.approx(0.3)
    assert found["max_overshoot_percent"] == 7.0
    assert found["mean_steady_error_true_mm"] == pytest.approx(0.7)
    assert found["mean_steady_error_estimated_mm"] == pytest.approx(0.2)
    assert found["crossings"] == 5
