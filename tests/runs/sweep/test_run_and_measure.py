"""One run of a sweep: what is measured."""

import pytest
from refusals import refused

from soft_gripper.diagrams.simulation import run_station
from soft_gripper.diagrams.station import make_station
from soft_gripper.runs.scores.external_torques import recorded_force_table
from soft_gripper.runs.scores.poses import recorded_pose_table
from soft_gripper.runs.sweep.measured_runs import run_and_measure
from soft_gripper.scenario.scenario_file import changed_scenario

SHORT = {"pressure.steps": {"all": [0.0, 60e3]}, "pressure.settle": 0.2, "pressure.hold_samples": 5}
NOISY = {**SHORT, "sensor.errors.preset": "realistic"}


@pytest.mark.slow
def test_measures_are_those_of_the_tables():
    changes = {**NOISY, "models.gripper.fingers.all.youngs_modulus": "+10 %"}
    found = run_and_measure("box_grasp", changes)
    station = make_station(changed_scenario("box_grasp", changes))
    recording = run_station(station)
    rows = recorded_pose_table("", station, recording)
    base = [row for row in recorded_force_table("", station, recording) if row.joint == 0]
    for error in ("pose_error_mm", "tip_error_mm"):
        errors = [getattr(row, error) for row in rows]
        assert found[f"max_{error}"] == max(errors)
        assert found[f"mean_{error}"] == pytest.approx(sum(errors) / len(errors))
    assert found["mean_torque_error_mnm"] == pytest.approx(
        1e3 * sum(abs(row.estimated_nm - row.true_nm) for row in base) / len(base)
    )
    assert found["largest_bend_deg"] == max(abs(row.bend_angle_deg) for row in rows)
    forces = [recording[f"{finger.name}.true_contact_total"].values[-5:] for finger in station.fingers]
    assert found["largest_contact_force_n"] == pytest.approx(max(force.mean() for force in forces))
    assert found["largest_contact_force_n"] > 0
    assert found["grasp"] in ("resting", "held", "slipping")


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
