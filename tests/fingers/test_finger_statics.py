"""Kinematics and statics of fingers against Drake and textbooks."""

from dataclasses import replace

import numpy as np
import pytest
from finger_plants import uniform_finger
from loaded_fingers import Push, in_balance
from pydrake.multibody.tree import JacobianWrtVariable

from soft_gripper.fingers.creep import memory_torque
from soft_gripper.fingers.finger_links import link_name
from soft_gripper.fingers.finger_parts import CreepBranch, ElasticLaw, PressureLaw, TipLoad
from soft_gripper.fingers.kinematics import (
    as_planar,
    as_points,
    forward_kinematics,
    gravity_torque,
    link_directions,
    segment_path_lengths,
    sensor_path,
)
from soft_gripper.fingers.paths import Chamber
from soft_gripper.fingers.plant_finger import PlantFinger
from soft_gripper.fingers.statics import (
    FacePress,
    free_bending_angles,
    resting_angles,
    softened,
    strengthened,
)

LAW = ElasticLaw(curvature=(-30.0, 0.0, 30.0), base_moment=(-0.5, 0.0, 0.2), tip_moment=(-0.2, 0.0, 0.3))
PRESSURES = np.array([[-50e3, 0.0], [100e3, 200e3]])


@pytest.mark.parametrize("gravity", [[0, 0, -9.81], [0, 0, 9.81], [9.81, 0, 0], [3.0, -5.0, 7.0]], ids=str)
def test_weight_is_that_of_drake(tapered_finger, bent, drake_weight, gravity):
    shapes = 2 * bent(20, 5)
    torques = gravity_torque(tapered_finger, shapes, complex(gravity[2], gravity[0]))
    for q, torque in zip(shapes, torques, strict=True):
        np.testing.assert_allclose(torque, drake_weight(tapered_finger, q, gravity), atol=1e-15)


def test_free_bending_is_pressure_torque_over_stiffness(tapered_finger):
    expected = PRESSURES[..., None] * tapered_finger.pressure_gain / tapered_finger.stiffness
    np.testing.assert_allclose(free_bending_angles(tapered_finger, PRESSURES), expected, rtol=1e-14)


def test_free_bending_by_an_elastic_law_balances_the_pressure(tapered_finger):
    finger = replace(tapered_finger, elastic_law=LAW)
    q = free_bending_angles(finger, PRESSURES)
    np.testing.assert_allclose(finger.elastic_torque(q), PRESSURES[..., None] * finger.pressure_gain, atol=1e-14)


@pytest.mark.parametrize("gravity", [0j, -9.81 + 0j, 9.81j, -6 - 7j])
@pytest.mark.parametrize("pressure", [-30e3, 0.0, 120e3])
def test_at_rest_the_elastic_torque_balances_pressure_and_weight(shipped_finger, pressure, gravity):
    q = resting_angles(shipped_finger, pressure, gravity)
    external = pressure * shipped_finger.pressure_gain + gravity_torque(shipped_finger, q, gravity)
    np.testing.assert_allclose(shipped_finger.elastic_torque(q), external, atol=1e-12)
    if not gravity:
        np.testing.assert_allclose(q, free_bending_angles(shipped_finger, np.array(pressure)), atol=1e-14)


def test_weight_of_a_load_is_drakes(tapered_finger, drake_weight, bent):
    finger = replace(tapered_finger, tip_load=TipLoad(0.05, 0.015, -0.004))
    for q in bent(5, 5):
        torque = gravity_torque(finger, q, np.array(-7 + 4j))
        np.testing.assert_allclose(torque, drake_weight(finger, q, [4.0, 2.0, -7.0]), atol=1e-12)


CREEP = (CreepBranch(0.2, 0.3), CreepBranch(0.1, 4.0))


@pytest.mark.parametrize("law", [None, LAW])
def test_a_finger_that_has_crept_rests_where_its_internal_angles_have_followed(shipped_finger, law):
    """In the balance  elastic(q) = pressure + weight + memory  with z = q at every branch."""
    finger = replace(shipped_finger, elastic_law=law, creep=CREEP)
    for pressure, gravity in ((-20e3, 9.81j), (90e3, -6 - 7j)):
        q = resting_angles(finger, pressure, gravity)
        known = finger.pressure_torque(pressure) + gravity_torque(finger, q, gravity)
        memory = memory_torque(finger, np.broadcast_to(q, (2, 12)))
        np.testing.assert_allclose(finger.elastic_torque(q), known + memory, atol=1e-12)


