"""Numbers that options give: what is taken, and what is refused."""

import os

import pytest

from soft_gripper.commands.terminal.options import number_from_zero, number_of_jobs, whole_number
from soft_gripper.errors import InputError


@pytest.mark.parametrize(("text", "number"), [("2", 2), ("007", 7), ("40", 40)])
def test_whole_numbers_within_the_limits(text, number):
    assert whole_number("run", "--n", text, 2, 40) == number


@pytest.mark.parametrize(
    "text", ["1", "41", "-2", "+3", "3.0", "1e1", "", " 3", "three", "3" * 11, "\N{ARABIC-INDIC DIGIT THREE}"]
)
def test_no_whole_number_within_them(text):
    with pytest.raises(InputError, match="--n"):
        whole_number("run", "--n", text, 2, 40)


@pytest.mark.parametrize(("text", "number"), [("0", 0.0), ("1e-3", 1e-3), ("2", 2.0)])
def test_numbers_from_zero(text, number):
    assert number_from_zero("run", "--x", text, 2.0) == number


@pytest.mark.parametrize("text", ["-1e-9", "-5e-324", "2.1", "1e308", "inf", "nan", "1e999", "", "x"])
def test_no_number_from_zero(text):
    with pytest.raises(InputError, match="--x"):
        number_from_zero("run", "--x", text, 2.0)


def test_jobs_are_one_a_core_unless_they_are_given():
    assert number_of_jobs("run", None) == os.cpu_count()
    assert number_of_jobs("run", "3") == 3
    with pytest.raises(InputError, match="at least 1"):
        number_of_jobs("run", "0")
