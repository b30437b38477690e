"""Commands write over no file that they read, and run no module of the folder in which they are called."""

import os
from importlib.util import find_spec

import pytest
from command_line import short
from identified import BEAM, RELEASED, finger_of, recorded, release, write_motion
from live_process import LIVE, bench
from poisoned_folder import poison, run_in
from refusals import refusal

from soft_gripper.commands.parser import CORE, commands
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


DESIGN = """
scenario: box_grasp
vary: { pressure.steps.all.0: 60.0e3..120.0e3 }
ends: [{ measure: normal_force_n }, { measure: slip_ratio }]
designs: 3
"""
RUN = ["mine.yaml", *short(), "--out", "out/run"]
JOBS = ["--jobs", "2"]
SWEEP = ["mine.yaml", *short(), "--vary", "sensor.seed=1,2", *JOBS, "--out", "out/swept"]
IDENTIFY_MOTION = ["swing.csv", "--as", "swing.yaml", "--finger", "beam.urdf"]
LONG = {
    "run": RUN,
    "calibrate": ["out/run/recording.nc", "--out", "calibration.yaml"],
    "evaluate": [*JOBS, "--out", "out/evaluation"],
    "design": ["design.yaml", *JOBS, "--out", "out/design"],
    "export": ["mine.yaml", "--out", "out/export"],
    "grasp-strength": ["box_grasp", *JOBS, "--out", "out/strength"],
    "identify": [*IDENTIFY_MOTION, "--free", "youngs_modulus", *JOBS, "--out", "out/fitted.urdf"],
    "live": [*LIVE[1:], "--bench", "bench.yaml", "--fast"],
    "play": ["mine.yaml", "--out", "out/played"],
    "replay": ["swing.csv", "--as", "swing.yaml", "--out", "out/replayed"],
    "study grasp-trials": ["--trials", "1", *JOBS, "--out", "out/trials"],
    "sweep": SWEEP,
    "tune": ["--evaluations", "5"],
    "weigh": IDENTIFY_MOTION,
}


@pytest.fixture
def folder(tmp_path):
    poison(tmp_path)
    (tmp_path / "mine.yaml").write_text(dump_scenario(load_scenario("free_bending")))
    return tmp_path


@pytest.mark.skipif(find_spec("mujoco") is None, reason="the extra `mujoco` is not installed")
def test_the_engine_mujoco_runs_no_module_of_the_current_folder(folder):
    assert run_in(folder, {"run": ["run", *RUN, "--engine", "mujoco"]}) == {"run": [0, []]}


def test_workers_of_a_sweep_run_no_module_of_the_current_folder(folder):
    assert run_in(folder, {"sweep": ["sweep", *SWEEP]}) == {"sweep": [0, []]}
    assert (folder / "out/swept/sweep.png").exists()


@pytest.mark.slow
def test_commands_of_extras_run_none_either(folder):
    """Those that take long are ended when they work."""
    assert LONG.keys() >= {command.name for command in commands()} - {command.name for command in CORE}
    motion = recorded(finger_of(BEAM, folder), release(0.8))
    write_motion(folder / "swing.csv", motion.time, motion.markers)
    bench(folder)
    for name, text in {"swing.yaml": RELEASED, "beam.urdf": BEAM, "design.yaml": DESIGN}.items():
        (folder / name).write_text(text)
    ended = run_in(folder, {name: [*name.split(), *words] for name, words in LONG.items()}, seconds=8)
    assert [name for name, (_, ran) in ended.items() if ran] == []
    refused = {name for name, (code, _) in ended.items() if code == 2}
    assert refused <= {"calibrate", "replay", "weigh"}
