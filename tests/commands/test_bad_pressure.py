"""Pressures that cannot be: beyond the limits they are refused, and what diverges says when, where and why."""

import pytest
from command_line import short, soft_gripper

BEYOND = [
    ("pressure.steps.all=[0, 210.1e3]", "pressure.steps.all[1] = 210100.0", "-50000 to 210000 Pa"),
    ("pressure.steps.left_finger=[-50.1e3]", "pressure.steps.left_finger[0] = -50100.0", "-50000 to 210000 Pa"),
    ("pressure.maximum=50e3", "pressure.steps.all[1] = 60000.0", "-50000 to 50000 Pa"),
    ("pressure.minimum=-102e3", "pressure.minimum = '-102e3'", "-101325 Pa"),
    ("pressure.maximum=.inf", "pressure.maximum = inf", "finite"),
]
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


@pytest.mark.parametrize(("override", "value", "limits"), BEYOND, ids=[override for override, *_ in BEYOND])
def test_a_step_beyond_the_limits_is_refused(tmp_path, override, value, limits):
    outcome = soft_gripper("run", "free_bending", *short(override), "--out", tmp_path / "out")
    assert (outcome.code, outcome.out, outcome.err.count("\n")) == (2, "", 1)
    assert value in outcome.err
    assert limits in outcome.err
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(("name", "overrides"), DIVERGING)
def test_a_run_that_diverges_says_so_in_one_line(tmp_path, name, overrides):
    outcome = soft_gripper("run", name, *short(*overrides), "--out", tmp_path / "out")
    assert (outcome.code, outcome.out) == (2, "")
    *progress, complaint = outcome.err.splitlines()
    assert complaint.startswith("soft-gripper: the simulation diverged before t = 0.")
    assert "finger_joint_" in complaint
    assert "likely cause: " in complaint
    assert not [line for line in progress if line and "s simulated" not in line]
    assert list((tmp_path / "out").iterdir()) == []
