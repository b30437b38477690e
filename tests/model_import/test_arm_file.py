"""URDF files of arms as they are found: Drake alone loads what becomes of them, in silence, and simulates it."""

import numpy as np
import pytest
from arm_urdfs import (
    ARM,
    GREEN,
    INERTIAL,
    LIMIT,
    RED,
    ZERO_INERTIAL,
    arm_urdf,
    box,
    joint,
    link,
    load,
    shape,
    write_urdf,
)
from pydrake.multibody.plant import AddMultibodyPlantSceneGraph
from pydrake.systems.framework import DiagramBuilder

from soft_gripper.diagrams.loaded_model import load_model
from soft_gripper.errors import InputError
from soft_gripper.files.notes import collect_notes
from soft_gripper.scenario.schema import ArmConfig, ModelConfig


def test_links_without_inertia_are_moved(tmp_path):
    """A gripper's pads are often so; the mass matrix must not be singular."""
    pads = (
        joint("pad", "fore", "pad", kind="prismatic")
        + link("pad", ZERO_INERTIAL)
        + joint("tip", "pad", "tip")
        + link("tip", "")
    )
    loaded = load(write_urdf(tmp_path, ARM + pads))
    assert np.linalg.eigvalsh(loaded.mass_matrix())[0] > 1e-9
    assert np.isfinite(loaded.end_after(0.1)).all()
    assert loaded.plant.CalcTotalMass(loaded.context) == pytest.approx(6.0, abs=0.01)


def test_a_continuous_joint_has_no_end(tmp_path):
    """Files give it -2 pi and 2 pi, or 0 and 0."""
    limit = "<limit lower='0' upper='0' velocity='3' effort='40'/>"
    loaded = load(write_urdf(tmp_path, link("base") + joint("j", "base", "l", limit, "continuous") + link("l")))
    assert np.isinf(loaded.plant.GetPositionUpperLimits()).all()
    assert loaded.plant.GetVelocityUpperLimits() == [3.0]


def test_the_root_is_the_first_link_and_not_the_world(tmp_path):
    """A scenario places the arm by its first link, which Drake's own world cannot be."""
    loaded = load(
        write_urdf(tmp_path, ARM + joint("weld", "world", "base", kind="fixed", inside="") + link("world", ""))
    )
    assert loaded.base.name() == "acme_world"
    X_WB = loaded.plant.GetBodyByName("base").EvalPoseInWorld(loaded.context)
    np.testing.assert_allclose(X_WB.translation(), [0, 0, 0.4])
    assert loaded.plant.num_positions() == 2


def test_links_of_an_arm_do_not_touch_each_other(tmp_path):
    ball = INERTIAL + "<collision><geometry><sphere radius='0.5'/></geometry></collision>"
    group = "<drake:collision_filter_group xmlns:drake='http://drake.mit.edu' name='own'><drake:member link='base'/>"
    own, overlapping = f"{group}</drake:collision_filter_group>", ARM.replace(INERTIAL, ball)
    for inside, pairs in ((overlapping, 0), (overlapping + own, 1)):  # base and fore; Drake leaves out neighbours
        plant, scene_graph = AddMultibodyPlantSceneGraph(DiagramBuilder(), 0.01)
        load_model(plant, ModelConfig("arm", str(write_urdf(tmp_path, inside))), "models[0]", ArmConfig())
        plant.Finalize()
        assert len(scene_graph.model_inspector().GetCollisionCandidates()) == pairs


LEFTOVERS = """
  <gazebo><plugin filename='x.so' name='p'><robotNamespace>$(arg ns)</robotNamespace></plugin></gazebo>
  <gazebo reference='base'><mu1>0.2</mu1><material>$(find acme)/grey</material></gazebo>
  <ros2_control name='c' type='system'><param name='file'>$(find acme)/c.yaml</param></ros2_control>
  <xacro:property name='pi' value='3.14'/><xacro:arg name='ns' default=''/>
  <transmission name='t'><type>transmission_interface/SimpleTransmission</type>
    <joint name='elbow'><hardwareInterface>hardware_interface/PositionJointInterface</hardwareInterface></joint>
    <actuator name='m'><mechanicalReduction>160</mechanicalReduction></actuator></transmission>
  <transmission name='t2'><type>transmission_interface/DifferentialTransmission</type>
    <joint name='elbow'/><actuator name='m2'/></transmission>
"""


def test_what_is_meant_for_other_programs_is_left_out_with_a_note(tmp_path, capfd):
    box(tmp_path / "box.dae", RED)
    heavy = INERTIAL.replace("izz='0.1'", "izz='0.3'")  # no body has it
    shapes = shape("visual", "filename='box.dae'", GREEN) + shape("collision", "filename='box.dae'")
    safety = "<safety_controller k_velocity='1'/><calibration rising='0'/><dynamics damping='1' friction='5'/>"
    last = joint("wrist", "fore", "hand", LIMIT + safety) + f"<link name='hand' type='x'>{heavy}{shapes}</link>"
    with collect_notes() as notes:
        loaded = load(write_urdf(tmp_path, ARM + last + LEFTOVERS), render=True)
    assert [(note.outcome, note.element, note.value) for note in notes] == [
        ("left out", "<gazebo> of 'acme'", ""),
        ("left out", "<gazebo> of 'base'", ""),
        ("left out", "<ros2_control> of 'c'", ""),
        ("left out", "<safety_controller> of 'wrist'", ""),
        ("left out", "joint 'wrist': dynamics.friction", "5.0"),
        ("left out", "<transmission> 't': mechanicalReduction", "160"),
        ("left out", "<transmission> 't2'", "elbow"),
        ("mended", "link 'hand': inertia ixx, iyy, izz", "0.1, 0.1, 0.3"),
    ]
    assert capfd.readouterr() == ("", "")
    assert len(loaded.actuators) == 3
    assert loaded.plant.GetJointByName("wrist").default_damping() == 1.0


@pytest.mark.parametrize(
    ("inside", "complaint"),
    [
        ("<xacro:macro name='m'/>", "xacro = 'macro': is not expanded; run: xacro arm.urdf -o arm.urdf"),
        (
            link("l", shape("visual", "filename='file://$(find a)/b.stl'")),
            "xacro = 'file://$(find a)/b.stl': is not expanded",
        ),
        (
            link("l", shape("visual", "filename='no.stl'")),
            "mesh = 'file://{folder}/no.stl': there is no file {folder}/no.stl",
        ),
        (link("l", shape("visual", "filename='junk.dae'")), "{folder}/junk.dae: mesh = 'junk.dae': cannot be read"),
    ],
)
def test_what_cannot_be_an_arm(tmp_path, inside, complaint):
    (tmp_path / "junk.dae").write_text("junk")
    path = write_urdf(tmp_path, inside)
    with pytest.raises(InputError) as caught:
        arm_urdf(path)
    expected = complaint.replace("{folder}", str(tmp_path))
    assert str(caught.value).startswith(f"{path}: {expected}")
    assert "\n" not in str(caught.value)
