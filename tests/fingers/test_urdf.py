"""expand_urdf: a gripper file with fingers -> plain URDF that pydrake loads with nothing of ours."""

from pathlib import Path

import numpy as np
import pytest
from pydrake.math import RigidTransform, RollPitchYaw
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import MultibodyPlant
from refusals import refused

from soft_gripper.errors import InputError
from soft_gripper.fingers.urdf import GUARD, expand_urdf
from soft_gripper.models import DIRECTORY

FINGER, TWO_FINGER = DIRECTORY / "grippers/finger.urdf", DIRECTORY / "grippers/two_finger.urdf"


@pytest.fixture
def edited(tmp_path):
    """A copy of the file of one finger, elsewhere, in which `old` became `new`."""

    def edit(old: str = "", new: str = "", source: Path = FINGER) -> Path:
        text = source.read_text()
        assert old in text
        path = tmp_path / "edited.urdf"
        path.write_text(text.replace(old, new, 1))
        return path

    return edit


@pytest.mark.parametrize(
    ("file", "base", "names"),
    [(FINGER, "mount", ["finger"]), (TWO_FINGER, "palm", ["left_finger", "right_finger"])],
    ids=["finger", "two_finger"],
)
def test_shipped_file_loads_in_bare_drake(load_plant, file, base, names):
    expanded = expand_urdf(file)
    plant = load_plant(expanded.text, base)
    assert [finger.name for finger in expanded.fingers] == names
    assert "<finger" not in expanded.text
    assert plant.num_velocities() == plant.num_actuators() == 12 * len(names)
    assert plant.num_bodies() == 2 + 13 * len(names)  # world, base, links
    assert plant.num_force_elements() == 1 + 24 * len(names)  # gravity, springs
    finger_mass = 1070 * 0.12 * (0.02 * 0.0195 - 9e-3 * 9.75e-3)  # linear taper
    base_mass = {"mount": 0.1, "palm": 0.3}[base]
    total = plant.CalcTotalMass(plant.CreateDefaultContext())
    assert total == pytest.approx(base_mass + finger_mass * len(names), rel=1e-12)


def test_fingers_stand_where_their_origins_say(load_plant):
    plant = load_plant(expand_urdf(TWO_FINGER).text, "palm")
    context = plant.CreateDefaultContext()
    for name, x, yaw in (("left_finger", -0.0353, 0.0), ("right_finger", 0.0353, np.pi)):
        assert plant.GetJointByName(f"{name}_mount").type_name() == "weld"
        expected = RigidTransform(RollPitchYaw(0, 0, yaw), [x, 0, 0.03])
        base = plant.GetBodyByName(f"{name}_link_0")
        assert plant.EvalBodyPoseInWorld(context, base).IsNearlyEqualTo(expected, 1e-12)


def test_mesh_names_lead_to_the_same_file_from_everywhere(edited):
    meshes = "".join(
        f'<visual><geometry><mesh filename="{name}"/></geometry></visual>'
        for name in ("../mesh.obj", "package://drake/a.obj", "file:///a.obj", "/a.obj")
    )
    path = edited('<link name="mount">', f'<link name="mount">{meshes}')
    text = expand_urdf(path).text
    for expected in (f"file://{path.parent.parent}/mesh.obj", "package://drake/a.obj", "file:///a.obj"):
        assert f'filename="{expected}"' in text


def test_a_single_finger_takes_another_name(load_plant):
    expanded = expand_urdf(FINGER, only_name="thumb")
    assert expanded.fingers[0].name == "thumb"
    assert load_plant(expanded.text).HasJointNamed("thumb_joint_11")
    assert expand_urdf(TWO_FINGER, only_name="thumb").fingers[0].name == "left_finger"


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('link="mount"', 'link="hand"', "finger 'finger': parent.link = 'hand': no such link; known: mount"),
        ("</robot>", "", "file = 'edited.urdf': is not well-formed XML: no element found: line"),
        ('<robot name="finger">', "<robot>", "root element = 'robot': a URDF begins with <robot name="),
    ],
)
def test_mistakes_are_named(edited, old, new, message):
    path = edited(old, new)
    with pytest.raises(InputError) as caught:
        expand_urdf(path)
    assert str(caught.value).startswith(f"{path}: {message}")


def test_two_fingers_of_one_name(edited):
    path = edited('name="right_finger"', 'name="left_finger"', TWO_FINGER)
    with refused("finger.name", "left_finger"):
        expand_urdf(path)


@pytest.mark.parametrize("file", sorted((DIRECTORY / "grippers").glob("*.urdf")), ids=lambda file: file.stem)
def test_drake_alone_refuses_a_file_with_fingers_and_says_what_to_do(file):
    plant = MultibodyPlant(0.0)
    with pytest.raises(RuntimeError, match=r"load with soft_gripper\.add_fingers, or soft-gripper expand"):
        Parser(plant).AddModels(str(file))


@pytest.mark.parametrize("frame", ["", '<frame name="tool" link="mount" xyz="0 0 0" rpy="0 0 0"/>'])
def test_fingers_that_drake_alone_would_skip_are_refused(edited, frame):
    path = edited(f'<frame name="{GUARD}"/>', frame)
    with pytest.raises(InputError) as caught:
        expand_urdf(path)
    assert str(caught.value).startswith(f'{path}: frame = None: add <frame name="{GUARD}"/> beside the <finger>s')


def test_expanding_takes_the_guard_alone(edited, load_plant):
    frame = '<frame name="tool" link="mount" xyz="0 0 0.1" rpy="0 0 0"/>'
    text = expand_urdf(edited("</robot>", f'{frame}<frame name="{GUARD}"/></robot>')).text
    assert GUARD not in text
    assert load_plant(text).HasFrameNamed("tool")


@pytest.mark.parametrize("content", [None, b"\xff\xfe\xfa", b"", b"<sdf/>"])
def test_no_urdf(tmp_path, content):
    path = tmp_path / "no.urdf"
    if content is not None:
        path.write_bytes(content)
    with pytest.raises(InputError) as caught:
        expand_urdf(path)
    assert str(caught.value).startswith(f"{path}: ")


def test_a_changed_file_is_seen(edited):
    before = expand_urdf(edited())
    assert expand_urdf(edited()).robot is before.robot
    after = expand_urdf(edited('length="0.12"', 'length="0.13"'))
    assert after.text != before.text
    assert after.fingers[0].length == 0.13


def test_a_mesh_that_a_link_names_anew_is_seen(edited, tmp_path):
    path = edited(
        "</robot>", '<link name="a"><visual><geometry><mesh filename="a.obj"/></geometry></visual></link></robot>'
    )
    for name in ("b.obj", "c.obj"):
        (tmp_path / "a.obj").unlink(missing_ok=True)
        (tmp_path / "a.obj").symlink_to(tmp_path / name)
        assert f'filename="file://{tmp_path / name}"' in expand_urdf(path).text
