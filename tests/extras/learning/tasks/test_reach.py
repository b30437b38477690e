"""Reach: what the distance of the true tip from the target earns, and how the target swings."""

import numpy as np
import pytest

from soft_gripper.extras.learning.config import ReachConfig, load_environment
from soft_gripper.extras.learning.station import make_learning_station
from soft_gripper.extras.learning.tasks import Reach

CONFIG = ReachConfig(pressure=[-20e3, 120e3], period=[2.0, 5.0], scale=0.01)


@pytest.fixture(scope="module")
def station():
    environment = load_environment("soft_reach")
    return make_learning_station(environment.config, environment.scenario)


def true_tip(station, context):
    """By Drake's kinematics of the plant, (2,) x, z in B, m: half a segment beyond the last joint."""
    plant, (finger,) = station.parts.plant, station.parts.fingers
    own, frame_B = plant.GetMyContextFromRoot(context), finger.base.body_frame()
    last = finger.joints[-1].frame_on_child()
    p_BTip = plant.CalcPointsPositions(own, last, [0.0, 0.0, finger.finger.segment_length / 2], frame_B)
    return p_BTip.ravel()[[0, 2]]


def test_it_earns_by_the_distance_of_the_true_tip_from_the_target(station):
    context = station.diagram.CreateDefaultContext()
    plant, (finger,) = station.parts.plant, station.parts.fingers
    plant.SetPositions(plant.GetMyMutableContextFromRoot(context), np.linspace(0.02, 0.1, len(finger.joints)))
    task = Reach(station, CONFIG, 0.05)
    task.begin(context, np.random.default_rng(0))
    target = station.target.get_output_port().Eval(station.target.GetMyContextFromRoot(context))
    error = np.linalg.norm(true_tip(station, context) - target)
    found = task.judge(context)
    assert found.info["tip_error"] == pytest.approx(error)
    assert found.reward == pytest.approx(0.05 / (1 + (error / 0.01) ** 2))
    assert not found.terminated


def test_targets_swing_within_the_limits(station):
    context, swings = station.diagram.CreateDefaultContext(), []
    for seed in range(100):
        Reach(station, CONFIG, 0.05).begin(context, np.random.default_rng(seed))
        swings.append(station.target.GetMyContextFromRoot(context).get_numeric_parameter(0).value().copy())
    mean, amplitude, period, phase = np.array(swings).T
    assert (mean - amplitude >= -20e3 - 1e-6).all()
    assert (mean + amplitude <= 120e3 + 1e-6).all()
    assert 35e3 <= amplitude.min() < 40e3
    assert 65e3 < amplitude.max() <= 70e3
    assert (period.min(), period.max()) == pytest.approx((2.0, 5.0), abs=0.2)
    assert (phase.min(), phase.max()) == pytest.approx((0.0, 2 * np.pi), abs=0.3)
