"""The command tune, and run of a closed loop: what they print, write and refuse."""

import csv
from dataclasses import fields

import pytest
from command_line import soft_gripper

from soft_gripper.runs.scores.steps import StepRow

COLUMNS = "step,from_mm,to_mm,overshoot_percent,crossings,settling_s,steady_error_estimated_mm,steady_error_true_mm"
SHORT = ("--set", "control.set_points=[0.08, 0.06]", "--set", "control.hold=1")


@pytest.mark.slow
def test_tune_prints_the_table_and_the_gains():
    outcome = soft_gripper("tune", *SHORT, "--evaluations", 5, terminal=True)
    assert outcome.code == 0
    *table, gains = outcome.out.strip().splitlines()
    assert "overshoot" in table[0]
    assert [line.split()[2] for line in table if line.split()[:1] in (["0"], ["1"])] == ["80.0", "60.0"]
    assert gains.startswith("gains: { kp: ")
    assert "5/5" in outcome.err


def test_run_writes_the_table_of_steps(tmp_path):
    outcome = soft_gripper("run", "tip_distance_steps", *SHORT, "--out", tmp_path)
    assert outcome.code == 0
    assert ",".join(field.name for field in fields(StepRow)) == COLUMNS
    with open(tmp_path / "steps.csv", newline="") as file:
        rows = list(csv.DictReader(file))
    assert ",".join(rows[0]) == COLUMNS
    assert [float(row["to_mm"]) for row in rows] == pytest.approx([80, 60])
    assert sorted(path.name for path in tmp_path.iterdir()) == [
        "recording.nc",
        "scenario.yaml",
        "steps.csv",
        "success.csv",
    ]
