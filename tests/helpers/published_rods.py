"""Round rods as chains in space, and what another solver found of them: shapes at rest, and motions.

These are solutions of the Cosserat rods of SoRoSim as published in ContinuumRoboticsLab/opencr-mujoco (MIT licence),
folder `data/reference/sorosim`: 250 shapes each of two rods in gravity under wrenches at mid length and at the tip, in
`statics_tpu.csv` and `statics_steel.csv`; and rods that are held by such wrenches and then released, one in each of
`release_tpu_*.txt` and `release_steel_*.txt`. SPATIAL_RODS names the folder in which they are.
"""

import csv
import os
import xml.etree.ElementTree as ET
from dataclasses import dataclass, fields
from functools import cached_property
from pathlib import Path
from typing import NamedTuple

import numpy as np
from pushed_fingers import SPATIAL
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import MultibodyPlant
from pydrake.systems.analysis import Simulator

from soft_gripper.fingers.cross_section import CrossSection
from soft_gripper.fingers.finger import Finger
from soft_gripper.fingers.finger_element import FingerElement
from soft_gripper.fingers.finger_links import finger_to_urdf
from soft_gripper.fingers.spatial_chain import Loads, posture, resting_positions, spatial_chain, weights

FOLDER = Path(os.environ.get("SPATIAL_RODS", "/nowhere"))
STEP = 1e-3  # s, of the plant; halved, the mean errors of released rods change by 0.03 % of the length
_AXES = (1, 2, 0)  # of the files whose x axis is the rod's, which is our z


@dataclass(frozen=True)
class RoundSection(CrossSection):
    """Solid and round; width and thickness are the diameter."""

    poisson: float = 0.5

    @cached_property
    def area(self):
        return np.pi * self.width**2 / 4

    @cached_property
    def bending_stiffness(self):
        return np.pi * self.youngs_modulus * self.width**4 / 64

    @property
    def sideways_stiffness(self):
        return self.bending_stiffness

    @cached_property
    def twist_stiffness(self):
        return self.bending_stiffness / (1 + self.poisson)

    @cached_property
    def gyration(self):
        return (self.width**2 / 16,) * 2


@dataclass(frozen=True)
class RoundRod(Finger):
    """A finger that is the same round rod all along."""

    def section(self, s):
        values = (getattr(self.base, field.name) for field in fields(RoundSection))
        return RoundSection(*(np.full(np.shape(s), value) for value in values))


def rod(name, segments, relaxation_time=0.0):
    """A rod of the files."""
    length, radius, modulus, poisson, density = {
        "tpu": (0.4, 5e-3, 70e6, 0.4, 1200.0),
        "steel": (0.6, 0.8e-3, 200e9, 0.33, 7870.0),
    }[name]
    section = RoundSection(2 * radius, 2 * radius, modulus, density, poisson=poisson)
    return RoundRod(name, length, section, section, radius, segments, relaxation_time, yields=SPATIAL)


class Shapes(NamedTuple):
    """S shapes of a rod, whose axis at its base is z."""

    gravity: np.ndarray  # (S, 3) m/s^2
    middle: np.ndarray  # (S, 2, 3) force, N, and moment, N m, at half length
    end: np.ndarray  # (S, 2, 3) those at the tip
    tip: np.ndarray  # (S, 3) m


def published_shapes(name):
    """The shapes of a file, or None if it is not there."""
    path = FOLDER / f"statics_{name}.csv"
    if not path.is_file():
        return None
    with path.open(encoding="utf-8") as file:
        rows = [row[1:] for row in csv.reader(file)][2:]
    turning, moving = np.split(np.array(rows, dtype=float).reshape(-1, 2, 3, len(rows[0]))[:, :, _AXES], 2, axis=1)
    wrenches = np.stack([moving[:, 0, :, 1:3], turning[:, 0, :, 1:3]], axis=1)
    return Shapes(moving[:, 0, :, 0], wrenches[..., 0], wrenches[..., 1], moving[:, 0, :, -1])


