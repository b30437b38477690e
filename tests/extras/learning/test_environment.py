"""Environments: files, changes, mistakes, and one that is stepped."""

import warnings
from urllib.parse import urlsplit

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env
from refusals import refused

import soft_gripper.extras.learning  # noqa: F401  registers
from soft_gripper.errors import InputError
from soft_gripper.extras.learning.config import environment_names, load_environment
from soft_gripper.extras.learning.environment import SoftGripperEnv, open_meshcat

IDS = ("SoftReach-v0", "SoftGrasp-v0", "SoftPickPlace-v0")


@pytest.mark.parametrize("name", IDS)
def test_gymnasium_finds_nothing_wrong(name):
    env = gymnasium.make(name, changes={"variation.grippers": 1})
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        check_env(env.unwrapped, skip_render_check=True)


def test_episodes_take_each_of_the_grippers_and_another_target():
    """The target is what is observed last."""
    env = SoftGripperEnv("soft_reach", {"variation.grippers": 2, "variation.youngs_modulus": 0.1})
    targets, moduli = [], []
    for seed in range(10):
        targets.append(tuple(env.reset(seed=seed)[0][-2:]))
        moduli.append(env._station.station.parts.fingers[0].finger.base.youngs_modulus)
    assert len(set(targets)) == 10
    assert max(moduli) == pytest.approx(1.1 / 0.9 * min(moduli))


@pytest.mark.parametrize("fault", ["not finite", "solver"])
def test_divergence_truncates_and_says_why(one_gripper, monkeypatch, fault):
    observed, _ = one_gripper.reset(seed=0)
    own = one_gripper._station
    simulator, plant = own.simulator, own.station.parts.plant
    if fault == "not finite":
        context = plant.GetMyMutableContextFromRoot(simulator.get_mutable_context())
        context.get_mutable_discrete_state_vector().SetFromVector(np.full(plant.num_multibody_states(), np.nan))
    else:

        class Failing:
            def __getattr__(self, name):
                return getattr(simulator, name)

            def AdvanceTo(self, time):  # noqa: N802
                raise RuntimeError("no convergence")

        monkeypatch.setattr(own, "simulator", Failing())
    observation, reward, terminated, truncated, info = one_gripper.step(np.zeros(2, np.float32))
    np.testing.assert_array_equal(observation, observed)
    assert (reward, terminated, truncated) == (0.0, False, True)
    assert info["diverged"]
    monkeypatch.undo()
    assert np.isfinite(one_gripper.reset(seed=0)[0]).all()


def test_actions_beyond_the_limits_are_those_at_the_limits(one_gripper):
    seen = []
    for factor in (1.0, 3.0):
        one_gripper.reset(seed=0)
        seen.append([one_gripper.step(factor * np.array([-1.0, -1.0], np.float32))[0] for _ in range(3)])
    np.testing.assert_array_equal(*seen)


def test_a_picture_is_taken():
    env = SoftGripperEnv("soft_reach", {"variation.grippers": 1}, render_mode="rgb_array")
    env.reset(seed=0)
    picture = env.render()
    assert picture.shape == (360, 480, 3)
    assert picture.dtype == np.uint8
    assert picture.std() > 5
    env.step(np.ones(1, np.float32))
    assert (env.render() != picture).any()


def test_unknown_modes_are_refused():
    with refused("render_mode", "paper"):
        SoftGripperEnv("soft_reach", render_mode="paper")


@pytest.mark.parametrize("name", environment_names())
def test_what_is_shipped_loads(name):
    environment = load_environment(name)
    assert environment.config.description
    assert environment.scenario.external[0] == "pressure"


@pytest.mark.parametrize("name", [None, 3, ["free_bending"], float("nan"), "soft_gasp"])
def test_a_name_is_that_of_a_file_or_shipped(name):
    with refused("name", name):
        load_environment(name)


def test_changes_reach_the_environment_and_its_scenario():
    changes = {"variation.mass": [0.1, 0.2], "scenario.sensor.sections": 4, "action.grip": "opening"}
    environment = load_environment("soft_grasp", changes)
    assert environment.config.variation.mass == [0.1, 0.2]
    assert environment.scenario.sensor.sections == 4
    assert environment.scenario.external == ["opening", "joints"]


def test_a_file_of_ones_own_names_its_scenario_beside_it(tmp_path):
    text = "scenario: free_bending\nobservation: [{signal: left_finger.tip_pose}]\nreach: {}\n"
    path = tmp_path / "own.yaml"
    path.write_text(text)
    assert len(load_environment(str(path)).scenario.models) == 2


@pytest.mark.parametrize(
    ("changes", "field"),
    [
        ({"action.range": [1.0, 0.0]}, "action.range"),
        ({"action.range": [2e4, 2e4], "action.rest": 2e4}, "action.range"),
        ({"action.joints": {"z": [0.0, 0.0]}}, "action.joints.z"),
        ({"action.rest": 1e6}, "action.rest"),
        ({"variation.gripper": "hand"}, "variation.gripper"),
        ({"scenario.models.1.fingers": {"all": {"youngs_modulus": "5e5"}}}, "variation.youngs_modulus"),
        ({"scenario.nominal.finger.youngs_modulus": "+30 %"}, "variation.youngs_modulus"),
        ({"grasp.object": "apple"}, "grasp.object"),
        ({"reach": {}}, "reach"),
        ({"observation": []}, "observation"),
        ({"time_step": 0.01}, "time_step"),
        ({"duration": 0.01}, "duration"),
        ({"nothing.here.at.all.0": 1}, "nothing"),
    ],
)
def test_mistakes_are_named(changes, field):
    with pytest.raises(InputError) as caught:
        load_environment("soft_grasp", changes)
    assert caught.value.field == field


def test_an_environment_is_shown_on_this_machine_alone():
    assert urlsplit(open_meshcat().web_url()).hostname in ("127.0.0.1", "localhost")
