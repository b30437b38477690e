"""What tasks of environments earn, where their goals are, and when episodes are over."""

import numpy as np
import pytest

from soft_gripper.extras.learning.config import GraspConfig, PickPlaceConfig, ReachConfig, load_environment
from soft_gripper.extras.learning.environment import DrakeStation
from soft_gripper.extras.learning.episode_variation import Draw
from soft_gripper.extras.learning.station import PeakForce
from soft_gripper.extras.learning.tasks import GraspTask, PickPlace, Reach

ROW = np.array([0])


def begun(name, drawn=(), offset=0.0):
    """The station of a shipped environment, in an episode."""
    station = DrakeStation(load_environment(name, {"variation.grippers": 1}), None)
    station.begin(ROW, [Draw(offset=offset)], np.array([drawn]))
    return station


def root(station):
    return station.simulator.get_mutable_context()


def test_the_peak_is_no_less_than_what_presses_between_its_samples(monkeypatch):
    monkeypatch.setattr(PeakForce, "_now", lambda *_: np.array([0.9, 0.1]))
    assert begun("soft_grasp").normal_forces()[1] == [0.9]


class Told:
    """Truth of one station, as it is told."""

    def __init__(self, place, force=(0.0, 0.0), peak=1.0):
        self.place, self.force, self.peak = np.array([place]), np.array([force]), np.array([peak])

    def object_places(self):
        return self.place

    def normal_forces(self):
        return self.force, self.peak


REACH = ReachConfig(pressure=[-20e3, 120e3], period=[2.0, 5.0], scale=0.01)


def true_tip(station):
    """By Drake's kinematics of the plant, (2,) x, z in B, m: half a segment beyond the last joint."""
    plant, (finger,) = station.station.parts.plant, station.station.parts.fingers
    own, frame_B = plant.GetMyContextFromRoot(root(station)), finger.base.body_frame()
    last = finger.joints[-1].frame_on_child()
    p_BTip = plant.CalcPointsPositions(own, last, [0.0, 0.0, finger.finger.segment_length / 2], frame_B)
    return p_BTip.ravel()[[0, 2]]


def test_it_earns_by_the_distance_of_the_true_tip_from_the_target():
    task = Reach(REACH, 0.05)
    station = begun("soft_reach", task.draw(np.random.default_rng(0)))
    plant, (finger,) = station.station.parts.plant, station.station.parts.fingers
    plant.SetPositions(plant.GetMyMutableContextFromRoot(root(station)), np.linspace(0.02, 0.1, len(finger.joints)))
    block = station.station.target
    error = np.linalg.norm(true_tip(station) - block.get_output_port().Eval(block.GetMyContextFromRoot(root(station))))
    found = task.judge(station)
    assert found.info["tip_error"] == pytest.approx([error])
    assert found.reward == pytest.approx([0.05 / (1 + (error / 0.01) ** 2)])
    assert not found.terminated.any()


GRASP = GraspConfig(object="block", height=0.05, force_weight=0.2, crushing_force=5.0)


def judged(task, begin, place, force, peak, drawn=()):
    """The judgement of one episode, whose object begins at one place and is at another, m; forces and peak, N."""
    task.begin(ROW, np.array([drawn]), Told(begin))
    found = task.judge(Told(np.add(begin, place), force, peak))
    return found.reward[0], found.terminated[0], {name: value[0] for name, value in found.info.items()}


def judge_grasp(height, force=(0.0, 0.0), peak=1.0):
    """After a step of 0.1 s."""
    return judged(GraspTask(GRASP, 0.1, 1), [0.1, 0.0, 0.0], [0.0, 0.0, height], force, peak)


@pytest.mark.parametrize(
    ("height", "force", "reward"),
    [
        (0.025, (0.0, 0.0), 0.1 * 0.5),
        (0.025, (1.0, 0.5), 0.1 * (0.5 - 0.2 * 1.0)),
        (0.2, (0.0, 0.0), 0.1),  # higher is no better
        (-0.01, (0.0, 0.0), 0.0),
    ],
)
def test_height_earns_and_force_costs(height, force, reward):
    earned, terminated, _ = judge_grasp(height, force)
    assert earned == pytest.approx(reward)
    assert not terminated


def test_an_object_that_is_crushed_in_a_grasp_costs_one_and_ends_it():
    reward, terminated, _ = judge_grasp(0.05, (1.0, 1.0), 5.1)
    assert reward == pytest.approx(0.1 * 0.8 - 1)
    assert terminated
    assert not judge_grasp(0.05, (1.0, 1.0), 4.9)[1]


@pytest.mark.parametrize(
    ("height", "force", "peak", "success"),
    [
        (0.041, (0.3, 0.3), 1.0, True),
        (0.039, (0.3, 0.3), 1.0, False),
        (0.05, (0.3, 0.0), 1.0, False),  # it leans on one finger
        (0.05, (0.3, 0.3), 5.1, False),
    ],
)
def test_success_is_to_hang_in_all_fingers(height, force, peak, success):
    *_, info = judge_grasp(height, force, peak)
    assert info["success"] == success
    assert (info["height"], info["peak_force"], info["crushed"]) == (height, peak, peak > 5)
    np.testing.assert_array_equal(info["force"], force)


BEGINS = -0.08  # m, along x in the world
PICK_PLACE = PickPlaceConfig(object="block", tolerance=0.01, force_weight=0.05, crushing_force=5.0)


def judge(x, z=0.0, force=(0.0, 0.0), peak=1.0, way=0.08):
    """Where the object is, m from where it began, forces and their peak, N, and the way, m; after a step of 0.1 s."""
    task = PickPlace(PICK_PLACE, 0.1, 1)
    return judged(task, [BEGINS, 0.0, 0.03], [x, 0.0, z], force, peak, [BEGINS + way])


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
def test_what_of_the_way_is_done_earns_and_force_costs(x, way, share):
    assert judge(x, z=0.05, way=way)[0] == pytest.approx(0.1 * share, abs=1e-12)
    assert judge(x, 0.05, (1.0, 0.5), way=way)[0] == pytest.approx(0.1 * (share - 0.05), abs=1e-12)


@pytest.mark.parametrize(
    ("x", "z", "force", "placed"),
    [
        (0.073, 0.0, (0.0, 0.0), True),
        (0.069, 0.0, (0.0, 0.0), False),
        (0.08, 3e-3, (0.0, 0.0), False),
        (0.08, 0.0, (0.1, 0.0), False),  # a finger still touches it
    ],
)
def test_an_object_that_stands_alone_at_the_goal_earns_one_and_ends_it(x, z, force, placed):
    reward, terminated, info = judge(x, z, force)
    share = 1 - abs(x - 0.08) / 0.08 - 0.05 * max(force)
    assert reward == pytest.approx(0.1 * share + placed)
    assert terminated == placed
    assert info["success"] == placed
    assert info["error"] == pytest.approx(abs(x - 0.08))
