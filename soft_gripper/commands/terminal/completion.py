"""What a shell completes: commands, options, files, and the names of the scenarios."""

import argparse
from collections.abc import Mapping

import shtab

from soft_gripper.commands.terminal.options import path
from soft_gripper.scenario.scenario_file import scenario_names

_FUNCTION = "_soft_gripper_scenarios"


def add_completion(parser: argparse.ArgumentParser, commands: Mapping[str, argparse.ArgumentParser]) -> None:
    """Declares `--print-completion SHELL`, by which a shell learns all commands."""
    names = " ".join(scenario_names())
    preamble = {
        "bash": f'{_FUNCTION}() {{ compgen -W "{names}" -- "$1"; compgen -f -- "$1"; }}',
        "zsh": f"{_FUNCTION}() {{ compadd {names}; _files; }}",
    }
    shtab.add_argument_to(
        parser, "--print-completion", help="print what completes commands in a shell, and end", preamble=preamble
    )
    for command in commands.values():
        for action in command._actions:
            if action.dest == "scenario":
                action.complete = dict.fromkeys(preamble, _FUNCTION)  # type: ignore[attr-defined]
            elif action.type is path:
                action.complete = shtab.FILE  # type: ignore[attr-defined]
