"""URDF and SDFormat as they are found, for arms, grippers, fixtures and free objects alike."""

import xml.etree.ElementTree as ET
from dataclasses import replace

import numpy as np
import pytest
import trimesh
from pydrake.common.schema import Transform
from pydrake.geometry import Convex, Mesh, Role
from pydrake.math import RigidTransform
from pydrake.multibody.plant import AddMultibodyPlantSceneGraph
from pydrake.systems.framework import DiagramBuilder

from soft_gripper.diagrams.scene import add_model
from soft_gripper.errors import InputError
from soft_gripper.files.notes import collect_notes
from soft_gripper.files.xml_text import DRAKE, parse_xml
from soft_gripper.scenario.schema import ArmConfig, ModelConfig

INERTIAL = "<inertial><mass value='1'/><inertia ixx='.01' iyy='.01' izz='.01' ixy='0' ixz='0' iyz='0'/></inertial>"
LIMIT = "<limit lower='-1' upper='1' velocity='1' effort='9'/>"
IN_SDF = "<inertial><mass>1</mass><inertia><ixx>.01</ixx><iyy>.01</iyy><izz>.01</izz></inertia></inertial>"
SDF_LIMIT = "<limit><lower>-1</lower><upper>1</upper><velocity>1</velocity><effort>9</effort></limit>"


def urdf(*inside):
    return f"<robot name='m'>{''.join(inside)}</robot>"


def sdf(*inside):
    return f"<sdf version='1.7'><model name='m'>{''.join(inside)}</model></sdf>"


def urdf_link(name, inside=""):
    return f"<link name='{name}'>{INERTIAL}{inside}</link>"


def sdf_link(name, inside=""):
    return f"<link name='{name}'>{IN_SDF}{inside}</link>"


def urdf_joint(parent, child, inside=LIMIT, kind="revolute"):
    ends = f"<origin xyz='0 0 0.3'/><parent link='{parent}'/><child link='{child}'/><axis xyz='0 1 0'/>"
    return f"<joint name='to_{child}' type='{kind}'>{ends}{inside}</joint>"


def sdf_joint(parent, child, inside="", kind="revolute"):
    ends = f"<parent>{parent}</parent><child>{child}</child>"
    return f"<joint name='to_{child}' type='{kind}'>{ends}<axis><xyz>0 1 0</xyz>{SDF_LIMIT}{inside}</axis></joint>"


FORMATS = {"urdf": (urdf, urdf_link, urdf_joint), "sdf": (sdf, sdf_link, sdf_joint)}


class Read:
    """A model as a scenario has it, and the notes on it."""

    def __init__(self, folder, text, is_arm=False, time_step=0.01, suffix=None, **config):
        path = folder / f"model.{suffix or ('sdf' if '<sdf' in text else 'urdf')}"
        path.write_text(text)
        self.plant, self.scene_graph = AddMultibodyPlantSceneGraph(DiagramBuilder(), time_step)
        model = replace(ModelConfig("thing", str(path)), **config)
        with collect_notes() as notes:
            loaded = add_model(self.plant, model, "models[0]", ArmConfig() if is_arm else None)
        self.plant.Finalize()
        self.notes, self.context = notes, self.plant.CreateDefaultContext()
        self.model, self.mimics = loaded.model, loaded.mimics

    @property
    def said(self):
        return [f"{note.outcome} {note.element}" for note in self.notes]

    def place(self, body):
        return self.plant.GetBodyByName(body).EvalPoseInWorld(self.context).translation().round(6).tolist()

    def shapes(self, role):
        inspector = self.scene_graph.model_inspector()
        return [type(inspector.GetShape(geometry)) for geometry in inspector.GetAllGeometryIds(role)]


@pytest.mark.parametrize("is_arm", [True, False])
def test_what_is_not_used_is_not_checked(tmp_path, is_arm):
    nonsense = "<gazebo><x:y z='1'/><mass value='much'/></gazebo><!-- a -- b -->"
    fixed = "<axis xyz='0 0 0'/><limit effort='0' velocity='no'/><dynamics damping='none'/><mimic joint='nosuch'/>"
    ends = "<parent link='a'/><child link='c'/>"
    text = urdf(
        *(urdf_link("a"), urdf_link("b"), urdf_link("c"), urdf_joint("a", "b"), nonsense),
        f"<joint name='f' type='fixed'>{ends}{fixed}</joint>",
    )
    read = Read(tmp_path, text, is_arm)
    assert read.plant.num_positions() == 1
    assert read.said == ["left out <gazebo> of 'm'"]
    plugin = "<plugin name='p' filename='x.so'><pose>much</pose></plugin>"
    still = "<joint name='f' type='fixed'><parent>a</parent><child>c</child><axis><xyz>0 0 0</xyz></axis></joint>"
    sensor = "<sensor name='s' type='camera'><update_rate>no</update_rate></sensor>"
    read = Read(tmp_path, sdf(sdf_link("a", sensor), sdf_link("b"), sdf_link("c"), sdf_joint("a", "b"), still, plugin))
    assert read.plant.num_positions() == 1
    assert read.said == ["left out <sensor> of 's'", "left out <plugin> of 'p'"]


