"""The core runs with the declared dependencies alone: what extras of the installation bring is not imported."""

import subprocess
import sys
import tomllib
from pathlib import Path

PROJECT = tomllib.loads((Path(__file__).parents[1] / "pyproject.toml").read_text())["project"]
OPTIONAL = {"c3d": ["ezc3d"], "cluster": ["distributed"], "design": ["optuna"], "learning": ["cma", "gymnasium"]}
OPTIONAL |= {"live": ["serial"], "mujoco": ["mujoco"], "ros": ["mcap", "rosbags"], "video": ["imageio_ffmpeg"]}
CODE = """
import sys
sys.modules.update(dict.fromkeys({blocked!r}))  # to import one of them raises an ImportError
import soft_gripper as sg
from soft_gripper.commands import main
scenario = sg.load_scenario("box_grasp", ["pressure.steps.all=[20e3]", "pressure.settle=0.05"])
print(sg.simulate(scenario).forces())
sys.exit(main(["run", "free_bending", "--set", "pressure.settle=0.05", "--out", {out!r}]))
"""


def test_a_run_needs_no_optional_package(tmp_path):
    assert set(OPTIONAL) <= set(PROJECT["optional-dependencies"])
    blocked = [module for modules in OPTIONAL.values() for module in modules]
    code = CODE.format(blocked=blocked, out=str(tmp_path / "out"))
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False, timeout=300)
    assert done.returncode == 0, done.stderr
    assert "left_finger" in done.stdout
