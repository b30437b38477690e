"""Measures of a run: what they are."""

import math
from dataclasses import fields, replace
from types import SimpleNamespace

import numpy as np
import pytest

from soft_gripper.runs import measures as module
from soft_gripper.runs.measures import kind_of, measure
from soft_gripper.runs.scores.poses import PoseRow
from soft_gripper.runs.scores.steps import StepRow
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


def test_a_step_that_does_not_settle_leaves_the_settling_time_unknown(monkeypatch):
    steps = [STEPS[0], replace(STEPS[1], settling_s=float("nan"))]
    monkeypatch.setattr(module, "step_table", lambda *_: steps)
    found = measure(SimpleNamespace(scenario=load_scenario("tip_distance_steps")), None)
    assert math.isnan(found["mean_settling_s"])


def test_the_largest_bend_may_open_the_fingers(monkeypatch):
    """Two steps of one finger: the largest of everything is sought by size, not by sign."""
    rows = [PoseRow("", "f", "arcs", "", 4, *numbers) for numbers in [(-20, -30.0, 1.0, 2.0), (20, 10.0, 3.0, 7.0)]]
    torques = {"f.external_torque": [1e-3, 5e-3], "f.true_external_torque": [2e-3, 2e-3]}  # N m, of both steps
    forces = {"f.true_contact_total": np.array([[0.0, 1.0], [9.0, -1.0]])}  # N, two samples of both steps

    def held(name):
        return forces[name] if name in forces else np.array(torques[name])[:, None, None]

    monkeypatch.setattr(module, "recorded_pose_table", lambda *_: rows)
    monkeypatch.setattr(module, "held_samples", lambda _, __, name: held(name))
    station = SimpleNamespace(scenario=load_scenario("free_bending"), fingers=[SimpleNamespace(name="f")])
    found = measure(station, None)
    assert found == pytest.approx(
        {
            **{"mean_pose_error_mm": 2.0, "max_pose_error_mm": 3.0, "mean_tip_error_mm": 4.5, "max_tip_error_mm": 7.0},
            **{"mean_torque_error_mnm": 2.0, "largest_bend_deg": 30.0, "largest_contact_force_n": 4.0},
        }
    )


def test_no_measure_hides_another_of_its_name():
    """Of a task, both durations are that of the run."""
    for name in ("bottle_grasp", "box_grasp", "tip_distance_steps", "pick_and_place_box"):
        names = [each.name for kind in kind_of(load_scenario(name)) for each in fields(kind)]
        assert {each for each in names if names.count(each) > 1} <= {"duration_s"}, name
