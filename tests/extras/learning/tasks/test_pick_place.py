"""PickPlace: what the way and forces earn, where the goal is, and when it is over."""

from dataclasses import replace

import numpy as np
import pytest

from soft_gripper.extras.learning.config import PickPlaceConfig, load_environment
from soft_gripper.extras.learning.episode_variation import Draw, apply_draw
from soft_gripper.extras.learning.station import make_learning_station
from soft_gripper.extras.learning.tasks import Handled, HandledObject, PickPlace

BEGINS = -0.08  # m, along x in the world
CONFIG = PickPlaceConfig(object="block", tolerance=0.01, force_weight=0.05, crushing_force=5.0)


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
        task = PickPlace(station, replace(CONFIG, goal=[BEGINS + way] * 2), 0.1)
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
    task = PickPlace(station, replace(CONFIG, goal=[0.05, 0.12]), 0.1)
    for seed in range(50):
        task.begin(context, np.random.default_rng(seed))
        observation = station.diagram.GetOutputPort("observation").Eval(context)
        seen.append(0.1 * observation[-1])  # its scale
    assert 0.05 <= min(seen) < 0.06
    assert 0.11 < max(seen) <= 0.12
