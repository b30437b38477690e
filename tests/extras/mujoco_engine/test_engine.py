"""Scenarios run in MuJoCo, beside Drake."""

from dataclasses import replace

import numpy as np
import pytest
from pydrake.common.schema import Transform
from pydrake.math import RigidTransform
from refusals import refused
from scipy.integrate import solve_ivp

from soft_gripper.diagrams.simulation import run_many, simulate
from soft_gripper.errors import InputError
from soft_gripper.extras.mujoco_engine import engine, plants
from soft_gripper.extras.mujoco_engine.engine import _change, _End
from soft_gripper.extras.sweeps.measured_runs import measured_runs
from soft_gripper.scenario.scenario_file import changed_scenario, load_scenario

pytest.importorskip("mujoco")

ENGINE = {"engine": "mujoco"}
STEPS = ENGINE | {"engine_step": 0.005}  # without a search for one
RAMP = {"pressure.steps": {"all": [40e3, 80e3, 120e3]}, "pressure.settle": 0.5, "pressure.hold_samples": 50}


def test_a_free_finger_bends_as_in_drake():
    changes = {"pressure.steps": {"all": [60e3, 150e3]}, "pressure.settle": 1.5}
    one, other = (simulate(changed_scenario("free_bending", changes | added)) for added in (ENGINE, {}))
    assert set(one.data) == set(other.data)
    tips = [each["left_finger.true_tip_position"].values[-1] for each in (one, other)]
    assert np.linalg.norm(tips[0] - tips[1]) < 5e-6
    strains = [each["left_finger.strain"].values[-1] for each in (one, other)]
    assert strains[0] == pytest.approx(strains[1], abs=1e-5)
    assert "5 ms" in one.data.attrs["engine_step"]


def test_point_masses_of_directives_swing_as_a_pendulum_does(tmp_path):
    """MuJoCo takes no bodies without rotational inertia."""
    angle, damping, moment, torque = 0.4, 0.1, 0.25, 0.5 * 9.81  # rad, N m s, kg m^2, N m: 1 kg at 0.5 m
    pendulum = (
        "{name: p, file: package://drake/examples/pendulum/Pendulum.urdf, default_joint_positions: {theta: [%g]}}"
    )
    (tmp_path / "s.yaml").write_text(
        f"directives: [{{add_model: {pendulum % angle}}}]\n"
        "models: [{name: f, file: package://soft_gripper/grippers/finger.urdf, X_PC: {translation: [3, 0, 1]}}]\n"
        "pressure: {steps: {all: [0]}, settle: 1.0, hold_samples: 2}\n"
        "engine: mujoco\nengine_step: 0.001\n"
    )
    data = simulate(load_scenario(tmp_path / "s.yaml")).data
    swing = solve_ivp(
        lambda _, y: (y[1], -(damping * y[1] + torque * np.sin(y[0])) / moment),
        (0, data["time"][-1]),
        (angle, 0),
        t_eval=data["time"],
        rtol=1e-8,
    )
    np.testing.assert_allclose(data["plant.state"].sel(state="p_theta_q"), swing.y[0], atol=2e-3)


def test_a_held_box_is_held_as_hard_as_in_drake():
    one, other = (measured_runs("box_grasp", [RAMP | added])[0] for added in (STEPS, {}))
    assert one["grasp"] == other["grasp"] == "held"
    assert one["normal_force_n"] == pytest.approx(other["normal_force_n"], rel=0.05)


def test_the_same_runs_are_the_same_to_the_bit_and_differ_by_their_objects():
    light, heavy = ({"models.box.mass": mass} | RAMP | STEPS for mass in (0.05, 0.2))
    both = measured_runs("box_grasp", [light, heavy])
    assert str(both) == str(measured_runs("box_grasp", [light, heavy]))
    assert [each["grasp"] for each in both] == ["held", "resting"]


def test_a_run_does_not_depend_on_the_one_that_its_station_was_made_for():
    objects = (
        {"models.box.mass": 0.07, "models.box.friction": 0.9},
        {"models.box.mass": 0.19, "models.box.friction": 0.6},
    )
    brief = {"pressure.steps": {"all": [120e3]}, "pressure.settle": 0.4, "pressure.hold_samples": 10}
    light, heavy = (each | brief | STEPS for each in objects)
    found = []
    for first in (heavy, light):
        engine._stations.clear()
        measured_runs("box_grasp", [first])
        found.append(str(measured_runs("box_grasp", [heavy])))
    assert found[0] == found[1]


def test_a_task_is_planned_for_its_own_places_in_the_station_of_another():
    begins = {"task.time_limit": 1.0} | ENGINE | {"engine_step": 0.005}
    here, there = (
        changed_scenario("pick_and_place_box", begins | {"models.box.X_PC.translation.1": y}) for y in (-0.18, -0.15)
    )
    found = []
    for first in (here, there):
        engine._stations.clear()
        *_, run = run_many([first, there])
        found.append(run.recording["task.desired_state"].values)
        assert len(engine._stations) == 1
    assert np.array_equal(*found)


def test_a_task_in_the_station_of_another_is_checked_for_its_own_objects():
    """A second box stands where the arm lowers the first one, or beside it."""

    def with_other_at(y):
        base = changed_scenario("pick_and_place_box", {"task.time_limit": 0.1, "engine_step": 0.005} | ENGINE)
        box = next(model for model in base.models if model.name == "box")
        goal = base.task.X_WGoal.GetDeterministicValue()
        place = RigidTransform(goal.translation() + np.array([0.0, y, 0.0]))
        base.models.append(replace(box, name="other", X_PC=Transform(place)))
        return base

    for first, then in ((0.0, 0.3), (0.3, 0.0)):
        engine._stations.clear()
        runs = dict(zip((first, then), run_many([with_other_at(first), with_other_at(then)]), strict=True))
        assert "collides" in str(runs[0.0])
        assert not isinstance(runs[0.3], Exception)


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


def test_a_model_of_sdf_that_is_fixed_to_the_world_runs(tmp_path):
    """Its file's world is a link with next to no mass, less than MuJoCo takes."""
    joint = "<joint name='j' type='fixed'><parent>world</parent><child>a</child></joint>"
    (tmp_path / "shelf.sdf").write_text(f"<sdf version='1.9'><model name='m'><link name='a'/>{joint}</model></sdf>")
    (tmp_path / "s.yaml").write_text(
        "models:\n- {name: f, file: package://soft_gripper/grippers/finger.urdf}\n"
        "- {name: shelf, file: shelf.sdf, X_PC: {translation: [3, 0, 0]}}\n"
        "engine: mujoco\npressure: {steps: {all: [0]}, settle: 0.02, hold_samples: 2}\n"
    )
    assert simulate(load_scenario(tmp_path / "s.yaml")).data.sizes["time"] > 1


def test_models_that_mujoco_refuses_are_refused_in_a_line(monkeypatch):
    station_mjcf = plants.station_mjcf

    def without_size(*arguments):
        file = station_mjcf(*arguments)
        return file._replace(text=file.text.replace("<worldbody>", "<worldbody><geom type='box'/>"))

    monkeypatch.setattr(plants, "station_mjcf", without_size)
    with refused("engine", "mujoco") as error:
        simulate(changed_scenario("free_bending", ENGINE))
    assert "MuJoCo cannot read the models: Error: size 0 must be positive in geom" in str(error.value)
