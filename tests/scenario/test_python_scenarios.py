"""Scenarios in Python: copies, pickles, changes, files of models."""

import copy
import pickle
from dataclasses import replace

import numpy as np
import pytest
from refusals import refused

import soft_gripper as sg
from soft_gripper.piecewise_linear import PiecewiseLinear
from soft_gripper.scenario import checks
from soft_gripper.scenario.model_files import model_path

BASE = sg.load_scenario("free_bending")


def test_changes_hold_numbers_of_numpy():
    changes = {
        "pressure.steps.all": np.linspace(0, 1e4, 3),
        "sensor.sections": np.int64(2),
        "models.0.fingers": {"all": {"youngs_modulus": np.float64(9e5)}},
    }
    plain = {
        "pressure.steps.all": [0.0, 5e3, 1e4],
        "sensor.sections": 2,
        "models.0.fingers": {"all": {"youngs_modulus": 9e5}},
    }
    assert sg.changed_scenario("free_bending", changes) == sg.changed_scenario("free_bending", plain)


def test_a_scenario_of_python_holds_numbers_of_numpy():
    scenario = replace(
        BASE,
        gravity=np.array([0.0, 0.0, -9.8]),
        pressure=replace(BASE.pressure, steps={"all": np.array([0.0, 1e4])}),
        sensor=replace(BASE.sensor, period=np.float64(0.01), sections=np.int64(3)),
        nominal=sg.scenario.NominalConfig({"sensor_spacing": np.float64(0.0178), "youngs_modulus": 950000}),
    )
    found = sg.make_station(scenario).scenario
    assert (found.gravity, found.pressure.steps, found.sensor.sections) == ([0.0, 0.0, -9.8], {"all": [0.0, 1e4]}, 3)
    assert found.nominal.finger == {"sensor_spacing": "0.0178", "youngs_modulus": "950000"}
    assert "sections: 3" in sg.dump_scenario(scenario)
    assert isinstance(scenario.gravity, np.ndarray)  # what was given is left as it was


@pytest.mark.parametrize("fingers", [None, 3, {"all": 3}, {"all": {"width": [0.02]}}, {"all": {3: "0.02"}}])
def test_changes_of_fingers_are_text_or_numbers_by_paths(fingers):
    scenario = replace(BASE, models=[replace(BASE.models[0], fingers=fingers)])
    with pytest.raises(sg.InputError) as caught:
        sg.dump_scenario(scenario)
    assert caught.value.field.startswith("models[0].fingers")


@pytest.mark.parametrize(
    ("kp", "period", "minimum", "field"),
    [
        (None, 0.1, 0.0, "kp"),
        (1.0, 0.0, 0.0, "period"),
        (1.0, None, 0.0, "period"),
        (1.0, 0.1, None, "limits[0]"),
        (1.0, 0.1, 2.0, "limits"),
    ],
)
def test_gains_and_limits_of_a_controller(kp, period, minimum, field):
    with pytest.raises(sg.InputError) as caught:
        sg.PidController(sg.control.PidGains(kp), period, minimum, 1.0)
    assert caught.value.field == field


@pytest.mark.parametrize("name", [None, 3, ["free_bending"], float("nan")])
@pytest.mark.parametrize(
    "read",
    [
        sg.load_scenario,
        lambda name: sg.changed_scenario(name, {}),
        sg.scenario.load_calibration,
        sg.model_path,
    ],
)
def test_a_name_is_text(read, name):
    with pytest.raises(sg.InputError) as caught:
        read(name)
    assert caught.value.field == "name"


@pytest.mark.parametrize("overrides", [None, 3, "sensor.sections=3", [3]])
def test_overrides_are_a_list_of_text(overrides):
    with pytest.raises(sg.InputError):
        sg.load_scenario("free_bending", overrides)


@pytest.mark.parametrize(
    ("changes", "field"), [(None, "changes"), ([1], "changes"), ({3: 1}, "key"), ({None: 1}, "key")]
)
def test_changes_are_by_names(changes, field):
    with pytest.raises(sg.InputError) as caught:
        sg.changed_scenario("free_bending", changes)
    assert caught.value.field == field


@pytest.mark.parametrize(
    ("x", "y"), [((0, 2, 1), (0, 1, 2)), ((0, 1), (0, 1, 2)), ((), ()), (("a", "b"), (0, 1)), ((0, np.nan), (0, 1))]
)
def test_points_of_a_curve(x, y):
    with pytest.raises(sg.InputError) as caught:
        PiecewiseLinear(np.array(x), np.array(y))
    assert caught.value.field == "points"


def test_a_scenario_is_checked_once_and_again_when_it_was_changed(monkeypatch):
    checked = []
    monkeypatch.setattr(checks, "check_config", lambda where, config: checked.append(config))
    scenario = sg.load_scenario("free_bending")
    assert checks.checked_scenario("scenario", checks.checked_scenario("scenario", scenario)) == scenario
    assert not checked
    scenario.sensor.period = 0.02
    checks.checked_scenario("scenario", scenario)
    assert len(checked) == 1


@pytest.mark.parametrize("name", sg.scenario_names())
def test_a_scenario_survives_a_pickle_and_a_copy(name):
    scenario = sg.load_scenario(name)
    for again in (pickle.loads(pickle.dumps(scenario)), copy.deepcopy(scenario), sg.load_scenario(name)):
        assert again == scenario
        assert sg.dump_scenario(again) == sg.dump_scenario(scenario)


@pytest.mark.parametrize(
    "change",
    [
        "models.gripper.X_PC.translation=[0, 0, 0.5]",
        "models.gripper.X_PC.rotation=!Rpy {deg: [180, 0, 1]}",
        "plant_config.time_step=0.004",
        "simulator_config.accuracy=1e-4",
        "task.X_WGoal.translation=[0.5, 0.1, 0.2]",
        "sensor.sections=3",
    ],
)
def test_a_change_makes_another_scenario(change):
    assert sg.load_scenario("pick_and_place_box", [change]) != sg.load_scenario("pick_and_place_box")


def test_an_unknown_package_names_the_known_ones():
    with refused("file", "package://nosuch/thing.sdf"):
        model_path("package://nosuch/thing.sdf")
