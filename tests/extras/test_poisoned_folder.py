"""No command of an extra runs a module of the folder in which it is started, or obeys settings there."""

from importlib.util import find_spec

import pytest
from command_line import short
from identified import BEAM, RELEASED, finger_of, recorded, release, write_motion
from live_process import LIVE, bench
from poisoned_folder import poison, run_in

from soft_gripper.commands.parser import CORE, commands
from soft_gripper.scenario.scenario_file import dump_scenario, load_scenario

DESIGN = """
scenario: box_grasp
vary: { pressure.steps.all.0: 60.0e3..120.0e3 }
ends: [{ measure: normal_force_n }, { measure: slip_ratio }]
designs: 3
"""
RUN = ["mine.yaml", *short(), "--out", "out/run"]
JOBS = ["--jobs", "2"]
IDENTIFY = ["swing.csv", "--as", "swing.yaml", "--finger", "beam.urdf"]
LONG = {
    "run": RUN,
    "calibrate": ["out/run/recording.nc", "--out", "calibration.yaml"],
    "evaluate": [*JOBS, "--out", "out/evaluation"],
    "design": ["design.yaml", *JOBS, "--out", "out/design"],
    "export": ["mine.yaml", "--out", "out/export"],
    "grasp-strength": ["box_grasp", *JOBS, "--out", "out/strength"],
    "identify": [*IDENTIFY, "--free", "youngs_modulus", *JOBS, "--out", "out/fitted.urdf"],
    "live": [*LIVE[1:], "--bench", "bench.yaml", "--fast"],
    "play": ["mine.yaml", "--out", "out/played"],
    "replay": ["swing.csv", "--as", "swing.yaml", "--out", "out/replayed"],
    "study grasp-trials": ["--trials", "1", *JOBS, "--out", "out/trials"],
    "study health": ["--runs", "1", *JOBS, "--out", "out/health"],
    "weigh": IDENTIFY,
}


@pytest.fixture
def folder(tmp_path):
    poison(tmp_path)
    (tmp_path / "mine.yaml").write_text(dump_scenario(load_scenario("free_bending")))
    return tmp_path


@pytest.mark.skipif(find_spec("mujoco") is None, reason="the extra `mujoco` is not installed")
def test_the_engine_mujoco_runs_no_module_of_the_current_folder(folder):
    assert run_in(folder, {"run": ["run", *RUN, "--engine", "mujoco"]}) == {"run": [0, []]}


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
