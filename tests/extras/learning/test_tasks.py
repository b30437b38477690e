"""What tasks of environments earn, where their goals are, and when episodes are over."""

from dataclasses import replace

import numpy as np
import pytest
from pydrake.math import RigidTransform

from soft_gripper.extras.learning.config import GraspConfig, PickPlaceConfig, ReachConfig, load_environment
from soft_gripper.extras.learning.episode_variation import Draw, apply_draw
from soft_gripper.extras.learning.station import PeakForce, make_learning_station
from soft_gripper.extras.learning.tasks import Grasp, Handled, HandledObject, PickPlace, Reach


def begun(station):
    """An object that begins 3 mm off, in a context."""
    context = station.diagram.CreateDefaultContext()
    apply_draw(station, context, Draw(offset=3e-3))
    handled = HandledObject(station)
    handled.begin(context, np.random.default_rng())
    return handled, context


def test_its_place_is_counted_from_where_the_episode_began(grasp_station):
    handled, context = begun(grasp_station)
    np.testing.assert_array_equal(handled.look(context).place, np.zeros(3))
    assert handled.begins_at[0] == 3e-3
    plant, body = grasp_station.parts.plant, grasp_station.object
    X_WO = RigidTransform(handled.begins_at + np.array([0.01, 0.0, 0.02]))
    plant.SetFreeBodyPose(plant.GetMyMutableContextFromRoot(context), body, X_WO)
    np.testing.assert_allclose(handled.look(context).place, [0.01, 0.0, 0.02], atol=1e-15)


def test_the_peak_is_that_of_the_finger_that_has_pressed_hardest(grasp_station):
    handled, context = begun(grasp_station)
    own = grasp_station.forces.GetMyMutableContextFromRoot(context)
    own.SetDiscreteState([0.3, 0.7])
    seen = handled.look(context)
    assert seen.peak == 0.7
    assert not seen.force.any()


def test_the_peak_is_no_less_than_what_presses_between_its_samples(grasp_station, monkeypatch):
    monkeypatch.setattr(PeakForce, "_now", lambda *_: np.array([0.9, 0.1]))
    handled, context = begun(grasp_station)
    assert handled.look(context).peak == 0.9


REACH = ReachConfig(pressure=[-20e3, 120e3], period=[2.0, 5.0], scale=0.01)


@pytest.fixture(scope="module")
def reach_station():
    environment = load_environment("soft_reach")
    return make_learning_station(environment.config, environment.scenario)


def true_tip(reach_station, context):
    """By Drake's kinematics of the plant, (2,) x, z in B, m: half a segment beyond the last joint."""
    plant, (finger,) = reach_station.parts.plant, reach_station.parts.fingers
    own, frame_B = plant.GetMyContextFromRoot(context), finger.base.body_frame()
    last = finger.joints[-1].frame_on_child()
    p_BTip = plant.CalcPointsPositions(own, last, [0.0, 0.0, finger.finger.segment_length / 2], frame_B)
    return p_BTip.ravel()[[0, 2]]


def test_it_earns_by_the_distance_of_the_true_tip_from_the_target(reach_station):
    context = reach_station.diagram.CreateDefaultContext()
    plant, (finger,) = reach_station.parts.plant, reach_station.parts.fingers
    plant.SetPositions(plant.GetMyMutableContextFromRoot(context), np.linspace(0.02, 0.1, len(finger.joints)))
    task = Reach(reach_station, REACH, 0.05)
    task.begin(context, np.random.default_rng(0))
    target = reach_station.target.get_output_port().Eval(reach_station.target.GetMyContextFromRoot(context))
    error = np.linalg.norm(true_tip(reach_station, context) - target)
    found = task.judge(context)
    assert found.info["tip_error"] == pytest.approx(error)
    assert found.reward == pytest.approx(0.05 / (1 + (error / 0.01) ** 2))
    assert not found.terminated


def test_targets_swing_within_the_limits(reach_station):
    context, swings = reach_station.diagram.CreateDefaultContext(), []
    for seed in range(100):
        Reach(reach_station, REACH, 0.05).begin(context, np.random.default_rng(seed))
        swings.append(reach_station.target.GetMyContextFromRoot(context).get_numeric_parameter(0).value().copy())
    mean, amplitude, period, phase = np.array(swings).T
    assert (mean - amplitude >= -20e3 - 1e-6).all()
    assert (mean + amplitude <= 120e3 + 1e-6).all()
    assert 35e3 <= amplitude.min() < 40e3
    assert 65e3 < amplitude.max() <= 70e3
    assert (period.min(), period.max()) == pytest.approx((2.0, 5.0), abs=0.2)
    assert (phase.min(), phase.max()) == pytest.approx((0.0, 2 * np.pi), abs=0.3)


GRASP = GraspConfig(object="block", height=0.05, force_weight=0.2, crushing_force=5.0)


@pytest.fixture
def judge_grasp(grasp_station, monkeypatch):
    """Judges a height, m, forces and their peak, N, after steps of 0.1 s."""

    def judged(height, force=(0.0, 0.0), peak=1.0):
        seen = Handled(np.array([0.0, 0.0, height]), np.array(force), peak)
        monkeypatch.setattr(HandledObject, "look", lambda *_: seen)
        return Grasp(grasp_station, GRASP, 0.1).judge(None)

    return judged


