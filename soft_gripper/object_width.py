"""ObjectWidth: how wide the object is that two fingers hold, from their estimates alone."""

from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from pydrake.math import RigidTransform
from pydrake.systems.framework import BasicVector, Context, InputPort, LeafSystem

from soft_gripper.arrays import Array, Planar
from soft_gripper.external_torque import mean_joint_angles
from soft_gripper.finger import Finger
from soft_gripper.kinematics import as_points
from soft_gripper.sensor_layout import SensorLayout

_POINTS = 4  # on the inner surface, for every segment


def loaded_joint_angles(layout: SensorLayout, theta: Array, external_torque: Array) -> Array:
    """Joint angles of a finger under load, rad, (..., N).

    On an arc the joints of a section share its bend, (..., S) rad, equally. Here a joint bends more or less than
    that, as the external torque, (..., N) N m, differs at it from its mean over the section.
    """
    q = mean_joint_angles(layout, theta)
    mean = np.add.reduceat(external_torque, layout.section_ends[:-1], axis=-1) / layout.joints_per_section
    difference = external_torque - mean.take(layout.joint_sections, axis=-1)
    return layout.finger.angle(layout.finger.elastic_torque(q) + difference)


@dataclass(frozen=True)
class InnerSurface:
    """Points along the inner side of a finger, a few for every segment, from the base to the edge at the tip."""

    finger: Finger

    @cached_property
    def levers(self) -> Planar:
        """How far the direction of each link, and its inner normal, carry each point, m, (N + 1, M)."""
        finger, ends = self.finger, self.finger.link_ends
        s = np.linspace(0.0, finger.length, _POINTS * finger.segments + 1)
        along = np.clip(s - ends[:-1, None], 0.0, np.diff(ends)[:, None])
        own_link = np.searchsorted(ends[1:-1], s) == np.arange(finger.segments + 1)[:, None]
        levers: Planar = along + 1j * own_link * finger.interpolate("thickness", s) / 2
        return levers

    def points(self, q: Array) -> Planar:
        """The points at joint angles (..., N) rad, m in B, (..., M)."""
        directions = np.exp(1j * q.cumsum(axis=-1))
        points: Planar = self.levers[0] + directions @ self.levers[1:]
        return points


def smallest_gap(first: Planar, second: Planar, X_B1B2: RigidTransform) -> Array:
    """Smallest distance between points of two bending planes, (..., M) m in B1 and in B2; m, (...)."""
    R, p = X_B1B2.rotation().matrix(), X_B1B2.translation()
    p_B1P = as_points(first) @ np.eye(3)[::2]
    p_B1Q = as_points(second) @ R.T[::2] + p
    squares = (p_B1P**2).sum(axis=-1)[..., :, None] + (p_B1Q**2).sum(axis=-1)[..., None, :]
    squares -= 2 * p_B1P @ np.swapaxes(p_B1Q, -1, -2)
    gap: Array = np.sqrt(np.maximum(squares.min(axis=(-1, -2)), 0.0))
    return gap


class Side(NamedTuple):
    """What ObjectWidth reads of one finger."""

    layout: SensorLayout
    surface: InnerSurface
    theta: InputPort
    external_torque: InputPort
    contact: InputPort

    def touches(self, context: Context) -> bool:
        return bool(self.contact.Eval(context)[0])

    def points(self, context: Context) -> Planar:
        """Points of the inner surface, m in B, (M)."""
        theta, torque = self.theta.Eval(context), self.external_torque.Eval(context)
        return self.surface.points(loaded_joint_angles(self.layout, theta, torque))


class ObjectWidth(LeafSystem):
    """Measures what two fingers of one palm hold between them.

    {first, second}_theta (S) rad ------------> +-------------+
    {first, second}_external_torque (N) N m --> | ObjectWidth | ---> object_width  (1) m, NaN unless both touch
    {first, second}_contact (1) 0 or 1 -------> +-------------+

    The width is the smallest gap between the inner surfaces of the fingers: that of an object that they hold by its
    widest place, as tips hold a box. Where the bases stand to each other is part of the gripper and does not change.

    The external torque refines the shape: a load at the tip straightens the far end of every section less than the
    near one. Without that a finger of four sections would seem to reach 1 mm too far at 150 kPa. Skin that gives way
    is not allowed for, since how much depends on where and how the object is touched: boxes of 38 to 50 mm held
    between the tips of the shipped gripper seem too narrow by 0.5 mm at 40 kPa, 1.5 mm at 100 kPa and 2.3 mm at
    150 kPa, of which the skin is 0.5, 1.4 and 2.0 mm (four sections; with two 0.8, 2.0 and 3.2 mm).
    """

    def __init__(self, first: SensorLayout, second: SensorLayout, X_B1B2: RigidTransform):
        """The sensors of both fingers; `X_B1B2` is the pose of the second finger's base in the first's."""
        super().__init__()
        self._X_B1B2 = X_B1B2
        self._sides = self._declare("first", first), self._declare("second", second)
        self.DeclareVectorOutputPort("object_width", 1, self._calc_width, {self.all_input_ports_ticket()})

    def _declare(self, prefix: str, layout: SensorLayout) -> Side:
        theta = self.DeclareVectorInputPort(f"{prefix}_theta", layout.sections)
        torque = self.DeclareVectorInputPort(f"{prefix}_external_torque", layout.finger.segments)
        contact = self.DeclareVectorInputPort(f"{prefix}_contact", 1)
        return Side(layout, InnerSurface(layout.finger), theta, torque, contact)

    def _calc_width(self, context: Context, output: BasicVector) -> None:
        first, second = self._sides
        if first.touches(context) and second.touches(context):
            output.SetAtIndex(0, smallest_gap(first.points(context), second.points(context), self._X_B1B2))
        else:
            output.SetAtIndex(0, np.nan)
