"""What an agent gives to one environment or to many: both refuse the same in the same words."""

import numpy as np
import pytest

pytest.importorskip("mujoco")
pytest.importorskip("gymnasium")

from soft_gripper.errors import InputError
from soft_gripper.extras.learning import SoftGripperEnv
from soft_gripper.extras.learning.vector_environment import SoftGripperVectorEnv

PLAIN, COUNT = {"variation": {"grippers": 1}}, 3


@pytest.fixture(scope="module")
def both():
    """An environment, and several; each with what makes an action for it of that of one environment."""
    return (SoftGripperEnv("soft_grasp", PLAIN), lambda action: action), (
        SoftGripperVectorEnv(COUNT, "soft_grasp", PLAIN),
        lambda action: [action] * COUNT,
    )


def refusals(both, act):
    """What both say of a call that both refuse."""
    said = []
    for env, several in both:
        with pytest.raises(InputError) as caught:
            act(env, several)
        said.append((caught.value.where, caught.value.field.rstrip("s"), caught.value.expected))
    return said


WORDS = "text", None, {}, ["a", "b"], ["0", "0"], [1j, 0.0], np.array([0, 0], "M8[s]"), np.array([True, None])
NUMBERS = [0.0], [0.0, 0.0, 0.0], [0.0, [0.0]], [np.nan, 0.0], [10**400, 0.0]


@pytest.mark.parametrize("action", [*WORDS, *NUMBERS])
def test_actions_that_are_no_finite_numbers_of_the_shape_are_refused(both, action):
    for env, _ in both:
        env.reset(seed=0)
    for (where, field, expected), shape in zip(
        refusals(both, lambda env, several: env.step(several(action))), ("(2,)", f"({COUNT}, 2)"), strict=True
    ):
        assert (where, field) == ("step", "action")
        assert expected == f"give finite numbers of shape {shape}, from -1 to 1"


@pytest.mark.parametrize("seed", [-1, 2**70, 1.5, "1", np.float64(1), np.array(1.5), {1, 2, 3}])
def test_seeds_are_integers_of_64_bits(both, seed):
    one, many = refusals(both, lambda env, _: env.reset(seed=seed))
    assert one == many == ("reset", "seed", "give an integer from 0 to 2^64 - 1, or None")


@pytest.mark.parametrize(
    "seeds", [[1], [], [1, 2], [1, 2, 3, 4], np.array([1]), [1, 2, -1], [1, 2, 1.5], [[1, 2], [3], 4], np.ones(3)]
)
def test_there_is_a_seed_for_each_environment(both, seeds):
    with pytest.raises(InputError, match="reset: seed"):
        both[1][0].reset(seed=seeds)


@pytest.mark.parametrize("options", [{"mass": 1.0}, [], "text", 0, np.zeros(2)])
def test_there_are_no_options(both, options):
    one, many = refusals(both, lambda env, _: env.reset(seed=0, options=options))
    assert one == many == ("reset", "option", "there are none: leave them out")


def test_integers_of_numpy_are_seeds(both):
    (one, _), (many, _) = both
    expected, all_expected = one.reset(seed=5)[0], many.reset(seed=5)[0]
    np.testing.assert_array_equal(one.reset(seed=np.int64(5), options={})[0], expected)
    for seeds in (np.uint8(5), [5, 6, 7], np.array([5, 6, 7]), (np.int64(5), 6, 7)):
        np.testing.assert_array_equal(many.reset(seed=seeds)[0], all_expected)


def test_nothing_is_done_before_a_reset_nor_after_the_end():
    both = (SoftGripperEnv("soft_grasp", PLAIN), list), (SoftGripperVectorEnv(1, "soft_grasp", PLAIN), lambda a: [a])
    acts = {
        "step": lambda env, several: env.step(several([0.0, 0.0])),
        "render": lambda env, _: env.render(),
        "reset": lambda env, _: env.reset(),
    }
    for name in ("step", "render"):
        one, many = refusals(both, acts[name])
        assert one == many == (name, "environment", "call reset() first")
    for env, _ in both:
        env.reset()
    assert {field for _, field, _ in refusals(both, acts["render"])} == {"render_mode"}
    for env, _ in both:
        env.close()
        env.close()
    for name, act in acts.items():
        one, many = refusals(both, act)
        assert one == many == (name, "environment", "make another one")
