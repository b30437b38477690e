"""The links, joints and springs of a finger, measured through Drake."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from finger_plants import built_at
from pydrake.geometry import Role
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import AddMultibodyPlantSceneGraph
from pydrake.multibody.tree import MultibodyForces, SpatialInertia
from pydrake.systems.framework import DiagramBuilder

from soft_gripper.fingers.finger_element import FingerElement
from soft_gripper.fingers.finger_links import DRAKE, finger_to_urdf, joint_name, link_name
from soft_gripper.fingers.finger_parts import TipLoad
from soft_gripper.fingers.urdf import expand_urdf
from soft_gripper.models import DIRECTORY


def force_element_torque(plant, q, v=0.0):
    """Generalized force of the springs alone, N m, with all joints at `q` rad and `v` rad/s."""
    context = plant.CreateDefaultContext()
    plant.SetPositions(context, np.full(plant.num_positions(), q))
    plant.SetVelocities(context, np.full(plant.num_velocities(), v))
    forces = MultibodyForces(plant)
    plant.CalcForceElementsContribution(context, forces)
    return plant.CalcGeneralizedForces(context, forces)


@pytest.mark.parametrize(("angle", "tolerance"), [(1e-3, 1e-9), (0.3, 2e-5), (0.8, 1e-3)])
@pytest.mark.parametrize("sign", [1, -1])
@pytest.mark.parametrize("segments", [1, 5])
def test_spring_pair_is_a_linear_torsion_spring(tapered_finger, finger_plant, segments, sign, angle, tolerance):
    finger = replace(tapered_finger, segments=segments, relaxation_time=0.0)
    torque = force_element_torque(finger_plant(finger), sign * angle)
    np.testing.assert_allclose(torque, -sign * angle * finger.stiffness, rtol=tolerance)


def test_damping_is_in_the_joints_and_only_there(tapered_finger, finger_plant):
    plant = finger_plant(tapered_finger)
    damping = [plant.GetJointByName(joint_name("tapered", i)).default_damping() for i in range(5)]
    np.testing.assert_allclose(damping, 0.0065 * tapered_finger.stiffness, rtol=1e-12)
    undamped = finger_plant(replace(tapered_finger, relaxation_time=0.0))
    moving, resting = (force_element_torque(undamped, 0.3, v) for v in (2.0, 0.0))
    np.testing.assert_allclose(moving, resting, rtol=1e-12)


def box(density, x, thickness, width, length):
    """Inertia of a box about a point in its end, x m off the middle of that, (6, 6)."""
    solid = SpatialInertia.SolidBoxWithDensity(density, thickness, width, length)
    return solid.Shift([-x, 0, -length / 2]).CopyToFullMatrix6()


def test_links_are_blocks_less_their_chambers_from_joint_to_joint(tapered_finger, finger_plant):
    """They begin on the neutral axis."""
    finger, plant = tapered_finger, finger_plant(tapered_finger)
    context = plant.CreateDefaultContext()
    ends = np.array([0, 0.5, 1.5, 2.5, 3.5, 4.5, 5]) * finger.length / 5
    for i, (begin, end) in enumerate(pairwise(ends)):
        body = plant.GetBodyByName(link_name("tapered", i))
        section, length = built_at(finger, (begin + end) / 2), end - begin
        block = box(section.density, -section.neutral_axis, section.thickness, section.width, length)
        in_chamber = section.chamber_center - section.neutral_axis
        air = box(section.density, in_chamber, section.chamber_thickness, section.chamber_width, length)
        measured = body.CalcSpatialInertiaInBodyFrame(context)
        np.testing.assert_allclose(measured.CopyToFullMatrix6(), block - air, atol=1e-15)
        place = plant.EvalBodyPoseInWorld(context, body).translation()
        np.testing.assert_allclose(place, [0, 0, begin], atol=1e-15)
    tip = plant.GetFrameByName("tapered_tip").CalcPoseInWorld(context).translation()
    np.testing.assert_allclose(tip, [0, 0, finger.length], atol=1e-15)


@pytest.fixture(scope="module")
def inspector():
    plant, scene_graph = AddMultibodyPlantSceneGraph(DiagramBuilder(), 0.0)
    Parser(plant).AddModelsFromString(expand_urdf(DIRECTORY / "grippers/two_finger.urdf").text, "urdf")
    plant.Finalize()
    return scene_graph.model_inspector()


@pytest.fixture(scope="module")
def skins(inspector):
    """The collision geometries of all links: {id: (finger, index of the link)}."""
    ids = inspector.GetAllGeometryIds(Role.kProximity)
    frames = {id: inspector.GetName(inspector.GetFrameId(id)) for id in ids}
    skins = {id: tuple(frame.split("_link_")) for id, frame in frames.items() if "_link_" in frame}
    assert len(skins) == 26
    return skins


def test_skins_reach_from_face_to_face(inspector, skins, shipped_finger):
    ends = np.concatenate([[0], np.arange(12) + 0.5, [12]]) * 0.01
    for skin, (_, index) in skins.items():
        begin, end = ends[int(index) : int(index) + 2]
        section = built_at(shipped_finger, (begin + end) / 2)
        place, size = inspector.GetPoseInFrame(skin).translation(), inspector.GetShape(skin).size()
        np.testing.assert_allclose(size, [section.thickness, section.width, end - begin], atol=1e-15)
        middle = (section.inner_face + section.outer_face) / 2
        np.testing.assert_allclose(place, [middle, 0, (end - begin) / 2], atol=1e-15)


def test_skin_is_made_of_the_contact_material(inspector, skins, shipped_finger):
    contact = shipped_finger.contact
    for skin in skins:
        properties = inspector.GetProximityProperties(skin)
        friction = properties.GetProperty("material", "coulomb_friction")
        assert friction.static_friction() == friction.dynamic_friction() == contact.friction
        modulus = properties.GetProperty("hydroelastic", "hydroelastic_modulus")
        dissipation = properties.GetProperty("material", "hunt_crossley_dissipation")
        assert (modulus, dissipation) == (contact.hydroelastic_modulus, contact.dissipation)


@pytest.mark.parametrize("segments", [6, 15, 24, 96])
def test_a_skin_is_as_stiff_for_any_number_of_segments(shipped_finger, segments):
    """Its pieces cover the finger without a gap; the modulus over the smallest side is that of 12 segments."""
    finger = replace(shipped_finger, segments=segments)
    elements = finger_to_urdf(FingerElement(finger, "world"))
    found = []
    for i, link in enumerate(each for each in elements if each.tag == "link"):
        for piece in link.findall("collision"):
            size = [float(value) for value in piece.find("geometry/box").get("size").split()]
            middle = float(finger.link_ends[i]) + float(piece.find("origin").get("xyz").split()[2])
            modulus = float(piece.find(f"{DRAKE}proximity_properties/{DRAKE}hydroelastic_modulus").get("value"))
            found.append((middle - size[2] / 2, middle + size[2] / 2, modulus / min(size)))
    begins, ends, stiffnesses = np.array(found).T
    np.testing.assert_allclose(np.append(begins, finger.length), np.append(0.0, ends), atol=1e-12)
    np.testing.assert_allclose(stiffnesses[1:-1], finger.contact.hydroelastic_modulus / 0.01, rtol=1e-9)
    assert len(found) == min(segments, 24) + 1


def test_a_load_on_the_tip_is_drawn_as_a_ball_of_steel_of_its_mass(tapered_finger):
    links = finger_to_urdf(FingerElement(replace(tapered_finger, tip_load=TipLoad(0.05, 0.015, -0.004)), "world"))
    spheres = [sphere for link in links for sphere in link.iterfind("visual/geometry/sphere")]
    radius = float(spheres[0].get("radius"))
    assert len(spheres) == 1
    assert 4 / 3 * np.pi * radius**3 * 7850 == pytest.approx(0.05, rel=1e-6)
