"""A form of model files is one file: that of the how-to page, found by its place among the forms."""

import re
import subprocess
import sys
from pathlib import Path

import pytest
import trimesh

PAGE = (Path(__file__).parents[2] / "docs" / "howto" / "own_model_format.md").read_text(encoding="utf-8")
LOAD = """
import sys
from pathlib import Path
from soft_gripper.model_import import forms
forms.__path__.append(sys.argv[1])
from pydrake.multibody.plant import MultibodyPlant
from soft_gripper.diagrams.loaded_model import load_model
from soft_gripper.diagrams.simulation import content
from soft_gripper.errors import InputError
from soft_gripper.files.notes import collected
from soft_gripper.scenario.schema import ModelConfig
for changes in ({}, {"mass": 0.3}, {"without": ["pear"]}):
    plant = MultibodyPlant(0.01)
    try:
        with collected() as notes:
            load_model(plant, ModelConfig("pear", "pear.toml", free=True, **changes), "models[0]")
        print(round(plant.GetBodyByName("pear").default_mass(), 9), *notes)
    except InputError as error:
        print(error)
print(content(Path("pear.toml")))
"""


@pytest.fixture(scope="module")
def said(tmp_path_factory) -> list[str]:
    """What is loaded: as the file says, with another mass, without a link; and whether a kept station may have it."""
    folder = tmp_path_factory.mktemp("own")
    (name, code), *_ = re.findall(r"^```python\n# \S+/(\w+\.py)\n(.*?)^```$", PAGE, re.MULTILINE | re.DOTALL)
    (text,) = re.findall(r"^```toml\n(.*?)^```$", PAGE, re.MULTILINE | re.DOTALL)
    (folder / "forms").mkdir()
    (folder / "forms" / name).write_text(code, encoding="utf-8")
    (folder / "pear.toml").write_text(text, encoding="utf-8")
    trimesh.creation.icosphere(radius=0.022).export(folder / "pear.obj")
    root = str(Path(__file__).parents[2])
    found = subprocess.run(
        [sys.executable, "-c", f"import sys; sys.path.insert(0, {root!r}){LOAD}", str(folder / "forms")],
        cwd=folder,
        env={"XDG_CACHE_HOME": str(folder / "cache"), "PATH": ""},
        capture_output=True,
        text=True,
        check=False,
    )
    assert found.returncode == 0, found.stderr
    return found.stdout.splitlines()


def test_a_file_of_the_form_is_an_object_as_it_says(said):
    assert said[0] == "0.04"


def test_a_scenario_gives_another_mass_with_a_note(said):
    assert said[1] == "0.3 pear.toml: left out mass = 0.04: the scenario gives another"


def test_only_forms_with_links_have_links_to_leave_out(said):
    expected = "links can be left out of URDF, SDFormat, MJCF only"
    assert said[2] == f"models[0]: without = ['pear']: {expected}"


def test_a_station_that_has_it_is_not_kept(said):
    """The mesh that it names may change."""
    assert said[3] == "None"
