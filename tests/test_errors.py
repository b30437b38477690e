"""Messages are one line and say where, what, which value and what would do."""

import pytest

from soft_gripper.errors import InputError, similar_names

ERROR = InputError("finger 'left'", "base.width", -0.02, "give a finite number above 0")


def test_message_is_complete():
    assert str(ERROR) == "finger 'left': base.width = -0.02: give a finite number above 0"
    assert isinstance(ERROR, ValueError)


def test_inside_names_the_holder_first_and_keeps_the_rest():
    outer = ERROR.inside("gripper.urdf").inside("models[0]")
    assert str(outer) == f"models[0]: gripper.urdf: {ERROR}"
    assert (outer.field, outer.value, outer.expected) == (ERROR.field, ERROR.value, ERROR.expected)


def test_long_values_lose_their_middle():
    for value in ("x" * 50_000, list(range(50_000)), 10**4000, 16**6000):
        assert len(str(InputError("file", "name", value, "give less"))) < 300
    assert len(str(InputError("x" * 50_000, "y" * 50_000, 1, "z" * 50_000))) < 3000
    assert str(InputError("file", "name", "x" * 500 + "end", "give less")).endswith("end': give less")


def test_characters_that_steer_a_terminal_are_shown_as_what_they_are():
    assert str(InputError("a\x1b[2Jb", "c\rd", 0, "e\u202ef")) == "a\\x1b[2Jb: c\\rd = 0: e\\u202ef"


@pytest.mark.parametrize(
    ("name", "near"),
    [
        ("Gravty", ["gravity"]),
        ("timestep", ["time_step"]),
        ("step", ["steps", "time_step"]),
        ("max", ["maximum"]),
        ("kpp", ["kp"]),
        ("pk", ["kp"]),
        ("seed.", ["seed"]),
        *((name, []) for name in ("simulation", "simulator", "duration", "modulus", "m", "", "§", "x" * 10_000)),
    ],
)
def test_a_name_is_near_those_spelt_like_it_or_of_which_it_is_a_part(name, near):
    known = [
        "visualization",
        "estimator",
        "description",
        "models",
        "gravity",
        "steps",
        "time_step",
        "maximum",
        "kp",
        "seed",
    ]
    assert similar_names(name, known) == near
