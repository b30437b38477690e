"""Learning on a grasp that is a formula, files of what was learned, and the comparison."""

from itertools import islice

import pytest

from gentle_grasp import learn as module
from gentle_grasp.episodes import Episode, saved_force, summary
from gentle_grasp.learn import FAILURE, LARGEST, cost, learn, load_learned, save_learned, training_seeds
from soft_gripper.extras.learning.config import load_environment

VARIATION = load_environment("soft_grasp").config.variation


def needed(seed):
    return module.needed(seed, VARIATION)


def formula(environments, policies, seeds):
    """Force is in proportion to the torque that is held, and holds what is not too heavy for it."""
    forces = [policy._parameters.target / 0.11 for policy in policies]
    pairs = zip(seeds, forces, strict=True)
    return [Episode(seed, force > needed(seed) * 9.81 / 2, force) for seed, force in pairs]


@pytest.fixture
def learned(monkeypatch):
    monkeypatch.setattr(module, "run_episodes", formula)
    return [*islice(learn(None, 8, 8, 1), 25)]


def test_the_least_force_that_holds_is_found(learned):
    heaviest = max(map(needed, training_seeds(8)))
    assert learned[-1][0].target / 0.11 == pytest.approx(heaviest * 9.81 / 2, rel=0.05)
    assert learned[-1][1].cost < learned[0][1].cost
    assert [generation.episodes for _, generation in learned[:3]] == [64, 128, 192]


def test_the_same_seed_learns_the_same(learned):
    assert [*islice(learn(None, 8, 8, 1), 3)] == learned[:3]


def test_how_hard_an_object_is_to_hold_is_known_from_its_seed(one_gripper):
    info = one_gripper.reset(seed=7)[1]
    assert module.needed(7, one_gripper.environment.config.variation) == pytest.approx(info["mass"] / info["friction"])


def test_failures_cost_more_than_any_force():
    assert cost([Episode(0, True, 0.5), Episode(1, True, 0.7)]) == pytest.approx(0.6)
    assert cost([Episode(0, False, 100.0)]) == FAILURE + LARGEST
    assert cost([Episode(0, False, float("nan"))]) == FAILURE + LARGEST  # one that diverged


def test_what_was_learned_is_read_as_it_was_written(learned, tmp_path):
    parameters, curve = learned[-1][0], [generation for _, generation in learned]
    save_learned(tmp_path / "learned.yaml", parameters, curve)
    assert load_learned(tmp_path / "learned.yaml") == (parameters, curve)


def test_what_is_shipped_is_there():
    parameters, curve = load_learned()
    assert parameters.target > 0
    assert curve


def test_policies_are_compared_over_the_same_objects():
    hand = [Episode(seed, True, 0.6 + 0.01 * (seed % 3)) for seed in range(30)]
    gentle = [Episode(seed, seed != 0, 0.4 + 0.01 * (seed % 3)) for seed in range(30)]
    found = summary("learned", gentle)
    assert found.success.value == pytest.approx(29 / 30)
    assert "0.967" in str(found)
    assert saved_force(hand, gentle) == pytest.approx((0.2, 0.2, 0.2))
    with pytest.raises(ValueError, match="same objects"):
        saved_force(hand, gentle[1:])
