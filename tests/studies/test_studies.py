"""The command line of the studies: one help, a module for each, one line for a mistake."""

import ast
import re
from importlib.util import find_spec
from pathlib import Path

import pytest

from studies import ROOT
from studies.commands import COMMANDS


@pytest.mark.parametrize("command", COMMANDS, ids=lambda command: command.name)
def test_the_module_of_a_study_runs_it(command):
    text = Path(find_spec(command.module).origin).read_text(encoding="utf-8")
    assert "run" in [each.name for each in ast.parse(text).body if isinstance(each, ast.FunctionDef)]


def test_every_folder_is_named_in_the_readme():
    folders = {path.parent.name for path in (ROOT / "studies").glob("*/__init__.py")}
    text = (ROOT / "studies" / "README.md").read_text(encoding="utf-8")
    assert [name for name in folders if f"`{name}`" not in text] == []


PAGES = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *(ROOT / "docs").rglob("*.md"), *(ROOT / "studies").glob("*.md")]


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.relative_to(ROOT).as_posix())
def test_studies_that_a_page_names_are_there(page):
    named = re.findall(r"python -m studies ([a-z][\w-]*)", page.read_text(encoding="utf-8"))
    assert {*named} <= {command.name for command in COMMANDS}
