"""The command line of the studies: one help, a module for each, one line for a mistake."""

import ast
from importlib.util import find_spec
from pathlib import Path

import pytest
from refusals import refusal

from soft_gripper.commands.parser import command_parser
from studies import ROOT
from studies.commands import COMMANDS, STUDIES


@pytest.mark.parametrize("command", COMMANDS, ids=lambda command: command.name)
def test_the_module_of_a_study_runs_it(command):
    text = Path(find_spec(command.module).origin).read_text(encoding="utf-8")
    assert "run" in [each.name for each in ast.parse(text).body if isinstance(each, ast.FunctionDef)]


def test_one_help_lists_all():
    text = command_parser(STUDIES).format_help()
    assert [command.name for command in COMMANDS if f"\n  {command.name} " not in text] == []


def test_every_folder_is_named_in_the_readme():
    folders = {path.parent.name for path in (ROOT / "studies").glob("*/__init__.py")}
    text = (ROOT / "studies" / "README.md").read_text(encoding="utf-8")
    assert [name for name in folders if f"`{name}`" not in text] == []


def test_a_mistake_is_one_line():
    assert "did you mean 'robustness'" in refusal("robustnes", program=STUDIES)