class Release(NamedTuple):
    """A rod that is let go at time 0, at T times."""

    relaxation_time: float  # s
    held: Shapes  # the one shape that it begins with
    time: np.ndarray  # (T,) s
    tips: np.ndarray  # (T, 3) m


def published_releases(name):
    """The motions in the files of a rod, from none to many."""
    return [_release(path) for path in sorted(FOLDER.glob(f"release_{name}_*.txt"))]


def _release(path):
    """SoRoSim's damping is the ratio of viscous to elastic moduli, s, and so a relaxation time."""
    about, wrenches, *rows = np.loadtxt(path)
    moment, force, end_moment, end_force = wrenches[1:].reshape(4, 3)[:, _AXES]
    tips = np.array(rows)[:, 10:][:, _AXES]
    middle, end = np.array([[[force, moment]], [[end_force, end_moment]]])
    return Release(about[0], Shapes(about[None, 10:][:, _AXES], middle, end, tips[:1]), np.array(rows)[:, 0], tips)


def positions_at_rest(rod, shapes):
    """Of the joints, (S, J) rad."""
    chain, ends = spatial_chain(rod), rod.link_ends
    held = np.array([np.searchsorted(ends, rod.length / 2) - 1, rod.segments])  # links at mid length and at the tip
    along = np.array([rod.length / 2, rod.length]) - ends[held]
    own, wrenches = weights(rod, chain, shapes.gravity), np.stack([shapes.middle, shapes.end], axis=1)
    loads = Loads(
        np.append(own.frames, chain.link_frames(held)),
        np.concatenate([own.points, np.outer(along, [0, 0, 1])]),
        np.concatenate([own.forces, wrenches[:, :, 0]], axis=1),
        np.concatenate([own.moments, wrenches[:, :, 1]], axis=1),
    )
    stiffness = chain.interleaved(rod.stiffnesses)
    return resting_positions(chain, stiffness, np.zeros(len(stiffness)), loads)


def tips(rod, q):
    """Of a rod at joint positions (..., J) rad, (..., 3) m."""
    at = posture(spatial_chain(rod), q)
    return at.origins[..., -1, :] + at.rotations[..., -1, :, 2] * rod.segment_length / 2


def shape_errors(rod, shapes):
    """Of the tips at rest, shares of the length, (S,)."""
    return np.linalg.norm(tips(rod, positions_at_rest(rod, shapes)) - shapes.tip, axis=-1) / rod.length


def plant_of(rod, time_step=0.0, gravity=(0.0, 0.0, 0.0)):
    """Drake's plant of a rod whose base is the world."""
    robot, plant = ET.Element("robot", name="robot"), MultibodyPlant(time_step)
    robot.extend(finger_to_urdf(FingerElement(rod, "world")))
    Parser(plant).AddModelsFromString(ET.tostring(robot, encoding="unicode"), "urdf")
    plant.mutable_gravity_field().set_gravity_vector(gravity)
    plant.Finalize()
    return plant


def released_tips(rod, release, step=STEP):
    """In Drake's plant at the times of a release, (T, 3) m."""
    plant = plant_of(rod, step, release.held.gravity[0])
    simulator = Simulator(plant)
    context = simulator.get_mutable_context()
    plant.get_actuation_input_port().FixValue(context, np.zeros(plant.num_actuators()))
    plant.SetPositions(context, positions_at_rest(rod, release.held)[0])
    found = []
    for time in release.time:
        simulator.AdvanceTo(time)
        found.append(plant.GetPositions(context))
    return tips(rod, np.array(found))


def release_errors(name, segments, release, step=STEP):
    """Of the tip over the whole motion, shares of the length, (T,)."""
    chain = rod(name, segments, release.relaxation_time)
    return np.linalg.norm(released_tips(chain, release, step) - release.tips, axis=-1) / chain.length
