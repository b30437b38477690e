"""What Drake complains of becomes one line that names the file and the field."""

from pathlib import Path

import pytest
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import MultibodyPlant
from refusals import refused

from soft_gripper.errors import InputError
from soft_gripper.model_import.drake_parsing import add_text, drake_reads


@pytest.mark.parametrize("error", [RuntimeError("a\nb"), ValueError("a"), IndexError("a"), SystemExit("a")])
def test_what_drake_raises(error: BaseException) -> None:
    with (
        refused("file", "a.urdf"),
        drake_reads("models[0]", "file", "a.urdf"),
    ):
        raise error


def test_what_is_not_drakes() -> None:
    for error in (SystemExit(3), InputError("a.urdf", "box.size", "0", "give a size"), KeyboardInterrupt()):
        with pytest.raises(type(error)) as caught, drake_reads("models[0]", "file", "a.urdf"):
            raise error
        assert caught.value is error


URDF_JOINT = '<joint name="{0}{1}" type="{2}"><parent link="{0}"/><child link="{1}"/></joint>'
SDF_JOINT = '<joint name="{0}{1}" type="{2}"><parent>{0}</parent><child>{1}</child></joint>'


def model(joints: list[str], kind: str, suffix: str) -> str:
    """Links a, b, c with joints between them, each given by two letters."""
    links = "".join(f'<link name="{name}"/>' for name in "abc")
    joint = URDF_JOINT if suffix == ".urdf" else SDF_JOINT
    inside = links + "".join(joint.format(*ends, kind) for ends in joints)
    if suffix == ".urdf":
        return f'<robot name="r">{inside}</robot>'
    return f'<sdf version="1.7"><model name="r">{inside}</model></sdf>'


@pytest.mark.parametrize("suffix", [".urdf", ".sdf"])
@pytest.mark.parametrize("kind", ["revolute", "fixed"])
@pytest.mark.parametrize("joints", [["ab", "ba"], ["ab", "bc", "ca"], ["ab", "bc", "ac"], ["ab", "cc"]])
def test_a_ring_of_links_is_refused(joints: list[str], kind: str, suffix: str) -> None:
    with pytest.raises(InputError) as error:
        add_text(Parser(MultibodyPlant(0.01)), model(joints, kind, suffix), Path("a" + suffix), suffix)
    assert error.value.field == "parent, child"
    assert error.value.value == ", ".join(joints[-1])
