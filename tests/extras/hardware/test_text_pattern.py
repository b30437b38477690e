"""Patterns of names: what they match, what is refused, and that none of them takes long."""

import time

import pytest

from soft_gripper.extras.hardware.text_pattern import filled, find, pattern_problem, plain_number_pattern


@pytest.mark.parametrize(
    ("pattern", "text", "matched"),
    [
        *(
            ("{number}kPa", "day2_12.5kPa", "12.5kPa"),
            ("{number}kPa", "1,5kPa", None),
            ("_{number}g", "a_200g_1", "_200g"),
        ),
        *(("load.{number}", "load.7", "load.7"), ("pair{number}_{word}", "r1_pair12_same_dir0", "pair12_same")),
        *(
            ("{word}{number}", "x_ab12", "ab12"),
            ("a.b", "axb", None),
            ("a.b", "a.b", "a.b"),
            ("{number}", "\u0663", None),
        ),
    ],
)
def test_what_a_pattern_matches(pattern, text, matched):
    found = find(pattern, text)
    assert (found and found[0]) == matched


def test_placeholders_are_replaced_and_nothing_else():
    """They are no format strings: no attributes, no widths, and what is put there is not looked at again."""
    assert filled("{marker}_{axis}", {"marker": "{axis}", "axis": "x"}) == "{axis}_x"
    for pattern in ("{marker:3000000000}_{axis}", "{marker.__class__}{marker}{axis}", "{0}{marker}{axis}"):
        assert "placeholders are" in pattern_problem(f"{pattern}{{marker}}", ("marker", "axis"))
    assert pattern_problem("{marker}", ("marker", "axis")) == "must have {marker} and {axis}"
    assert pattern_problem("{marker}{axis}" + 200 * "x", ("marker", "axis")) == "must have at most 200 characters"


def test_numbers_of_earlier_descriptions_are_still_read():
    assert plain_number_pattern(r"_(\d+)g") == "_{number}g"
    assert plain_number_pattern(r"(\d+(?:\.\d+)?)kPa") == "{number}kPa"
    for pattern in (r"load_?(\d+)", r"load.(\d+)", r"(\d+)g|(\d+)kg"):
        assert plain_number_pattern(pattern) == pattern


@pytest.mark.parametrize("pattern", ["{number}x", "{word}x", "{word}{number}{word}{number}x", "a{number}b"])
@pytest.mark.parametrize("text", [10**6 * "9", 10**6 * "a", 10**5 * "a9"])
def test_no_text_takes_long(pattern, text):
    began = time.process_time()
    assert find(pattern, text) is None or "x" not in pattern
    assert time.process_time() - began < 1
