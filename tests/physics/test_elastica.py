"""The chain of rigid segments against the elastica, the exact large deflection of a thin beam.

A dead wrench acts on the tip: torque about y, N m, and force along x, N.
"""

from typing import NamedTuple

import numpy as np
import pytest
from finger_plants import BENDING_STIFFNESS, LENGTH, uniform_finger
from pydrake.multibody.tree import JacobianWrtVariable, MultibodyForces
from scipy.optimize import root
from scipy.special import ellipe, ellipeinc, ellipk, ellipkinc


class Elastica(NamedTuple):
    """A load on the tip and where the tip of the beam then is."""

    moment: float  # N m
    force: float  # N
    tip: np.ndarray  # x, z; m in B


def circular_arc(degrees):
    """A beam that a pure moment bends by an angle."""
    theta = np.radians(degrees)
    tip = np.array([1 - np.cos(theta), np.sin(theta)]) * LENGTH / theta
    return Elastica(BENDING_STIFFNESS * theta / LENGTH, 0.0, tip)


def end_loaded(degrees):
    """A cantilever that a transverse load turns by an angle at its tip (Bisshopp and Drucker, 1945)."""
    sine = np.sin(np.radians(degrees))
    m = (1 + sine) / 2
    start = np.arcsin(1 / np.sqrt(2 * m))
    load = ellipk(m) - ellipkinc(start, m)  # sqrt(P L^2 / E I)
    deflection = 1 - 2 * (ellipe(m) - ellipeinc(start, m)) / load
    tip = np.array([deflection, np.sqrt(2 * sine) / load]) * LENGTH
    return Elastica(0.0, BENDING_STIFFNESS * load**2 / LENGTH**2, tip)


CASES = [circular_arc(90), circular_arc(120), end_loaded(60), end_loaded(75)]
NAMES = ["moment-90", "moment-120", "load-60", "load-75"]


def tip_position(plant, context):
    x, _, z = plant.GetFrameByName("finger_tip").CalcPoseInWorld(context).translation()
    return np.array([x, z])


def settled_tip(plant, case):
    """Where the plant's own forces balance the load exactly: no time and no damping are involved."""
    context = plant.CreateDefaultContext()
    tip, world = plant.GetFrameByName("finger_tip"), plant.world_frame()
    wrench = np.array([0, case.moment, 0, case.force, 0, 0])

    def unbalanced(q):
        plant.SetPositions(context, q)
        forces = MultibodyForces(plant)
        plant.CalcForceElementsContribution(context, forces)
        J = plant.CalcJacobianSpatialVelocity(context, JacobianWrtVariable.kV, tip, np.zeros(3), world, world)
        return plant.CalcGeneralizedForces(context, forces) + J.T @ wrench

    joints = plant.num_positions()
    solution = root(unbalanced, np.full(joints, 1.5 / joints), tol=1e-12)
    assert np.abs(solution.fun).max() < 1e-10  # N m
    plant.SetPositions(context, solution.x)
    return tip_position(plant, context)


def tip_error(build, finger, case):
    """Distance from the beam's tip over the length."""
    return float(np.linalg.norm(settled_tip(build(finger), case) - case.tip)) / LENGTH


@pytest.mark.parametrize("case", CASES, ids=NAMES)
def test_error_falls_with_the_square_of_the_segment(finger_plant, case):
    errors = [tip_error(finger_plant, uniform_finger(n), case) for n in (6, 12, 24, 48)]
    orders = np.log2(np.divide(errors[:-1], errors[1:]))
    assert orders.min() >= 1.9
