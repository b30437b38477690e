"""The chain in space against rods: closed forms, a Kirchhoff rod integrated here, and solutions of another solver.

Those are 250 shapes each of two rods in gravity under wrenches at mid length and at the tip, solutions of the
Cosserat rods of SoRoSim as published in ContinuumRoboticsLab/opencr-mujoco (MIT licence), folder
`data/reference/sorosim`. SPATIAL_RODS names the folder in which they are, as `statics_tpu.csv` and `statics_steel.csv`.
"""

import csv
import os
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest
from kirchhoff_rod import finger_tip, rod_tip

from soft_gripper.fingers.spatial_chain import Loads, SpatialChain, posture, resting_positions, spatial_chain

SPATIAL = ("bending", "sideways", "twist")


def at_tip(chain, force, moment=(0, 0, 0)):
    place = np.array([[0, 0, chain.segment_length / 2]])
    return Loads(np.array([len(chain.ways)]), place, np.array([force], float), np.array([moment], float))


def bent(finger, segments, pressure=0.0, force=(0, 0, 0), moment=(0, 0, 0)):
    """The posture in balance, and where the tip is, m."""
    finger = replace(finger, segments=segments, yields=SPATIAL)
    chain, driving = spatial_chain(finger), {"bending": finger.pressure_torque(pressure)}
    loads = at_tip(chain, force, moment)
    q = resting_positions(chain, chain.spread(finger.stiffnesses), chain.spread(driving), loads)
    at = posture(chain, q)
    return at, loads.places(at)[0]


def test_a_cantilever_pushed_sideways(shipped_finger):
    """F L^3 / 3 E I, to the square of F."""
    section = replace(shipped_finger, tip=shipped_finger.base)
    deflection = 0.3 * section.length**3 / (3 * section.base.sideways_stiffness)
    _, tip = bent(section, 48, force=(0, 0.3, 0))
    assert tip[1] == pytest.approx(deflection, rel=3e-4)
    assert bent(shipped_finger, 12, force=(0, 0.3, 0))[1][1] == pytest.approx(1.2622e-3, abs=1e-7)


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

    def compliance(finger, pressure, direction):
        force, rest = 0.1 * np.eye(3)[direction], bent(finger, 24, pressure)[1]
        return 1e3 * (bent(finger, 24, pressure, force)[1] - rest)[direction] / 0.1

    pressures = (0.0, 60e3, 100e3, 150e3)
    sideways = [compliance(shipped_finger, pressure, 1) for pressure in pressures]
    np.testing.assert_allclose(sideways, [4.2, 16.6, 35.4, 62.6], rtol=0.02)
    in_plane = [compliance(shipped_finger, pressure, 0) for pressure in pressures]
    assert np.divide(in_plane, sideways)[0] > 12
    assert np.divide(sideways, in_plane)[-1] > 4
    ends = (shipped_finger.base, shipped_finger.tip)
    base, tip = (replace(end, layer_shear_modulus=end.youngs_modulus / 3) for end in ends)
    assert compliance(replace(shipped_finger, base=base, tip=tip), 150e3, 1) == pytest.approx(94, rel=0.02)


class Rod(NamedTuple):
    """A solid round rod, straight at rest."""

    length: float  # m
    radius: float  # m
    youngs_modulus: float  # Pa
    poisson: float
    density: float  # kg/m^3

    @property
    def stiffness(self):
        """Against bending about x and y, and twist, (3,) N m^2."""
        bending = self.youngs_modulus * np.pi * self.radius**4 / 4
        return np.array([bending, bending, bending / (1 + self.poisson)])

    @property
    def line_density(self):
        """kg/m."""
        return self.density * np.pi * self.radius**2


RODS = {"tpu": Rod(0.4, 5e-3, 70e6, 0.4, 1200.0), "steel": Rod(0.6, 0.8e-3, 200e9, 0.33, 7870.0)}


class Shapes(NamedTuple):
    """S shapes of a rod, whose axis at its base is z."""

    gravity: np.ndarray  # (S, 3) m/s^2
    middle: np.ndarray  # (S, 2, 3) force, N, and moment, N m, at half length
    end: np.ndarray  # (S, 2, 3) those at the tip
    tip: np.ndarray  # (S, 3) m


