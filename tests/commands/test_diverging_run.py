"""A run that diverges says when, where and why."""

import pytest
from command_line import short, soft_gripper

EXPLICIT = [
    "plant_config.time_step=0",
    "simulator_config.integration_scheme=explicit_euler",
    "simulator_config.use_error_control=false",
]
DIVERGING = [
    ("free_bending", ["pressure.maximum=1e9", "pressure.steps.all=[0, 1e9]"]),
    ("box_grasp", ["pressure.maximum=1e12", "pressure.steps.all=[0, 1e12]"]),
    ("free_bending", ["pressure.steps.all=[0, 150e3]", *EXPLICIT]),
]


@pytest.mark.slow
@pytest.mark.parametrize(("name", "overrides"), DIVERGING)
def test_a_run_that_diverges_says_so_in_one_line(tmp_path, name, overrides):
    outcome = soft_gripper("run", name, *short(*overrides), "--out", tmp_path / "out")
    assert (outcome.code, outcome.out) == (2, "")
    *progress, complaint = outcome.err.splitlines()
    assert complaint.startswith("soft-gripper: the simulation diverged before t = 0.")
    assert "finger_joint_" in complaint
    assert "likely cause: " in complaint
    assert not [line for line in progress if line and "s simulated" not in line]
    assert not (tmp_path / "out").exists()
