"""Paths of options: empty ones are refused, and ~ is the home folder even where no shell has seen it."""

from pathlib import Path

import pytest
from command_line import soft_gripper

from soft_gripper.commands.parser import path

FINGER = "package://soft_gripper/grippers/finger.urdf"


@pytest.fixture(autouse=True)
def _work_in(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "home").mkdir()
    monkeypatch.setenv("HOME", str(tmp_path / "home"))
    monkeypatch.chdir(tmp_path)


def test_home() -> None:
    assert path("~/results") == Path("home/results").resolve()
    assert path("a/~b") == Path("a/~b")


def test_output_below_home_goes_to_one_place() -> None:
    assert soft_gripper("expand", FINGER, "--out=~/plain.urdf").code == 0
    assert {str(found) for found in Path().rglob("*")} == {"home", "home/plain.urdf"}


@pytest.mark.parametrize("wrong", ["", "~no_such_user/x"])
@pytest.mark.parametrize("option", ["--out", "--html", "--video"])
def test_no_path(option: str, wrong: str) -> None:
    outcome = soft_gripper("run", "free_bending", f"{option}={wrong}")
    assert outcome.code == 2
    assert f"run: {option} = {wrong!r}" in outcome.err
    assert list(Path("home").iterdir()) == []


@pytest.mark.parametrize("file", [".", "folder", "folder/", "/"])
@pytest.mark.parametrize("option", ["--html", "--video"])
def test_a_folder_for_a_file_is_refused_before_the_run(option: str, file: str) -> None:
    Path("folder").mkdir()
    outcome = soft_gripper("run", "free_bending", option, file)
    assert outcome.code == 2
    assert outcome.err.count("\n") == 1
    assert not Path("results").exists()


def test_calibration_that_cannot_be_written_is_refused_before_it_is_made() -> None:
    outcome = soft_gripper("calibrate", "none.nc", "--out", ".")
    assert "output: file = '.'" in outcome.err
