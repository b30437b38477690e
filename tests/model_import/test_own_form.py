"""A form of model files is one file: that of the how-to page, found by its place among the forms."""

import re
import subprocess
import sys
from pathlib import Path

import trimesh

PAGE = (Path(__file__).parents[2] / "docs" / "howto" / "own_model_format.md").read_text(encoding="utf-8")
LOAD = """
import sys
from pathlib import Path
from soft_gripper.model_import import forms
forms.__path__.append(sys.argv[1])
from pydrake.multibody.plant import MultibodyPlant
from soft_gripper.diagrams.loaded_model import load_model
from soft_gripper.diagrams.simulation import fingerprint
from soft_gripper.errors import InputError
from soft_gripper.files.notes import collect_notes
from soft_gripper.scenario.schema import ModelConfig
for changes in ({}, {"mass": 0.3}, {"without": ["pear"]}):
    plant = MultibodyPlant(0.01)
    try:
        with collect_notes() as notes:
            load_model(plant, ModelConfig("pear", "pear.toml", free=True, **changes), "models[0]")
        print(round(plant.GetBodyByName("pear").default_mass(), 9), *notes)
    except InputError as error:
        print(error)
print(fingerprint(Path("pear.toml")))
"""


def test_a_file_of_the_form(tmp_path):
    """Is an object as it says, of another mass, with all its links, and in no kept station: its mesh may change."""
    (name, code), *_ = re.findall(r"^```python\n# \S+/(\w+\.py)\n(.*?)^```$", PAGE, re.MULTILINE | re.DOTALL)
    (text,) = re.findall(r"^```toml\n(.*?)^```$", PAGE, re.MULTILINE | re.DOTALL)
    (tmp_path / "forms").mkdir()
    (tmp_path / "forms" / name).write_text(code, encoding="utf-8")
    (tmp_path / "pear.toml").write_text(text, encoding="utf-8")
    trimesh.creation.icosphere(radius=0.022).export(tmp_path / "pear.obj")
    root = str(Path(__file__).parents[2])
    found = subprocess.run(
        [sys.executable, "-c", f"import sys; sys.path.insert(0, {root!r}){LOAD}", str(tmp_path / "forms")],
        cwd=tmp_path,
        env={"XDG_CACHE_HOME": str(tmp_path / "cache"), "PATH": ""},
        capture_output=True,
        text=True,
        check=False,
    )
    assert found.returncode == 0, found.stderr
    assert found.stdout.splitlines() == [
        "0.04",
        "0.3 pear.toml: left out mass = 0.04: the scenario gives another",
        "models[0]: without = ['pear']: links can be left out of URDF, SDFormat, MJCF only",
        "None",
    ]
