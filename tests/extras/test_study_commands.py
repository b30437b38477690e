"""The word `study` before the commands of studies, on the command line."""

import pytest

from soft_gripper.commands.parser import parse_options
from soft_gripper.errors import InputError


def test_a_study_without_the_word_is_answered_with_it():
    with pytest.raises(InputError, match="did you mean 'study grasp-trials'"):
        parse_options(["grasp-trials", "--jobs", "2"])
