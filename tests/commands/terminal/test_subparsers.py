"""Help of every command: what it does, and examples that can be typed as they are."""

import re
import shlex

import pytest

from soft_gripper.commands.dispatch import command_parser

HELP = command_parser().format_help()
COMMANDS = re.findall(r"^    ([a-z-]+)(?:  |$)", HELP, re.MULTILINE)


def examples(command, capsys):
    with pytest.raises(SystemExit):
        command_parser().parse_args([command, "--help"])
    text = capsys.readouterr().out
    return re.findall(r"^  (soft-gripper .*)$", text[text.index("examples:") :], re.MULTILINE)


def test_there_are_commands():
    assert {"run", "evaluate", "sweep", "doctor", "hardware"} <= set(COMMANDS)


@pytest.mark.parametrize("command", COMMANDS)
def test_examples_are_understood(command, capsys):
    lines = examples(command, capsys)
    assert lines
    for line in lines:
        program, *arguments = shlex.split(
            re.sub(r"(?<=\S)\s{2,}\S.*$", "", re.sub(rf"{command} {{2,}}.*$", command, line))
        )
        assert program == "soft-gripper"
        assert callable(command_parser().parse_args(arguments).command)


def test_exit_codes_are_listed():
    for words in ("0 done", "1 failed", "2 refused", "130 interrupted", "141 reader gone"):
        assert words in " ".join(HELP.split())
