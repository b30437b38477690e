"""Poses in 12 entries, vectors and points in B and in the world, compared with Drake's own transform."""

import numpy as np
from pydrake.math import RigidTransform, RollPitchYaw

from soft_gripper.estimators.plane import from_base, planar_gravity, pose_entries, rotate_from_base, to_base

X_WB = RigidTransform(RollPitchYaw(0.3, -1.1, 2.0), [0.1, -0.2, 0.3])
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