def test_pressure_bends_by_its_law_and_before_anything_creeps(tapered_finger):
    finger = replace(tapered_finger, pressure_law=PressureLaw((0.0, 1e5), (0.0, 1.2e5)), creep=CREEP)
    q = free_bending_angles(finger, PRESSURES)
    np.testing.assert_allclose(q, 1.2 * free_bending_angles(tapered_finger, PRESSURES), rtol=1e-12)
    crept = resting_angles(finger, PRESSURES, np.zeros(PRESSURES.shape))
    np.testing.assert_allclose(crept, q / 0.7, rtol=1e-12, atol=1e-14)


@pytest.mark.parametrize(("across", "friction"), [(0.6, 0.0), (0.5, 0.4), (-0.3, 0.2)])
def test_a_press_on_a_face_balances_by_the_definition_of_a_torque(shipped_finger, across, friction):
    """Measured along an axis, it is what that axis has of the force across the finger and of friction."""
    place, gravity = 0.085, 3 - 9j
    section = shipped_finger.section(place)
    face = float(section.inner_face if across > 0 else section.outer_face)
    expected = in_balance(shipped_finger, 7e4, gravity, [Push(place, across, across * friction, face)])
    heading = expected[shipped_finger.joint_arc_lengths < place].sum()
    for axis in (None, np.exp(-1.2j)):
        part = 1.0 if axis is None else ((friction - 1j) * np.exp(1j * heading) * np.conj(axis)).real
        press = FacePress(np.array(across * part), np.array(place), axis, friction)
        np.testing.assert_allclose(resting_angles(shipped_finger, 7e4, gravity, press), expected, atol=1e-9)


def test_a_stronger_finger_bends_alike_under_pressure_and_less_under_a_force(tapered_finger):
    strong, none = strengthened(tapered_finger, 1.25), np.array(0.0)
    q = resting_angles(tapered_finger, 6e4, none)
    np.testing.assert_allclose(resting_angles(strong, 6e4, none), q, rtol=1e-12)
    light, heavy = (FacePress(np.array(force), np.array(0.05)) for force in (0.2, 0.25))
    pressed = resting_angles(tapered_finger, 6e4, none, light)
    np.testing.assert_allclose(resting_angles(strong, 6e4, none, heavy), pressed, rtol=1e-9)
    assert strengthened(tapered_finger, 1.0) is tapered_finger


def test_a_stronger_finger_is_driven_by_the_law_of_its_chamber(shipped_finger):
    bare = shipped_finger.with_sections(lambda part: replace(part, chamber_width=0.0, chamber_thickness=0.0))
    law = {"law_pressure": (0.0, 1e5), "law_effective": (0.0, 1.3e5)}
    chambered = replace(bare, chambers=(Chamber("c", (-1e-3,), (0.0,), width=(9e-3,), thickness=(9e-3,), **law),))
    found, torque = strengthened(chambered, 1.25), chambered.pressure_torque(5e4)
    np.testing.assert_allclose(found.pressure_torque(5e4), 1.25 * torque, rtol=1e-12)


def test_a_bend_that_varies_changes_linearly_along_the_finger():
    finger = uniform_finger(20)
    stiffness = softened(finger, 1.1, 0.08).stiffness / finger.stiffness
    base, tip = 1 / (1.1 * 0.92), 1 / (1.1 * 1.08)
    along = finger.joint_arc_lengths / finger.length
    np.testing.assert_allclose(stiffness, base + (tip - base) * along, rtol=1e-12)


OFFSETS = [-0.018, -0.009, 0.0, 0.009]  # m
SEGMENT = 0.01  # m


def test_forward_kinematics_is_drakes(tapered_finger, finger_plant, bent):
    plant, q = finger_plant(tapered_finger), bent(5)
    context = plant.CreateDefaultContext()
    plant.SetPositions(context, q)
    chain = forward_kinematics(q, tapered_finger.segment_length)

    links = [plant.GetBodyByName(link_name("tapered", i)) for i in range(6)]
    poses = [plant.EvalBodyPoseInWorld(context, link) for link in links]
    joints = np.array([pose.translation() for pose in poses[1:]])
    headings = [np.arctan2(*pose.rotation().matrix()[[0, 2], 2]) for pose in poses]
    middles = [pose @ [0, 0, tapered_finger.segment_length / 2] for pose in poses[1:]]
    np.testing.assert_allclose(as_points(chain.joints), joints[:, [0, 2]], atol=1e-15)
    np.testing.assert_allclose(chain.headings, headings, atol=1e-14)
    np.testing.assert_allclose(as_points(chain.segment_ends[1:]), np.array(middles)[:, [0, 2]], atol=1e-15)
    tip = plant.GetFrameByName("tapered_tip").CalcPoseInWorld(context).translation()
    np.testing.assert_allclose(as_points(chain.tip), tip[[0, 2]], atol=1e-15)


