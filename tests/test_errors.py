"""Messages are one line and say where, what, which value and what would do."""

import pickle

from soft_gripper.errors import InputError

ERROR = InputError("finger 'left'", "base.width", -0.02, "give a finite number above 0")


def test_message_is_complete():
    assert str(ERROR) == "finger 'left': base.width = -0.02: give a finite number above 0"
    assert isinstance(ERROR, ValueError)


def test_value_cannot_break_the_line():
    assert "\n" not in str(InputError("file", "name", "two\nlines", "give one line"))


def test_inside_names_the_holder_first_and_keeps_the_rest():
    outer = ERROR.inside("gripper.urdf").inside("models[0]")
    assert str(outer) == f"models[0]: gripper.urdf: {ERROR}"
    assert (outer.field, outer.value, outer.expected) == (ERROR.field, ERROR.value, ERROR.expected)


def test_error_crosses_processes():
    assert str(pickle.loads(pickle.dumps(ERROR))) == str(ERROR)
