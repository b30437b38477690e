"""Where the results of a run go: nothing is replaced in silence."""

import subprocess
import sys
from pathlib import Path

import pytest
from refusals import refusal

from soft_gripper.commands.run import run_folder
from soft_gripper.models import DIRECTORY
from soft_gripper.scenario.scenario_file import dump_scenario, load_scenario
from soft_gripper.scenario.schema import Scenario


@pytest.fixture(autouse=True)
def _work_in(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


def settling(seconds: float) -> Scenario:
    return load_scenario("free_bending", [f"pressure.settle={seconds}"])


def keep(folder: str, scenario: Scenario) -> None:
    """What a run leaves in a folder, as far as it counts here."""
    Path(folder).mkdir(parents=True)
    (Path(folder) / "scenario.yaml").write_text(dump_scenario(scenario, Path(folder)))


def test_other_settings_go_to_the_next_folder_with_a_note(capsys: pytest.CaptureFixture[str]) -> None:
    keep("results/free_bending", settling(1))
    assert run_folder(None, "free_bending", settling(2)) == Path("results/free_bending-2")
    note = capsys.readouterr().err
    assert note.count("\n") == 1
    assert "results/free_bending holds a run with other settings" in note
    assert note.strip().endswith("results/free_bending-2")


def test_a_scenario_finds_its_own_folder_among_others() -> None:
    for number, seconds in (("", 1), ("-2", 2), ("-3", 3)):
        keep(f"results/free_bending{number}", settling(seconds))
    assert run_folder(None, "free_bending", settling(2)) == Path("results/free_bending-2")
    assert run_folder(None, "free_bending", settling(4)) == Path("results/free_bending-4")


def test_a_folder_that_is_asked_for_is_taken_with_a_note(capsys: pytest.CaptureFixture[str]) -> None:
    keep("mine", settling(1))
    assert run_folder(Path("mine"), "free_bending", settling(1)) == Path("mine")
    assert capsys.readouterr().err == ""
    assert run_folder(Path("mine"), "free_bending", settling(2)) == Path("mine")
    assert "mine held results of another scenario" in capsys.readouterr().err


def test_a_model_beside_the_scenario_is_the_same_from_every_folder() -> None:
    """Paths in a kept scenario are relative to where it is kept."""
    Path("own.urdf").write_text((DIRECTORY / "grippers" / "finger.urdf").read_text())
    Path("own.yaml").write_text("models: [{name: only, file: own.urdf}]")
    keep("results/own", load_scenario("own.yaml"))
    assert "../../own.urdf" in Path("results/own/scenario.yaml").read_text()
    assert run_folder(None, "own", load_scenario("own.yaml")) == Path("results/own")


@pytest.mark.parametrize("command", [["run", "free_bending"]], ids=" ".join)
def test_a_folder_to_which_another_process_writes(command: list[str]) -> None:
    claim = "from pathlib import Path; from soft_gripper.files.output import lock_folder\n"
    claim += "lock_folder(Path('out')); print('claimed', flush=True); input()"
    Path("out").mkdir()
    with subprocess.Popen([sys.executable, "-c", claim], stdin=subprocess.PIPE, stdout=subprocess.PIPE) as other:
        assert other.stdout is not None
        assert other.stdout.readline() == b"claimed\n"
        assert "output: folder = 'out': another soft-gripper writes there" in refusal(*command, "--out", "out")
        other.communicate(b"\n")
    assert list(Path("out").iterdir()) == []
