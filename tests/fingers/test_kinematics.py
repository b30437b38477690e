"""Planar kinematics, compared with Drake's and with the circle."""

from dataclasses import replace

import numpy as np
import pytest
from pydrake.multibody.tree import JacobianWrtVariable

from soft_gripper.fingers.finger_links import link_name
from soft_gripper.fingers.kinematics import (
    as_planar,
    as_points,
    forward_kinematics,
    link_directions,
    segment_path_lengths,
    sensor_path,
)
from soft_gripper.fingers.plant_finger import PlantFinger

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