def test_sites_move_as_drakes_points_do(tapered_finger, finger_plant, bent):
    """Places, velocities and torques of forces, at points of the axis from the base to the tip, and beside it."""
    finger, q = tapered_finger, bent(5)
    plant, s, offset = finger_plant(finger), np.array([0.0, 0.02, 0.03, 0.0815, finger.length]), 0.004
    context = plant.CreateDefaultContext()
    plant.SetPositions(context, q)
    chain = forward_kinematics(q, finger.segment_length)
    sites, forces = chain.sites(s, offset), as_planar(bent(5, 2))
    for i, link in enumerate(chain.link_at(s)):
        frame, in_link = plant.GetFrameByName(link_name("tapered", link)), [offset, 0, s[i] - finger.link_ends[link]]
        np.testing.assert_allclose(as_points(sites.points[i]), (frame.CalcPoseInWorld(context) @ in_link)[[0, 2]])
        axes = frame.CalcPoseInWorld(context).rotation().matrix()[[0, 2]]
        np.testing.assert_allclose(as_points(sites.directions[i]), axes[:, 2], atol=1e-15)
        np.testing.assert_allclose(as_points(sites.normals[i]), axes[:, 0], atol=1e-15)
        world = plant.world_frame()
        moved = plant.CalcJacobianTranslationalVelocity(context, JacobianWrtVariable.kV, frame, in_link, world, world)
        np.testing.assert_allclose(as_points(sites.jacobian[i]), moved[[0, 2]].T, atol=1e-15)
        np.testing.assert_allclose(sites.torques(forces)[i], as_points(forces[i]) @ moved[[0, 2]], atol=1e-15)


def test_what_is_fixed_to_links_is_carried_by_their_directions(bent):
    q = bent(3, 12)
    levers = np.tri(12, k=-1).T * SEGMENT + np.eye(12) * SEGMENT / 2  # of the joints' links, to the segments' ends
    carried = SEGMENT / 2 + link_directions(q) @ levers
    np.testing.assert_allclose(carried, forward_kinematics(q, SEGMENT).segment_ends[..., 1:], atol=1e-15)


def test_a_chain_that_shears_is_drakes(tapered_finger, finger_plant, bent):
    finger = replace(tapered_finger, shear_factor=0.857)
    plant, q, shear = finger_plant(finger), bent(5), 0.01 * bent(2, 5)[1]
    context = plant.CreateDefaultContext()
    of_plant = PlantFinger(finger, plant, plant.GetModelInstanceByName("robot"))
    state = q @ of_plant.position_selector() + shear @ of_plant.position_selector("shear")
    plant.SetPositionsAndVelocities(context, state)
    chain = forward_kinematics(q, finger.segment_length, shear)
    joints = np.array([plant.EvalBodyPoseInWorld(context, link).translation() for link in of_plant.links[1:]])
    np.testing.assert_allclose(as_points(chain.joints), joints[:, [0, 2]], atol=1e-15)
    tip = plant.GetFrameByName("tapered_tip").CalcPoseInWorld(context).translation()
    np.testing.assert_allclose(as_points(chain.tip), tip[[0, 2]], atol=1e-15)


@pytest.mark.parametrize("offset", OFFSETS)
def test_path_lengths_are_the_distances_along_the_path(bent, offset):
    q = bent(7, 12)
    path = sensor_path(forward_kinematics(q, SEGMENT), offset)
    distances = np.abs(np.diff(path)).reshape(7, 12, 2).sum(axis=-1)
    np.testing.assert_allclose(segment_path_lengths(q, SEGMENT, offset), distances, rtol=1e-13)


def test_points_are_x_and_z():
    np.testing.assert_array_equal(as_points(np.array(3.0 + 2.0j)), [2.0, 3.0])
    assert as_planar(np.array([2.0, 3.0])) == 3.0 + 2.0j
