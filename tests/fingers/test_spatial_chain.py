"""The chain in space against Drake's: poses, weight, springs, dampers; and slopes against differences."""

from dataclasses import replace

import numpy as np
import pytest
from pydrake.multibody.tree import MultibodyForces

from soft_gripper.errors import SimulationDivergedError
from soft_gripper.fingers.finger_links import joint_name
from soft_gripper.fingers.finger_parts import YIELDS, TipLoad
from soft_gripper.fingers.spatial_chain import (
    Loads,
    posture,
    resting_positions,
    spatial_chain,
    torque_slopes,
    torques,
    weights,
)

GRAVITY = np.array([3.0, -4.0, 8.0])


@pytest.fixture(params=[("bending", "sideways", "twist"), YIELDS, ("twist", "bending"), ("bending",)], ids=" ".join)
def finger(request, tapered_finger):
    return replace(tapered_finger, yields=request.param, tip_load=TipLoad(0.02, 0.005, -0.004))


@pytest.fixture
def chain(finger):
    return spatial_chain(finger)


@pytest.fixture
def q(chain, bent):
    """Positions of two shapes: turns of up to 0.4 rad, slides of up to 4 mm."""
    return np.where(chain.turns, 1.0, 0.01) * bent(2, len(chain.deformations))


@pytest.fixture
def plant(finger, finger_plant):
    return finger_plant(finger)


def test_the_chain_is_that_of_the_plant(finger, chain, plant, q):
    names = [joint_name(finger.name, i, way) for way, i in zip(chain.deformations, chain.segments, strict=True)]
    assert [plant.GetJointByName(name).position_start() for name in names] == list(range(len(names)))
    at, context = posture(chain, q), plant.CreateDefaultContext()
    for i in (0, 1):
        plant.SetPositions(context, q[i])
        for link in range(1, finger.segments + 1):
            X_BL = plant.GetBodyByName(f"tapered_link_{link}").EvalPoseInWorld(context)
            frame = chain.link_frames(np.array(link))
            np.testing.assert_allclose(at.rotations[i, frame], X_BL.rotation().matrix(), atol=1e-14)
            np.testing.assert_allclose(at.origins[i, frame], X_BL.translation(), atol=1e-15)


def test_weight_is_drakes(finger, chain, plant, q):
    """But for the links between joints, of a millionth of the others' mass."""
    plant.mutable_gravity_field().set_gravity_vector(GRAVITY)
    context, found = plant.CreateDefaultContext(), torques(posture(chain, q), weights(finger, chain, GRAVITY))
    for i in (0, 1):
        plant.SetPositions(context, q[i])
        expected = plant.CalcGravityGeneralizedForces(context)
        np.testing.assert_allclose(found[i], expected, atol=1e-5 * np.abs(expected).max())


def test_slopes_are_those_of_the_torques(finger, chain, q, bent):
    loads = weights(finger, chain, GRAVITY)
    loads = loads._replace(moments=0.01 * bent(*loads.forces.shape))
    small = 1e-6 * np.eye(len(chain.deformations))
    each = [
        (torques(posture(chain, q + step), loads) - torques(posture(chain, q - step), loads)) / 2e-6 for step in small
    ]
    np.testing.assert_allclose(torque_slopes(posture(chain, q), loads), np.stack(each, axis=-1), atol=1e-9)


def test_springs_and_dampers_are_those_of_the_beam(finger, chain, plant):
    section = finger.section(finger.joint_arc_lengths)
    beam = {
        "bending": section.bending_stiffness,
        "sideways": section.sideways_stiffness,
        "twist": section.twist_stiffness,
        "stretch": section.stretch_stiffness,
    }
    expected = chain.interleaved({way: np.asarray(value) / finger.segment_length for way, value in beam.items()})
    size = np.where(chain.turns, 0.1, 1e-3)
    for i, direction in enumerate(np.eye(len(chain.deformations))):
        context, forces = plant.CreateDefaultContext(), MultibodyForces(plant)
        plant.SetPositions(context, size * direction)
        plant.CalcForceElementsContribution(context, forces)
        torque = plant.CalcGeneralizedForces(context, forces)
        np.testing.assert_allclose(torque, -expected * size * direction, atol=2e-6 * expected[i] * size[i])
    joints = [
        plant.GetJointByName(joint_name("tapered", i, way))
        for way, i in zip(chain.deformations, chain.segments, strict=True)
    ]
    damping = [joint.default_damping() for joint in joints]
    np.testing.assert_allclose(damping, finger.relaxation_time * expected, rtol=1e-12)


def test_balance_is_of_driving_torque_weight_and_springs(finger, chain):
    stiffness, loads = chain.interleaved(finger.stiffnesses), weights(finger, chain, np.stack([GRAVITY, -GRAVITY]))
    driving = chain.interleaved({way: 60e3 * gains[0] for way, gains in finger.pressure_gains.items()})
    q = resting_positions(chain, stiffness, driving, loads)
    left = driving + torques(posture(chain, q), loads) - stiffness * q
    np.testing.assert_allclose(left, 0, atol=1e-10)


def test_what_finds_no_balance_says_so(finger, chain):
    push = Loads(np.array([len(chain.deformations)]), np.zeros((1, 3)), np.array([[np.nan, 0, 0]]), np.zeros((1, 3)))
    with pytest.raises(SimulationDivergedError):
        resting_positions(chain, chain.interleaved(finger.stiffnesses), np.zeros(len(chain.deformations)), push)
