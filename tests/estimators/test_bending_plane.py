"""The bending plane: from the 12 entries of a base pose, compared with Drake's own transform."""

import numpy as np
from pydrake.math import RigidTransform, RollPitchYaw

from soft_gripper.estimators.plane import bending_plane, planar_gravity, pose_entries, to_world

X_WB = RigidTransform(RollPitchYaw(0.3, -1.1, 2.0), [0.1, -0.2, 0.3])
PLANE = bending_plane(pose_entries(X_WB))


def test_entries_are_the_matrix_row_after_row():
    np.testing.assert_array_equal(pose_entries(X_WB).reshape(3, 4), X_WB.GetAsMatrix34())


def test_axes_and_origin_are_those_of_the_base():
    np.testing.assert_array_equal(PLANE.axes, [X_WB.rotation().col(0), X_WB.rotation().col(2)])
    np.testing.assert_array_equal(PLANE.origin, X_WB.translation())


def test_a_vector_of_the_world_in_the_plane():
    vector = np.array([1.0, -2.0, -9.0])
    x, _, z = X_WB.rotation().inverse() @ vector
    np.testing.assert_allclose(PLANE.planar(vector), complex(z, x), rtol=1e-14)


def test_gravity_in_many_planes_is_that_in_each():
    gravity = np.array([0.3, -2.0, -9.0])
    poses = [X_WB, RigidTransform(), X_WB @ X_WB]
    planar = planar_gravity(np.array([pose.GetAsMatrix34() for pose in poses]), gravity)
    each = [bending_plane(pose_entries(pose)).planar(gravity) for pose in poses]
    np.testing.assert_allclose(planar, each, rtol=1e-14)


def test_points_in_the_world_are_those_of_drakes_transform(bent):
    points = bent(7) + 1j * bent(7)
    for point, world in zip(points, to_world(points, PLANE), strict=True):
        np.testing.assert_allclose(world, X_WB @ np.array([point.imag, 0.0, point.real]), atol=1e-15)


def test_a_batch_is_its_samples(bent):
    points = bent(2, 3) + 1j * bent(2, 3)
    single = [to_world(row, PLANE) for row in points]
    np.testing.assert_allclose(to_world(points, PLANE), single, atol=1e-15)