@pytest.mark.parametrize(
    ("height", "force", "reward"),
    [
        (0.025, (0.0, 0.0), 0.1 * 0.5),
        (0.025, (1.0, 0.5), 0.1 * (0.5 - 0.2 * 1.0)),
        (0.2, (0.0, 0.0), 0.1),  # higher is no better
        (-0.01, (0.0, 0.0), 0.0),
    ],
)
def test_height_earns_and_force_costs(judge_grasp, height, force, reward):
    found = judge_grasp(height, force)
    assert found.reward == pytest.approx(reward)
    assert not found.terminated


def test_an_object_that_is_crushed_in_a_grasp_costs_one_and_ends_it(judge_grasp):
    found = judge_grasp(0.05, (1.0, 1.0), 5.1)
    assert found.reward == pytest.approx(0.1 * 0.8 - 1)
    assert found.terminated
    assert not judge_grasp(0.05, (1.0, 1.0), 4.9).terminated


@pytest.mark.parametrize(
    ("height", "force", "peak", "success"),
    [
        (0.041, (0.3, 0.3), 1.0, True),
        (0.039, (0.3, 0.3), 1.0, False),
        (0.05, (0.3, 0.0), 1.0, False),  # it leans on one finger
        (0.05, (0.3, 0.3), 5.1, False),
    ],
)
def test_success_is_to_hang_in_all_fingers(judge_grasp, height, force, peak, success):
    info = judge_grasp(height, force, peak).info
    assert info["success"] is success
    assert (info["height"], info["peak_force"], info["crushed"]) == (height, peak, peak > 5)
    np.testing.assert_array_equal(info["force"], force)


BEGINS = -0.08  # m, along x in the world
PICK_PLACE = PickPlaceConfig(object="block", tolerance=0.01, force_weight=0.05, crushing_force=5.0)


@pytest.fixture(scope="module")
def station():
    environment = load_environment("soft_pick_place")
    return make_learning_station(environment.config, environment.scenario)


@pytest.fixture
def judge(station, monkeypatch):
    """Judges where the object is, m from where it began, forces and their peak, N, and the way, m; steps of 0.1 s."""

    def judged(x, z=0.0, force=(0.0, 0.0), peak=1.0, way=0.08):
        context = station.diagram.CreateDefaultContext()
        apply_draw(station, context, Draw(offset=0.02))
        task = PickPlace(station, replace(PICK_PLACE, goal=[BEGINS + way] * 2), 0.1)
        task.begin(context, np.random.default_rng(0))
        seen = Handled(np.array([x, 0.0, z]), np.array(force), peak)
        monkeypatch.setattr(HandledObject, "look", lambda *_: seen)
        return task.judge(context)

    return judged


@pytest.mark.parametrize(
    ("x", "way", "share"),
    [
        (0.0, 0.08, 0.0),
        (0.02, 0.08, 0.25),
        (0.08, 0.08, 1.0),
        (0.12, 0.08, 0.5),
        (-0.02, 0.08, 0.0),
        (-0.02, -0.08, 0.25),  # a goal on the other side
        (0.004, 0.0, 0.6),  # none: what is off counts by the tolerance
    ],
)
def test_what_of_the_way_is_done_earns_and_force_costs(judge, x, way, share):
    assert judge(x, z=0.05, way=way).reward == pytest.approx(0.1 * share, abs=1e-12)
    assert judge(x, 0.05, (1.0, 0.5), way=way).reward == pytest.approx(0.1 * (share - 0.05), abs=1e-12)


@pytest.mark.parametrize(
    ("x", "z", "force", "placed"),
    [
        (0.073, 0.0, (0.0, 0.0), True),
        (0.069, 0.0, (0.0, 0.0), False),
        (0.08, 3e-3, (0.0, 0.0), False),
        (0.08, 0.0, (0.1, 0.0), False),  # a finger still touches it
    ],
)
def test_an_object_that_stands_alone_at_the_goal_earns_one_and_ends_it(judge, x, z, force, placed):
    found = judge(x, z, force)
    share = 1 - abs(x - 0.08) / 0.08 - 0.05 * max(force)
    assert found.reward == pytest.approx(0.1 * share + placed)
    assert found.terminated is placed
    assert found.info["success"] is placed
    assert found.info["error"] == pytest.approx(abs(x - 0.08))


def test_a_crushed_object_costs_one_and_ends_it(judge):
    found = judge(0.0, peak=5.1)
    assert found.reward == pytest.approx(-1.0)
    assert found.terminated
    assert found.info["crushed"]


def test_goals_are_drawn_within_their_limits_and_observed(station):
    context, seen = station.diagram.CreateDefaultContext(), []
    task = PickPlace(station, replace(PICK_PLACE, goal=[0.05, 0.12]), 0.1)
    for seed in range(50):
        task.begin(context, np.random.default_rng(seed))
        observation = station.diagram.GetOutputPort("observation").Eval(context)
        seen.append(0.1 * observation[-1])  # its scale
    assert 0.05 <= min(seen) < 0.06
    assert 0.11 < max(seen) <= 0.12
