"""Pose, squeeze and strain of a soft object, against motions and deformations that are put in."""

from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from soft_gripper.extras import soft
from soft_gripper.extras.soft import soft_object as module
from soft_gripper.extras.soft.soft_object import fitted_pose, largest_strain, move_wrench, squeeze
from soft_gripper.extras.soft.tetrahedra import read_tetrahedra

REST = read_tetrahedra(Path(soft.__path__[0]) / "objects" / "soft_block.vtk")  # 44 x 40 x 60 mm
TURNS = Rotation.from_rotvec([[0.0, 0.0, 0.0], [0.4, -1.1, 0.7], [0.0, 3.0, 0.0]])
PLACES = np.array([[0.0, 0.0, 0.0], [0.3, -0.2, 0.5], [1.0, 2.0, 3.0]])


def moved(vertices):
    """Each of three rigid motions of the same vertices, (3, V, 3) m."""
    return np.array([turn.apply(vertices) + place for turn, place in zip(TURNS, PLACES, strict=True)])


def test_a_rigid_motion_is_found_and_neither_squeezes_nor_strains():
    points = moved(REST.vertices)
    poses = fitted_pose(REST, points)
    np.testing.assert_allclose(poses[:, 4:], PLACES, atol=1e-12)
    np.testing.assert_allclose(poses[:, :4], TURNS.as_quat(canonical=True, scalar_first=True), atol=1e-9)
    np.testing.assert_allclose(squeeze(REST, points), 0, atol=1e-12)
    np.testing.assert_allclose(largest_strain(REST, points), 0, atol=1e-9)


def test_a_uniform_compression_squeezes_and_leaves_the_pose():
    """By 5 % along z: the edges along z shorten by 3 mm, and nothing shortens more."""
    points = moved(REST.vertices * [1.0, 1.0, 0.95])
    np.testing.assert_allclose(squeeze(REST, points), 0.05 * 0.060, rtol=1e-9)
    np.testing.assert_allclose(largest_strain(REST, points), 0.05, rtol=1e-9)
    poses = fitted_pose(REST, points)
    np.testing.assert_allclose(poses[:, 4:], PLACES, atol=1e-9)
    np.testing.assert_allclose(poses[:, :4], TURNS.as_quat(canonical=True, scalar_first=True), atol=1e-6)


def test_a_stretch_strains_and_hardly_squeezes():
    points = REST.vertices * [1.0, 1.2, 1.0]
    assert largest_strain(REST, points) == pytest.approx(0.2)
    assert squeeze(REST, points) == pytest.approx(0, abs=1e-12)


def test_simple_shear_has_the_principal_stretches_of_the_textbook():
    """Of a shear g, the stretches are sqrt(1 + g^2/4) +- g/2, of which the larger is further from 1."""
    g = 0.3
    sheared = REST.vertices @ (np.eye(3) + g * np.outer([0, 1, 0], [1, 0, 0]))
    assert largest_strain(REST, sheared) == pytest.approx(np.sqrt(1 + g**2 / 4) + g / 2 - 1)


def test_a_wrench_is_moved_to_the_object():
    """A force that acts at the object's position has a torque about the origin, and none about the object."""
    place, force = np.array([0.3, -0.2, 0.5]), np.array([1.0, 2.0, -3.0])
    pose = np.array([1.0, 0, 0, 0, *place])
    wrench = np.array([*(np.cross(place, force) + np.array([0, 0, 0.7])), *force])
    np.testing.assert_allclose(move_wrench(wrench, pose), [0, 0, 0.7, *force], atol=1e-12)


def test_a_contact_has_its_torque_about_the_origin_whichever_of_both_bodies_comes_first(monkeypatch):
    """That of the patch about its own place, and of its force there; forces on the other body count the other way."""
    rng = np.random.default_rng(4)
    torque, place, force = rng.normal(size=(3, 3))
    expected = np.append(torque + np.cross(place, force), force)
    block = SimpleNamespace(_geometry=7, _results=SimpleNamespace(Eval=lambda context: None))
    for geometries, sign in (((7, 3), 1.0), ((3, 7), -1.0)):
        patch = SimpleNamespace(geometries=geometries, torque=torque, place=place, force=force)
        monkeypatch.setattr(module, "patches", lambda results, own, patch=patch: [patch, patch])
        np.testing.assert_allclose(module.SoftObject._wrench(block, None), 2 * sign * expected)