@pytest.mark.parametrize("uri", ["http://drake.mit.edu", "drake.mit.edu", "https://drake.mit.edu", None])
def test_elements_of_drake_are_known_by_any_of_their_names(uri):
    declared = "" if uri is None else f" xmlns:drake='{uri}'"
    assert parse_xml("a.urdf", f"<robot{declared}><drake:joint/></robot>")[0].tag == f"{DRAKE}joint"


@pytest.mark.parametrize("form", FORMATS)
@pytest.mark.parametrize("mesh", ["box.dae", "box.ply", "box.obj"])
@pytest.mark.parametrize("is_arm", [True, False])
def test_meshes_of_every_format(tmp_path, form, mesh, is_arm):
    robot, link, _ = FORMATS[form]
    trimesh.creation.box((0.1, 0.2, 0.3)).export(tmp_path / mesh)
    named = f"<mesh filename='{mesh}'/>" if form == "urdf" else f"<mesh><uri>{mesh}</uri></mesh>"
    shapes = "".join(f"<{kind} name='{kind}'><geometry>{named}</geometry></{kind}>" for kind in ("visual", "collision"))
    read = Read(tmp_path, robot(link("a", shapes)), is_arm)
    assert read.shapes(Role.kIllustration) == [Mesh]
    assert read.shapes(Role.kProximity) == [Convex if is_arm else Mesh]


@pytest.mark.parametrize("form", FORMATS)
def test_impossible_inertias_are_mended(tmp_path, form):
    robot, link, _ = FORMATS[form]
    box = "<visual name='v'><geometry><box {}</box></geometry></visual>".format(
        "size='.1 .1 .1'>" if form == "urdf" else "><size>.1 .1 .1</size>"
    )
    flat = (("ixx='.01'", "ixx='9'"), ("<ixx>.01", "<ixx>9"))
    text = robot(link("a", box))
    for right, wrong in flat:
        text = text.replace(right, wrong)
    read = Read(tmp_path, text, free=True)
    assert read.said == ["mended link 'a': inertia ixx, iyy, izz", "read link 'a': inertia"]
    assert np.linalg.eigvalsh(read.plant.CalcMassMatrix(read.context)).min() > 0


@pytest.mark.parametrize("form", FORMATS)
def test_joint_friction_is_left_out_with_a_note(tmp_path, form):
    robot, link, joint = FORMATS[form]
    friction = "<dynamics damping='2' friction='3'/>"
    if form == "sdf":
        friction = "<dynamics><damping>2</damping><friction>3</friction></dynamics>"
    inside = LIMIT + friction if form == "urdf" else friction
    read = Read(tmp_path, robot(link("a"), link("b"), joint("a", "b", inside)))
    assert [(note.element, note.value) for note in read.notes] == [("joint 'to_b': dynamics.friction", "3.0")]
    assert read.plant.GetJointByName("to_b").default_damping() == 2.0


@pytest.mark.parametrize("form", FORMATS)
@pytest.mark.parametrize("is_arm", [True, False])
@pytest.mark.parametrize("time_step", [0.01, 0.0])
def test_joints_that_follow(tmp_path, form, is_arm, time_step):
    robot, link, joint = FORMATS[form]
    mimic = f"{LIMIT}<mimic joint='to_b' multiplier='-2' offset='0.1'/>"
    if form == "sdf":
        mimic = "<mimic joint='to_b'><multiplier>-2</multiplier><offset>0</offset><reference>0.05</reference></mimic>"
    text = robot(link("a"), link("b"), link("c"), joint("a", "b"), joint("b", "c", mimic))
    read = Read(tmp_path, text, is_arm, time_step)
    assert read.plant.num_constraints() == 1
    assert [tuple(mimic) for mimic in read.mimics] == [("to_c", "to_b", -2.0, pytest.approx(0.1))]
    assert read.said == ["read joint 'to_c'", "left out joint 'to_c': limits"]  # its leader takes it beyond
    driven = [read.plant.get_joint_actuator(i).joint().name() for i in read.plant.GetJointActuatorIndices()]
    assert driven == (["to_b"] if is_arm or form == "sdf" else [])


