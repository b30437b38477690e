"""The word `study` before the commands of studies, on the command line."""

import pytest
from command_line import complaint, help_of

from soft_gripper.commands.parser import parse_options
from soft_gripper.errors import InputError


def test_a_study_without_the_word_is_answered_with_it():
    with pytest.raises(InputError, match="did you mean 'study health'"):
        parse_options(["health", "--jobs", "2"])


@pytest.mark.parametrize("line", ["study", "study frob", "play --grip hard"])
def test_mistakes_that_argparse_finds_are_one_line(line):
    assert complaint(line)


def test_help_fits_a_hundred_columns_of_a_wider_terminal(monkeypatch):
    monkeypatch.setenv("COLUMNS", "300")
    assert [line for line in help_of("study").splitlines() if len(line) > 100] == []
