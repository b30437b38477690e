"""Scenarios run in MuJoCo, beside Drake."""

import numpy as np
import pytest

from soft_gripper.diagrams.simulation import run_many, simulate
from soft_gripper.errors import InputError
from soft_gripper.extras.mujoco_engine.engine import _change, _End
from soft_gripper.runs.sweep.run_sweep import measured_runs
from soft_gripper.scenario.scenario_file import changed_scenario

pytest.importorskip("mujoco")

ENGINE = {"engine": "mujoco"}
RAMP = {"pressure.steps": {"all": [40e3, 80e3, 120e3]}, "pressure.settle": 0.5, "pressure.hold_samples": 50}


def test_a_free_finger_bends_as_in_drake():
    changes = {"pressure.steps": {"all": [60e3, 150e3]}, "pressure.settle": 1.5}
    one, other = (simulate(changed_scenario("free_bending", changes | engine)) for engine in (ENGINE, {}))
    assert set(one.data) == set(other.data)
    tips = [each["left_finger.true_tip_position"].values[-1] for each in (one, other)]
    assert np.linalg.norm(tips[0] - tips[1]) < 5e-6
    strains = [each["left_finger.strain"].values[-1] for each in (one, other)]
    assert strains[0] == pytest.approx(strains[1], abs=1e-5)
    assert "5 ms" in one.data.attrs["engine_step"]


def test_a_held_box_is_held_as_hard_as_in_drake():
    one, other = (measured_runs("box_grasp", [RAMP | engine])[0] for engine in (ENGINE, {}))
    assert one["grasp"] == other["grasp"] == "held"
    assert one["normal_force_n"] == pytest.approx(other["normal_force_n"], rel=0.05)


def test_the_same_runs_are_the_same_to_the_bit_and_differ_by_their_objects():
    light, heavy = ({"models.box.mass": mass} | RAMP | ENGINE for mass in (0.05, 0.2))
    both = measured_runs("box_grasp", [light, heavy])
    assert str(both) == str(measured_runs("box_grasp", [light, heavy]))
    assert [each["grasp"] for each in both] == ["held", "resting"]
    assert both[1]["slip_ratio"] > 3 * both[0]["slip_ratio"]


def test_a_step_is_too_long_if_half_of_it_turns_a_carried_object_otherwise():
    end = _End(np.zeros((2, 3)), np.ones(2), np.zeros((4, 3)))
    turned = end._replace(object=np.array([[0, 0, 0], [0, 3e-4, 0], [-3e-4, 0, 0], [0, 0, 0]]))
    assert _change([end] * 3, [end, end, turned]).is_small
    assert not _change([end] * 3, [end, turned, turned]).is_small


def test_what_fails_has_its_error_and_ends_no_other():
    inside = {"models.box.X_PC.translation.2": -0.02}
    given = {}, inside, {"plant_config.time_step": 0.0}
    runs = run_many([changed_scenario("box_grasp", RAMP | ENGINE | changes) for changes in given])
    fine, wrong, refused = runs
    assert fine.recording["time"].values[-1] == pytest.approx(3.0)
    assert isinstance(wrong, InputError)
    assert "begins inside" in str(wrong)
    assert "engine mujoco takes steps" in str(refused)
