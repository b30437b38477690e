"""A push on a finger in space: a force at one point, and derivatives by differences."""

import numpy as np
import pytest

from soft_gripper.extras.placement.pushed_finger import UNKNOWNS, Push, PushedFinger
from soft_gripper.fingers.spatial_chain import Loads, resting_positions, spatial_chain, weights

FORCE, S, Y = np.array([-0.2, 0.25, 0.1]), 0.083, 0.004


def rest(hanging, v, pressure=60e3):
    """At rest under the unknowns of a push and a share of the drive, (D,)."""
    return hanging.at_rest((1 + v[5]) * hanging.driving(np.array([pressure])), Push(v[:3], v[3], v[4]))


def test_a_push_is_a_force_at_its_place(hanging):
    finger, chain = hanging.finger, spatial_chain(hanging.finger)
    link = int(np.sum(finger.joint_arc_lengths < S))
    own = weights(finger, chain, hanging.gravity)
    loads = Loads(
        np.append(own.frames, chain.beyond(np.array(link))),
        np.concatenate([own.points, [[0.0, Y, S - finger.link_ends[link]]]]),
        np.concatenate([own.forces, FORCE[None]]),
        np.zeros((len(own.forces) + 1, 3)),
    )
    driving = chain.spread({"bending": finger.pressure_torque(60e3)})
    expected = resting_positions(chain, chain.spread(finger.stiffnesses), driving, loads)
    found = rest(hanging, np.array([*FORCE, S, Y, 0.0]))
    np.testing.assert_allclose(found[chain.places(hanging.ways)], expected, atol=1e-10)


@pytest.mark.parametrize("i", range(len(UNKNOWNS)), ids=UNKNOWNS)
def test_slopes_are_those_of_differences(hanging, i):
    v, step = np.array([*FORCE, S, Y, 0.0]), 1e-5 * np.eye(6)[i]
    q = rest(hanging, v)
    response = hanging.response(q, hanging.driving(np.array([60e3])), Push(v[:3], v[3], v[4]))
    expected = (rest(hanging, v + step) - rest(hanging, v - step)) / 2e-5
    np.testing.assert_allclose(response.missing, 0, atol=1e-9)
    np.testing.assert_allclose(response.slopes[:, i], expected, atol=1e-5 * np.abs(expected).max())


def test_what_is_missing_leads_to_balance(hanging):
    v = np.array([*FORCE, S, Y, 0.0])
    driving, push, q = hanging.driving(np.array([60e3])), Push(v[:3], v[3], v[4]), np.zeros(36)
    for _ in range(8):
        q = q + hanging.response(q, driving, push).missing
    np.testing.assert_allclose(q, rest(hanging, v), atol=1e-9)


def test_directions_across_a_straight_finger_are_those_of_its_base(hanging):
    weightless = PushedFinger(hanging.finger, np.zeros(3))
    np.testing.assert_allclose(weightless.across(np.zeros((2, 36)), np.array([0.0, 0.1])), [np.eye(3)[:2]] * 2)


def test_tasks_are_free_or_pushed_at_every_pressure(spatial_tasks):
    assert len(spatial_tasks.names) == 2 * (1 + 3 * 2)
    force = np.linalg.norm(spatial_tasks.push.force, axis=-1)
    np.testing.assert_allclose(force, 0.3 * spatial_tasks.is_pushed)
    assert set(spatial_tasks.pushed.names) == {"in plane", "sideways", "torsion"}
    twist = np.abs(spatial_tasks.q[:, 24:].sum(axis=-1))
    assert twist[[name == "torsion" for name in spatial_tasks.names]].min() > np.radians(2)
    plane = [name in ("free", "in plane") for name in spatial_tasks.names]
    np.testing.assert_allclose(spatial_tasks.q[plane, 12:], 0, atol=1e-12)