@pytest.mark.parametrize("leader", ["nosuch", "to_c", "to_d", "still"])
def test_what_no_joint_can_follow(tmp_path, leader):
    links = "".join(map(urdf_link, "abcde"))
    mimic = f"{LIMIT}<mimic joint='{leader}'/>"
    back = f"{LIMIT}<mimic joint='to_c'/>"
    still = "<joint name='still' type='fixed'><parent link='a'/><child link='e'/></joint>"
    joints = urdf_joint("a", "b") + urdf_joint("b", "c", mimic) + urdf_joint("c", "d", back) + still
    with pytest.raises(InputError, match=r"joint 'to_[cd]': mimic\.joint = "):
        Read(tmp_path, urdf(links, joints))


POLE = {
    "urdf": (urdf(urdf_link("pole"), urdf_joint("world", "pole")), [0.0, 0.0, 0.3]),
    "urdf with a link": (
        urdf("<link name='world'/>", urdf_link("pole"), urdf_joint("world", "pole")),
        [0.0, 0.0, 0.3],
    ),
    "sdf": (sdf(sdf_link("pole", "<pose>0 0 0.3 0 0 0</pose>"), sdf_joint("world", "pole")), [0.0, 0.0, 0.3]),
}


def fixed(text):
    root = ET.fromstring(text)
    for joint in root.iter("joint"):
        joint.set("type", "fixed")
    return ET.tostring(root, encoding="unicode")


@pytest.mark.parametrize("form", POLE)
@pytest.mark.parametrize("is_arm", [True, False])
def test_what_its_file_joins_to_the_world_stays_there_or_where_the_scenario_puts_it(tmp_path, form, is_arm):
    text, place = POLE[form]
    read = Read(tmp_path, text, is_arm)
    assert read.plant.num_positions() == 1
    assert read.place("pole") == place
    moved = Read(tmp_path, text, is_arm, X_PC=Transform(RigidTransform([1.0, 0.0, 0.0])))
    assert moved.place("pole") == [1.0, 0.0, 0.3]
    assert Read(tmp_path, fixed(text), is_arm).place("pole") == place


@pytest.mark.parametrize("form", POLE)
def test_a_free_model_is_not_joined_to_the_world(tmp_path, form):
    text, _ = POLE[form]
    for field, config in (("free", {"free": True}), ("child", {"child": "pole"})):
        with pytest.raises(InputError, match=f"{field} = .*: leave it out: joint 'to_pole'"):
            Read(tmp_path, text, **config)
    read = Read(tmp_path, fixed(text), free=True)
    assert read.plant.num_positions() == 7
    assert read.plant.CalcTotalMass(read.context) == 1.0
    assert read.said == ["left out joint 'to_pole'"]


def test_a_static_model_stands_where_its_file_puts_it(tmp_path):
    text = sdf("<static>true</static>", sdf_link("a", "<pose>0 0 0.3 0 0 0</pose>"), sdf_link("b"))
    read = Read(tmp_path, text)
    assert (read.place("a"), read.place("b")) == ([0, 0, 0.3], [0, 0, 0])
    assert read.plant.num_positions() == 0


MJCF = """<mujoco model="m"><worldbody><body name="b" pos="0 0 0.3"><joint name="j" type="slide" axis="0 0 1"
range="0 0.4"/><geom type="box" size="0.02 0.02 0.02" mass="2"/></body></worldbody>
<actuator><motor joint="j"/></actuator></mujoco>"""


@pytest.mark.parametrize("is_arm", [True, False])
def test_mjcf_stays_where_its_file_puts_it(tmp_path, is_arm):
    read = Read(tmp_path, MJCF, is_arm, suffix="xml")
    assert read.place("b") == [0, 0, 0.3]
    for field, config in (
        ("X_PC", {"X_PC": Transform(RigidTransform([1.0, 0.0, 0.0]))}),
        ("child", {"child": "b"}),
        ("free", {"free": True}),
    ):
        with pytest.raises(InputError, match=f"{field} = .*MJCF"):
            Read(tmp_path, MJCF, is_arm, suffix="xml", **config)


def test_xml_of_no_known_kind_is_refused_by_its_root(tmp_path):
    with pytest.raises(InputError, match=r"root element = 'svg': a model begins with one of <robot> \(URDF\)"):
        Read(tmp_path, "<svg/>", suffix="xml")
