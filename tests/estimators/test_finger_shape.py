"""Poses, planes and bands of an estimated chain."""

import numpy as np
import pytest
from fingers_in_space import WAYS, yielding
from pydrake.math import RigidTransform, RollPitchYaw

from soft_gripper.estimators.finger_shape import FingerShape, Places, position_std
from soft_gripper.estimators.plane import from_base, planar_gravity, pose_entries, rotate_from_base, to_base
from soft_gripper.fingers.kinematics import as_points, forward_kinematics

X_WB = RigidTransform(RollPitchYaw(0.3, -1.1, 2.0), [0.1, -0.2, 0.3])


def shape_of(finger, q):
    """All outputs of the block, {port: value}."""
    block = FingerShape(finger)
    context = block.CreateDefaultContext()
    block.GetInputPort("estimated_joint_angles").FixValue(context, q)
    block.GetInputPort("X_WB").FixValue(context, pose_entries(X_WB))
    ports = [block.get_output_port(i) for i in range(block.num_output_ports())]
    return {port.get_name(): port.Eval(context) for port in ports}


def test_points_are_those_of_the_chain(tapered_finger, bent):
    for q in bent(10, 5):
        outputs, chain = shape_of(tapered_finger, q), forward_kinematics(q, tapered_finger.segment_length)
        np.testing.assert_allclose(outputs["joint_positions"].reshape(5, 2), as_points(chain.joints), atol=1e-16)
        np.testing.assert_allclose(outputs["tip_pose"], [*as_points(chain.tip), q.sum()], atol=1e-15)
        world = [X_WB @ np.array([x, 0.0, z]) for x, z in as_points(chain.joints)]
        np.testing.assert_allclose(outputs["joint_positions_world"].reshape(5, 3), world, atol=1e-15)


def test_arcs_bend_as_the_joints_do_one_for_every_segment(tapered_finger, bent):
    q, length = bent(5), tapered_finger.segment_length
    x, z, heading, kappa, lengths, center_x, center_z = shape_of(tapered_finger, q)["arcs"].reshape(5, 7).T
    np.testing.assert_allclose(kappa * length, q, rtol=1e-14)
    np.testing.assert_allclose(heading, np.cumsum(q) - q, atol=1e-15)
    np.testing.assert_array_equal(lengths, length)
    np.testing.assert_allclose(np.hypot(center_x - x, center_z - z), np.abs(1 / kappa), rtol=1e-12)
    assert (x[0], z[0]) == (0.0, 0.0)


POSES = [X_WB, RigidTransform(), X_WB @ X_WB]
ENTRIES = np.array([pose_entries(pose) for pose in POSES])


def test_a_vector_of_the_world_in_many_bases_and_back(bent):
    vectors = bent(3, 3)
    local = to_base(ENTRIES, vectors)
    np.testing.assert_allclose(
        local, [pose.rotation().inverse() @ v for pose, v in zip(POSES, vectors, strict=True)], atol=1e-15
    )
    np.testing.assert_allclose(rotate_from_base(ENTRIES, local), vectors, atol=1e-15)


def test_gravity_in_the_bending_plane_leaves_out_what_is_across_it():
    gravity = np.array([0.3, -2.0, -9.0])
    local = [pose.rotation().inverse() @ gravity for pose in POSES]
    for entries in (ENTRIES, ENTRIES.reshape(3, 3, 4)):
        np.testing.assert_allclose(planar_gravity(entries, gravity), [complex(z, x) for x, _, z in local], rtol=1e-14)


def test_points_in_the_world_are_those_of_drakes_transform(bent):
    points = bent(3, 7, 3)
    for pose, local, world in zip(POSES, points, from_base(ENTRIES, points), strict=True):
        np.testing.assert_allclose(world, (pose @ local.T).T, atol=1e-15)


@pytest.fixture
def covariance():
    """Of 36 joint positions, correlated, some tenths of a degree."""
    root = 1e-3 * np.random.default_rng(2).standard_normal((36, 36))
    return root @ root.T / 3


def test_std_is_that_of_the_distance_of_fingers_drawn_from_the_covariance(shipped_finger, bent, covariance):
    """40 000 fingers that only bend have it within 2 %."""
    q, covariance = bent(12), covariance[:12, :12]
    drawn = np.random.default_rng(3).multivariate_normal(q, covariance, 40_000)
    places = Places(shipped_finger, ["bending"])
    distance = np.linalg.norm(places(drawn)[0] - places(q)[0], axis=-1)
    found = position_std(shipped_finger, q, covariance)
    np.testing.assert_allclose(found, np.sqrt((distance**2).mean(axis=0)), rtol=0.02, atol=1e-12)
    assert found[0] == 0
    assert found[-1] > 1e-4


def test_variances_along_the_axes_are_those_of_fingers_drawn_in_space(shipped_finger, bent, covariance):
    finger, q = yielding(shipped_finger), bent(36) / 4
    drawn = np.random.default_rng(3).multivariate_normal(q, covariance, 20_000)
    places = Places(finger, WAYS)
    expected = ((places(drawn)[0] - places(q)[0]) ** 2).mean(axis=0)
    np.testing.assert_allclose(places.variance(q, covariance), expected, rtol=0.05, atol=1e-12)
