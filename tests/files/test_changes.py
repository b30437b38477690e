"""Changes of numbers: by what sign and percent say, and by dotted keys."""

import pytest

from soft_gripper.files.changes import changed, dotted
from soft_gripper.quantity import Rule


@pytest.mark.parametrize(
    ("text", "expected"),
    [("3", 3.0), ("-3e-2", -0.03), (" .5 ", 0.5), ("+10 %", 2.2), ("-2.5%", 1.95), (" +0 % ", 2.0)],
)
def test_a_percentage_is_added_to_the_number_before_which_a_number_replaces(text, expected):
    assert changed(text, 2.0) == pytest.approx(expected, rel=1e-15)


@pytest.mark.parametrize(
    "text", ["", "%", "10 %", ".1 %", "+3", "+1 % %", "+1 % 2", "3 mm", "nan", "1e999", "+1e999 %"]
)
def test_text_without_a_number_or_the_sign_of_a_change_is_refused(text):
    with pytest.raises(ValueError, match="number"):
        changed(text, 2.0)


def test_keys_have_dots_down_to_a_path_and_what_is_none_is_left_out():
    changes = {"a": {"b": 1, "c": {"d": None}}, "e": {"f": 2.5, "g": True}, "h.i": "+1 %"}
    assert dotted(changes, {"e": Rule()}) == {"a.b": "1", "e": {"f": 2.5, "g": True}, "h.i": "+1 %"}
    assert dotted([changes], {}) == [changes]
