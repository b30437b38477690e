"""No command writes over a file that it reads."""

import os

import pytest
from identified import BEAM, RELEASED, finger_of, recorded, release, write_motion
from refusals import refusal

from soft_gripper.errors import InputError
from soft_gripper.files.output import check_file
from soft_gripper.scenario.scenario_file import dump_scenario, load_scenario

IDENTIFY = ("identify", "run.csv", "--finger", "guess.urdf", "--free", "youngs_modulus", "--out")

STUDY = """
scenario: best/scenario.yaml
vary: { pressure.steps.all.0: 60.0e3..120.0e3 }
ends: [{ measure: normal_force_n }]
"""


@pytest.fixture
def place(tmp_path, monkeypatch):
    """A folder with inputs of all kinds."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.delenv("SOFT_GRIPPER_DATA", raising=False)
    motion = recorded(finger_of(BEAM, tmp_path), release(0.8))
    write_motion(tmp_path / "run.csv", motion.time, motion.markers)
    (tmp_path / "recording.yaml").write_text(RELEASED)
    (tmp_path / "guess.urdf").write_text(BEAM)
    (tmp_path / "recording.nc").touch()
    (tmp_path / "scenario.yaml").write_text("# mine\n" + dump_scenario(load_scenario("free_bending")))
    (tmp_path / "trials.yaml").write_text("# mine\n" + dump_scenario(load_scenario("pick_and_place_box")))
    (tmp_path / "best").mkdir()
    (tmp_path / "best/scenario.yaml").write_text("# mine\n" + dump_scenario(load_scenario("bottle_grasp")))
    (tmp_path / "study.yaml").write_text(STUDY)
    return tmp_path


@pytest.mark.slow
@pytest.mark.parametrize(
    ("lost", "arguments"),
    [
        ("guess.urdf", ("expand", "guess.urdf", "-o", "./guess.urdf")),
        ("recording.nc", ("calibrate", "recording.nc", "--out", "recording.nc")),
        ("scenario.yaml", ("calibrate", "run.csv", "--scenario", "scenario.yaml", "--out", "scenario.yaml")),
        ("guess.urdf", (*IDENTIFY, "guess.urdf")),
        ("run.csv", (*IDENTIFY, "run.urdf")),
        ("scenario.yaml", ("run", "scenario.yaml", "--out", ".")),
        ("scenario.yaml", ("run", "scenario.yaml", "--html", "scenario.yaml")),
        ("trials.yaml", ("study", "grasp-trials", "--scenario", "trials.yaml", "--out", ".")),
        ("best/scenario.yaml", ("design", "study.yaml", "--out", ".")),
    ],
)
@pytest.mark.usefixtures("place")
def test_an_output_that_is_an_input_is_refused(lost, arguments):
    assert f"{lost}': is an input of this command" in refusal(*arguments)


def test_inputs_by_other_names(tmp_path):
    (tmp_path / "in").touch()
    os.link(tmp_path / "in", tmp_path / "hard")
    (tmp_path / "soft").symlink_to("in")
    for name in ("in", "hard", "soft"):
        with pytest.raises(InputError) as error:
            check_file(tmp_path / name, [tmp_path / "other", tmp_path / "in"])
        assert error.value.value == str(tmp_path / name)
