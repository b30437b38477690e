"""Many environments at once in MuJoCo, beside one in Drake."""

import numpy as np
import pytest

pytest.importorskip("mujoco")
gymnasium = pytest.importorskip("gymnasium")

import soft_gripper.extras.learning  # noqa: E402, F401, registers the environments
from soft_gripper.errors import InputError  # noqa: E402
from soft_gripper.extras.learning import SoftGripperEnv  # noqa: E402
from soft_gripper.extras.learning.vector_environment import SoftGripperVectorEnv  # noqa: E402

PLAIN = {"variation": {"grippers": 1}, "scenario.sensor.errors": None, "duration": 1.5}
CLOSE, LIFT = [0.7, -1.0], [0.7, 0.6]


def played(step, actions):
    """The last observation, and the sum of rewards."""
    total, observed = 0.0, None
    for action in actions:
        observed, reward, *_ = step(action)
        total = total + reward
    return observed, total


def test_observations_and_rewards_are_those_of_drake():
    one, many = SoftGripperEnv("soft_grasp", PLAIN), SoftGripperVectorEnv(2, "soft_grasp", PLAIN)
    first, _ = one.reset(seed=1)
    firsts, _ = many.reset(seed=1)
    assert firsts == pytest.approx(np.tile(first, (2, 1)), abs=1e-6)
    actions = [CLOSE] * 10 + [LIFT] * 4
    observed, earned = played(one.step, np.array(actions))
    observations, rewards = played(many.step, [np.tile(action, (2, 1)) for action in actions])
    assert observations == pytest.approx(np.tile(observed, (2, 1)), abs=0.02)
    assert rewards == pytest.approx(earned, abs=0.03)


def test_an_episode_that_is_over_begins_anew_in_the_next_step():
    env = gymnasium.make_vec(
        "SoftGrasp-v0", num_envs=4, vectorization_mode="vector_entry_point", changes={"duration": 0.2}
    )
    begins, _ = env.reset(seed=3)
    idle = np.tile([-1.0, -1.0], (4, 1))
    assert not env.step(idle)[3].any()
    assert env.step(idle)[3].all()
    observed, reward, terminated, truncated, info = env.step(idle)
    assert not terminated.any()
    assert not truncated.any()
    assert not reward.any()
    assert not info["_height"].any()
    assert np.abs(observed[:, :4] - begins[:, :4]).max() < 0.05


@pytest.mark.parametrize(("environment", "size"), [("soft_grasp", 2), ("soft_pick_place", 3)])
def test_episodes_follow_each_other_in_every_task(environment, size):
    """By their end, and by a reset; whatever is observed and acted is in the spaces of Gymnasium."""
    env = SoftGripperVectorEnv(2, environment, {"variation.grippers": 1, "duration": 0.1})
    first, _ = env.reset(seed=1)
    assert first in env.observation_space
    actions = env.action_space.sample()
    ends = [env.step(actions) for _ in range(3)]
    assert [ended[3].tolist() for ended in ends] == [[True] * 2, [False] * 2, [True] * 2]
    assert all(ended[0] in env.observation_space for ended in ends)
    assert (env.reset()[0] != first).any()
    np.testing.assert_array_equal(env.reset(seed=1)[0], first)
    assert actions.shape == (2, size)


def test_an_environment_without_an_object_is_refused():
    with pytest.raises(InputError, match="handles no object"):
        SoftGripperVectorEnv(2, "soft_reach")


@pytest.mark.parametrize("speed", [np.nan, 1e6])
def test_what_diverges_is_truncated_and_begins_anew_alone(speed):
    envs = [SoftGripperVectorEnv(2, "soft_grasp", PLAIN) for _ in range(2)]
    for env in envs:
        env.reset(seed=1)
    before = envs[0].step(np.tile(CLOSE, (2, 1)))[0]
    envs[1].step(np.tile(CLOSE, (2, 1)))
    envs[0]._stations._plants.batch.bind("qvel")[0, 5] = speed
    found, expected = ([env.step(np.tile(CLOSE, (2, 1))) for _ in range(3)] for env in envs)
    observed, reward, terminated, truncated, info = found[0]
    assert (list(info["diverged"]), list(truncated), list(terminated)) == ([True, False], [True, False], [False] * 2)
    assert (reward[0], observed[0].tolist()) == (0.0, before[0].tolist())
    assert np.isfinite(found[2][0]).all()
    for (one, *_), (other, *_) in zip(found, expected, strict=True):
        np.testing.assert_array_equal(one[1], other[1])