def chain_tips(rod, shapes, segments):
    """Where the tips of a chain come to rest, (S, 3) m."""
    length = rod.length / segments
    chain = SpatialChain.of(segments, length, SPATIAL)
    ends = np.array([0, *(np.arange(segments) + 0.5) * length, rod.length])
    held = np.searchsorted(ends, rod.length / 2) - 1  # the link on which the middle is
    links = np.array([*range(segments + 1), held, segments])
    along = np.array([*np.diff(ends) / 2, rod.length / 2 - ends[held], length / 2])
    weights = shapes.gravity[:, None] * (rod.line_density * np.diff(ends))[:, None]
    wrenches = np.stack([shapes.middle, shapes.end], axis=1)
    forces, moments = np.concatenate([weights, wrenches[:, :, 0]], axis=1), np.zeros((len(weights), len(links), 3))
    moments[:, -2:] = wrenches[:, :, 1]
    loads = Loads(chain.beyond(links), np.outer(along, [0, 0, 1]), forces, moments)
    of_ways = dict(zip(("sideways", "bending", "twist"), rod.stiffness / length, strict=True))
    stiffness = chain.spread({way: np.full(segments, value) for way, value in of_ways.items()})
    q = resting_positions(chain, stiffness, np.zeros(len(stiffness)), loads)
    return loads.places(posture(chain, q))[:, -1]


def errors(rod, shapes, segments):
    """Of the tips, shares of the length, (S,)."""
    return np.linalg.norm(chain_tips(rod, shapes, segments) - shapes.tip, axis=-1) / rod.length


def published(name):
    """The shapes of a file; its x axis is the rod's, our z."""
    path = Path(os.environ.get("SPATIAL_RODS", "/nowhere")) / f"statics_{name}.csv"
    if not path.is_file():
        pytest.skip(f"there is no {path.name} in the folder SPATIAL_RODS")
    with path.open(encoding="utf-8") as file:
        rows = [row[1:] for row in csv.reader(file)][2:]
    turning, moving = np.split(np.array(rows, dtype=float).reshape(-1, 2, 3, len(rows[0]))[:, :, [1, 2, 0]], 2, axis=1)
    wrenches = np.stack([moving[:, 0, :, 1:3], turning[:, 0, :, 1:3]], axis=1)
    return Shapes(moving[:, 0, :, 0], wrenches[..., 0], wrenches[..., 1], moving[:, 0, :, -1])


def integrated(rod):
    """A few shapes of the same kind, without wrenches in the middle, by the Kirchhoff rod."""
    random, size = np.random.default_rng(3), rod.stiffness[0] / rod.length**2
    gravity, force, moment = random.normal(size=(3, 6, 3)) * [[[4.0]], [[0.6 * size]], [[0.6 * size * rod.length]]]
    weights = rod.line_density * gravity
    loads = zip(force, moment, weights, strict=True)
    tips = np.array([rod_tip(rod.length, lambda s: rod.stiffness, *load) for load in loads])
    return Shapes(gravity, np.zeros((6, 2, 3)), np.stack([force, moment], axis=1), tips)


@pytest.mark.parametrize("name", RODS)
def test_rods_as_integrated_here(name):
    rod = RODS[name]
    shapes = integrated(rod)
    assert np.linalg.norm(shapes.tip - [0, 0, rod.length], axis=1).mean() > 0.3 * rod.length
    found = [errors(rod, shapes, segments).mean() for segments in (6, 12, 24)]
    assert found[1] < 2.5e-3
    assert found[2] < 0.7e-3
    assert np.log2(np.divide(found[:-1], found[1:])).min() > 1.8


@pytest.mark.parametrize("name", RODS)
def test_rods_as_another_solver_finds_them(name):
    rod, shapes = RODS[name], published(name)
    coarse, fine = (errors(rod, shapes, segments) for segments in (12, 24))
    assert len(fine) >= 250
    assert coarse.mean() < 2.5e-3
    assert fine.mean() < 0.7e-3
    assert np.percentile(fine, 95) < 1.5e-3
    assert np.log2(coarse.mean() / fine.mean()) > 1.7
