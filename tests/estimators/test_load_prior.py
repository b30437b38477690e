"""The prior of the load: the covariance of the torques that random forces along a finger have, and its modes."""

from dataclasses import replace

import numpy as np
import pytest
from fingers_in_space import bent_chain, by_way, load_covariance, sensors, torque_covariance, yielding

from soft_gripper.estimators.mechanics import TIP_FRACTION, Mechanics
from soft_gripper.estimators.uncertainty import Uncertainty
from soft_gripper.fingers.spatial_chain import Loads, spatial_chain, torques, weights
from soft_gripper.sensors.sensor_layout import SensorLayout

LOAD_PRESSURE = 1.5e5  # Pa


def of_load(layout, q, load_pressure=LOAD_PRESSURE):
    """The covariance of the torques, (D, D)."""
    mechanics = Mechanics(layout, Uncertainty(load_pressure=load_pressure))
    compliance = mechanics.compliance(q)
    return mechanics.load_covariance(mechanics.bent_finger(q), q) / np.outer(compliance, compliance)


def in_plane(finger, load_pressure=LOAD_PRESSURE):
    """Of a straight finger that only bends."""
    return of_load(SensorLayout(finger, 1), np.zeros(finger.segments), load_pressure)


def test_covariance_is_that_of_forces_drawn_along_the_finger_and_on_the_tip(shipped_finger):
    """White noise of forces is added up by quadrature, not drawn: a force a cell, in 12 000 cells."""
    s, length, cells = shipped_finger.joint_arc_lengths, shipped_finger.length, 12_000
    x = (np.arange(cells) + 0.5) * length / cells
    levers = np.maximum(x - s[:, None], 0)
    along = levers @ levers.T
    along /= (x**2).sum()  # 1 at the base
    tip = np.outer(length - s, length - s) / length**2
    usual = LOAD_PRESSURE * shipped_finger.pressure_gain[0]
    expected = usual**2 * (TIP_FRACTION * tip + (1 - TIP_FRACTION) * along)
    np.testing.assert_allclose(in_plane(shipped_finger), expected, rtol=1e-6)


@pytest.mark.parametrize("in_space", [False, True])
def test_that_of_a_bent_finger_is_that_of_unit_forces_one_after_the_other(shipped_finger, bent, in_space):
    layout = sensors(yielding(shipped_finger)) if in_space else SensorLayout(shipped_finger, 1)
    q = bent(layout.straight.size) / 2
    expected = load_covariance(layout.finger, q, LOAD_PRESSURE)
    np.testing.assert_allclose(of_load(layout, q), expected, rtol=0, atol=1e-12 * expected.max())


@pytest.mark.parametrize("in_space", [False, True])
def test_weight_is_that_of_the_masses_of_all_links(shipped_finger, bent, in_space):
    layout = sensors(yielding(shipped_finger)) if in_space else SensorLayout(shipped_finger, 1)
    q, gravity = bent(2, layout.straight.size), np.array([[3.0, -1.0, -9.0], [0.0, 2.0, 9.81]])
    mechanics = Mechanics(layout, Uncertainty())
    found = mechanics.weight(mechanics.bent_finger(q), gravity)
    for each, pull, torque in zip(q, gravity, found, strict=True):
        dead = weights(layout.finger, spatial_chain(layout.finger), pull)
        expected = by_way(layout.finger, torques(bent_chain(layout.finger, each), dead))
        np.testing.assert_allclose(torque, expected, rtol=0, atol=1e-13)


@pytest.mark.parametrize(("in_space", "count"), [(False, 5), (True, 10)])
def test_modes_of_a_load_are_torques_of_forces_that_turn_with_the_links(shipped_finger, bent, in_space, count):
    """By dead loads at all places, one after the other; of a finger that only bends they stay those of the straight."""
    layout = sensors(yielding(shipped_finger)) if in_space else SensorLayout(shipped_finger, 1)
    finger, q = layout.finger, 0.1 * bent(layout.straight.size)
    mechanics, at = Mechanics(layout, Uncertainty()), bent_chain(layout.finger, q if in_space else 0 * q)
    patterns, points = mechanics._strong_mode_basis[1], mechanics._forces
    patterns = patterns.reshape(3, -1, count)  # forces along x, y and z of the links
    frames = points.frames
    for mode in range(count):
        forces = (at.rotations[frames] @ patterns[:, :, mode].T[..., None])[..., 0]
        loads = Loads(frames, points.places[:, :3, 0], forces, np.zeros_like(forces))
        found = mechanics.load_modes(mechanics.bent_finger(q))[:, mode]
        np.testing.assert_allclose(found, by_way(finger, torques(at, loads)), atol=1e-12)
    straight = mechanics.load_modes(mechanics.bent_finger(0 * q))
    np.testing.assert_allclose(straight[24:], 0, atol=1e-12, err_msg="nothing twists a straight finger")
    np.testing.assert_allclose(straight.T @ straight, np.eye(count), atol=1e-9)
    kept = straight[:12, :5] if in_space else straight
    variances, modes = np.linalg.eigh(torque_covariance(finger, Uncertainty().load_pressure))
    np.testing.assert_allclose(mechanics.load_variances[:5], variances[:-6:-1], rtol=1e-9)
    np.testing.assert_allclose(np.abs((modes[:, :-6:-1] * kept).sum(axis=0)), 1, rtol=1e-9)


def test_strong_and_weak_modes_are_the_whole_load(shipped_finger):
    mechanics = Mechanics(SensorLayout(shipped_finger, 1), Uncertainty())
    strong = mechanics.load_modes(mechanics.bent_finger(np.zeros(12))) * np.sqrt(mechanics.load_variances)
    modes = np.column_stack([strong, mechanics.weak_modes])
    assert modes.shape == (12, 12)
    expected = torque_covariance(shipped_finger, Uncertainty().load_pressure)
    np.testing.assert_allclose(modes @ modes.T, expected, atol=1e-9 * expected.max())


def test_a_joint_that_slides_deviates_as_far_as_one_that_turns_moves_its_segment(shipped_finger):
    """The number of segments does not matter."""
    for segments in (6, 12):
        finger = replace(shipped_finger, segments=segments, yields=("bending", "stretch"))
        layout = sensors(finger, "four_faces")
        ways, angle = layout.deformations, 1e-3
        assert ways == ("bending", "stretch")
        stds = np.sqrt(np.diagonal(Mechanics(layout, Uncertainty(angle=angle)).deviations))
        turned, slid = stds.reshape(2, segments)
        np.testing.assert_allclose(turned, angle)
        np.testing.assert_allclose(slid, angle * finger.length / segments)
