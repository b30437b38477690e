"""Numbers in text: decimal digits alone, in a time that does not grow with their square; and changes of numbers."""

import pytest
from refusals import refused

from soft_gripper.files.number import changed, number
from soft_gripper.files.yaml_text import parse_yaml

ODD = ("1_0", "1\u0663", "infinity", "nan", "0x10", "1e", "", ".", "1 0", "--1", "1,5")


@pytest.mark.parametrize("text", ODD)
def test_what_is_not_decimal_is_refused(text):
    with pytest.raises(ValueError, match="not a number"):
        number(text)


@pytest.mark.parametrize("text", ["1_0", "0x10", "010", "1:30", "1.5_0", "-0b1"])
def test_yaml_has_decimal_numbers_alone(text):
    with refused("number", text):
        parse_yaml("a.yaml", f"a: {text}")
    assert parse_yaml("a.yaml", f"a: '{text}'") == {"a": text}


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
