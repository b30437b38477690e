"""The word `study` before the commands of studies, on the command line."""

import pytest

from soft_gripper.commands.parser import command_parser, parsed
from soft_gripper.errors import InputError


def test_a_study_without_the_word_is_answered_with_it():
    with pytest.raises(InputError, match="did you mean 'study robustness'"):
        parsed(["robustness", "--jobs", "2"])


@pytest.mark.parametrize("line", ["study", "study frob", "play --grip hard"])
def test_mistakes_that_argparse_finds_are_one_line(line, capsys):
    with pytest.raises(SystemExit) as caught:
        parsed(line.split())
    assert caught.value.code == 2
    said = capsys.readouterr().err
    assert said.startswith("soft-gripper: ")
    assert said.count("\n") == 1


def test_help_fits_a_hundred_columns_of_a_wider_terminal(capsys, monkeypatch):
    monkeypatch.setenv("COLUMNS", "300")
    with pytest.raises(SystemExit):
        command_parser().parse_args(["study", "--help"])
    assert [line for line in capsys.readouterr().out.splitlines() if len(line) > 100] == []
