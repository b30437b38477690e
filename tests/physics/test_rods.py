"""Rods: planar against the elastica, in space against other solvers."""

from dataclasses import replace
from typing import NamedTuple

import numpy as np
import pytest
from finger_plants import BENDING_STIFFNESS, LENGTH, uniform_finger
from kirchhoff_rod import finger_tip, rod_tip
from published_rods import (
    Shapes,
    rod,
    shape_errors,
)
from pushed_fingers import bent, compliance, with_cloth
from pydrake.multibody.tree import JacobianWrtVariable, MultibodyForces
from scipy.optimize import root
from scipy.special import ellipe, ellipeinc, ellipk, ellipkinc

RODS = ("tpu", "steel")


@pytest.mark.parametrize("segments", [1, 6, 12])
def test_a_moment_about_the_axis_twists_by_T_L_over_G_J(shipped_finger, segments):  # noqa: N802
    section = replace(shipped_finger, tip=shipped_finger.base)
    at, _ = bent(section, segments, moment=(0, 0, 2e-3))
    cosine, sine = at.rotations[-1, :2, 0]
    assert np.arctan2(sine, cosine) == pytest.approx(2e-3 * 0.12 / section.base.twist_stiffness, rel=1e-9)


@pytest.mark.parametrize(
    ("pressure", "force", "off"),
    [(60e3, 0.3, 0.09e-3), (150e3, 0.3, 0.33e-3), (60e3, 1.0, 0.46e-3), (0.0, 0.3, 0.003e-3)],
)
def test_a_bent_finger_pushed_sideways_converges_to_the_rod(shipped_finger, pressure, force, off):
    rod = finger_tip(shipped_finger, pressure, (0, force, 0))
    tips = [bent(shipped_finger, segments, pressure, (0, force, 0))[1] for segments in (6, 12, 24)]
    errors = np.linalg.norm(tips - rod, axis=1)
    assert errors[1] < off
    assert np.log2(errors[:-1] / errors[1:]).min() > 1.95


def test_a_bent_finger_is_soft_sideways_by_twist(shipped_finger):
    """Compliance of the tip, mm/N: softer sideways than in its plane from 100 kPa on, softer still with a cloth."""
    pressures = (0.0, 60e3, 100e3, 150e3)
    sideways = [compliance(shipped_finger, pressure, 1) for pressure in pressures]
    np.testing.assert_allclose(sideways, [4.2, 16.6, 35.4, 62.6], rtol=0.02)
    in_plane = [compliance(shipped_finger, pressure, 0) for pressure in pressures]
    assert np.divide(in_plane, sideways)[0] > 12
    assert np.divide(sideways, in_plane)[-1] > 4
    assert compliance(with_cloth(shipped_finger), 150e3, 1) == pytest.approx(94, rel=0.02)


def integrated(finger):
    """A few shapes of the same kind, without wrenches in the middle, by the Kirchhoff rod."""
    section = finger.base
    stiffness = np.array([section.sideways_stiffness, section.bending_stiffness, section.twist_stiffness])
    random, size = np.random.default_rng(3), stiffness[0] / finger.length**2
    gravity, force, moment = random.normal(size=(3, 6, 3)) * [[[4.0]], [[0.6 * size]], [[0.6 * size * finger.length]]]
    loads = zip(force, moment, section.density * section.area * gravity, strict=True)
    tips = np.array([rod_tip(finger.length, lambda s: stiffness, *load) for load in loads])
    return Shapes(gravity, np.zeros((6, 2, 3)), np.stack([force, moment], axis=1), tips)


@pytest.mark.parametrize("name", RODS)
def test_rods_as_integrated_here(name):
    shapes, length = integrated(rod(name, 1)), rod(name, 1).length
    assert np.linalg.norm(shapes.tip - [0, 0, length], axis=1).mean() > 0.3 * length
    found = [shape_errors(rod(name, segments), shapes).mean() for segments in (6, 12, 24)]
    assert found[1] < 2.5e-3
    assert found[2] < 0.7e-3
    assert np.log2(np.divide(found[:-1], found[1:])).min() > 1.8


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
