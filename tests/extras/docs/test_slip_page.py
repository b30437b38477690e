"""What docs/howto/slip.md shows of a run is what the command prints."""

import re
from pathlib import Path

import pytest
from command_line import soft_gripper

PAGE = (Path(__file__).parents[3] / "docs" / "howto" / "slip.md").read_text(encoding="utf-8")


@pytest.mark.published
def test_the_run_prints_what_the_page_shows(tmp_path):
    command = re.search(r"^    soft-gripper (run .*)$", PAGE, re.MULTILINE)[1].split()
    shown = re.search(r"^```text\n(.*?)^```$", PAGE, re.MULTILINE | re.DOTALL)[1].splitlines()
    found = soft_gripper(*command, "--out", tmp_path).out.splitlines()
    assert [line for line in shown if line != "..." and line not in found] == []
