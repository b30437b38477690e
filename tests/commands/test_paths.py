"""Paths of options: empty ones are refused, and ~ is the home folder even where no shell has seen it."""

from pathlib import Path

import pytest
from command_line import soft_gripper

FINGER = "package://soft_gripper/grippers/finger.urdf"


@pytest.fixture(autouse=True)
def _work_in(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "home").mkdir()
    monkeypatch.setenv("HOME", str(tmp_path / "home"))
    monkeypatch.chdir(tmp_path)


def test_output_below_home_goes_to_one_place() -> None:
    assert soft_gripper("expand", FINGER, "--out=~/plain.urdf").code == 0
    assert {str(found) for found in Path().rglob("*")} == {"home", "home/plain.urdf"}
