"""A Kirchhoff rod, integrated along its length: what a chain in space is, were it not cut into segments."""

import numpy as np
from scipy.integrate import solve_ivp
from scipy.interpolate import CubicSpline
from scipy.optimize import root

_KNOTS = 13  # along a finger, at which its section is evaluated
_NOTHING = np.zeros(3)


def rod_tip(length, stiffness, force=_NOTHING, moment=_NOTHING, weight=_NOTHING, driving=lambda s: _NOTHING):
    """Where the tip of a rod is, (3,) m, that is clamped at the origin along z.

    The moment at the base is unknown, and found by shooting: at the tip it is that which acts there.

    Args:
        length: m.
        stiffness: against bending about x and y, and against twist, at s m from the base, (3,) N m^2.
        force, moment: on the tip, N and N m, of constant direction.
        weight: N/m.
        driving: moments of a pressure, about axes that turn with the rod, at s, (3,) N m.
    """

    def slopes(s, state):
        R, moment_here = state[3:12].reshape(3, 3), state[12:]
        x, y, z = (R.T @ moment_here + driving(s)) / stiffness(s)
        turning = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
        beyond = force + weight * (length - s)
        return np.concatenate([R[:, 2], (R @ turning).ravel(), -np.cross(R[:, 2], beyond)])

    def end(base_moment):
        start = np.concatenate([_NOTHING, np.eye(3).ravel(), base_moment])
        return solve_ivp(slopes, (0, length), start, rtol=1e-8, atol=1e-11).y[:, -1]

    # The arm of the loads as the rod is without them.
    arm = end(_NOTHING)[:3]
    scale = np.abs(stiffness(0)).min() / length
    first = (moment + np.cross(arm, force + weight * length / 2)) / scale
    found = root(lambda unknown: (end(scale * unknown)[12:] - moment) / scale, first, tol=1e-10)
    assert found.success
    return end(scale * found.x)[:3]


def finger_tip(finger, pressure=0.0, force=_NOTHING):
    """Where the tip of a finger is, were it such a rod, (3,) m in B, under a pressure, Pa, and a force on it, N."""
    along = np.linspace(0, finger.length, _KNOTS)
    section = finger.section(along)
    gain = section.chamber_area * section.chamber_eccentricity
    stiffness = CubicSpline(
        along, np.stack([section.sideways_stiffness, section.bending_stiffness, section.twist_stiffness], axis=-1)
    )
    driving = CubicSpline(along, np.outer(gain * pressure, [0, 1, 0]))
    return rod_tip(finger.length, stiffness, np.asarray(force, float), driving=driving)
