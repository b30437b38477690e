"""Files that include each other end: those that include themselves are refused by name, and trees have a size."""

from pathlib import Path

import pytest
from pydrake.multibody.parsing import AddModel, ModelDirective
from pydrake.multibody.plant import AddMultibodyPlantSceneGraph, MultibodyPlant
from pydrake.systems.framework import DiagramBuilder
from refusals import refused

from soft_gripper.diagrams.scene import add_model
from soft_gripper.errors import InputError
from soft_gripper.scenario.directives import add_directives
from soft_gripper.scenario.schema import ModelConfig


def read(path: Path, directly: bool = False) -> MultibodyPlant:
    """A plant with the model of a file; `directly`: Drake reads it unchanged."""
    plant, _ = AddMultibodyPlantSceneGraph(DiagramBuilder(), 0.01)
    if directly:
        add_directives(plant, [ModelDirective(add_model=AddModel(name="m", file=f"file://{path}"))])
    else:
        add_model(plant, ModelConfig("m", str(path)), "models[0]", None)
    return plant


def sdf(inside: str = "", name: str = "m") -> str:
    return f"<sdf version='1.9'><model name='{name}'><link name='{name}'/>{inside}</model></sdf>"


def mjcf(inside: str = "") -> str:
    return f"<mujoco>{inside}<worldbody><body name='b'><geom size='0.1'/></body></worldbody></mujoco>"


INCLUDE = {"sdf": "<include><uri>{}</uri></include>", "xml": "<include file='{}'/>"}
TEXT = {"sdf": sdf, "xml": mjcf}


def write(folder: Path, suffix: str, *names: str) -> Path:
    """Files of which each includes the next; returns the first."""
    for name, following in zip(names, (*names[1:], None), strict=True):
        inside = INCLUDE[suffix].format(f"{following}.{suffix}") if following else ""
        (folder / f"{name}.{suffix}").write_text(TEXT[suffix](inside))
    return folder / f"{names[0]}.{suffix}"


@pytest.mark.parametrize("directly", [False, True])
@pytest.mark.parametrize("suffix", ["sdf", "xml"])
@pytest.mark.parametrize("length", [1, 2, 3])
def test_a_file_that_includes_itself(tmp_path: Path, suffix: str, length: int, directly: bool) -> None:
    first = write(tmp_path, suffix, *"abc"[:length])
    last = tmp_path / f"{'abc'[length - 1]}.{suffix}"
    last.write_text(TEXT[suffix](INCLUDE[suffix].format(first.name)))
    with pytest.raises(InputError, match=f"{last.name} > {first.name}"):
        read(first, directly)


@pytest.mark.parametrize("suffix", ["sdf", "xml"])
def test_files_in_a_row_have_an_end(tmp_path: Path, suffix: str) -> None:
    with pytest.raises(InputError, match="more than 10 files"):
        read(write(tmp_path, suffix, *"abcdefghijklm"))


@pytest.mark.parametrize("directly", [False, True])
@pytest.mark.parametrize("suffix", ["sdf", "xml"])
def test_trees_of_files_have_a_size(tmp_path: Path, suffix: str, directly: bool) -> None:
    path = write(tmp_path, suffix, *"abcdefgh")
    for file in tmp_path.iterdir():
        for i, following in enumerate("bcdefgh"):
            many = "".join(
                f"<include><name>n{k}</name><uri>{following}.sdf</uri></include>"
                if suffix == "sdf"
                else INCLUDE["xml"].format(f"{following}.xml")
                for k in range(20)
            )
            if file.stem == "abcdefg"[i]:
                file.write_text(TEXT[suffix](many))
    with pytest.raises(InputError, match="one of more than 500 included files"):
        read(path, directly)


def test_included_files_have_a_size(tmp_path: Path) -> None:
    (tmp_path / "b.xml").write_text(f"<mujoco>{20_000 * '<a/>'}</mujoco>")
    (tmp_path / "a.xml").write_text(mjcf(3 * INCLUDE["xml"].format("b.xml")))
    with pytest.raises(InputError, match="more than 50000 elements"):
        read(tmp_path / "a.xml")


@pytest.mark.parametrize(
    "around", ["{}", "<link name='l'>{}</link>", "<model name='n'><link name='l'>{}</link></model>"]
)
@pytest.mark.parametrize("tag", ["inertial", "pose"])
def test_models_are_included_where_models_can_be(tmp_path: Path, tag: str, around: str) -> None:
    (tmp_path / "a.sdf").write_text(sdf(around.format(f"<{tag}>{INCLUDE['sdf'].format('a.sdf')}</{tag}>")))
    with refused(f"{tag}.include", "a.sdf"):
        read(tmp_path / "a.sdf")


@pytest.mark.parametrize(
    ("attribute", "inside", "field", "value"),
    [
        (" merge='true'", "", "include.merge", "true"),
        ("", "<experimental:params/>", "include.experimental:params", "b.sdf"),
    ],
)
def test_models_are_included_as_they_are(tmp_path: Path, attribute: str, inside: str, field: str, value: str) -> None:
    write(tmp_path, "sdf", "b")
    (tmp_path / "a.sdf").write_text(sdf(f"<include{attribute}><uri>b.sdf</uri>{inside}</include>"))
    with refused(field, value):
        read(tmp_path / "a.sdf")
