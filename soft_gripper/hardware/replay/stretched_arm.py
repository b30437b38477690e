"""The positions of the bodies of an arm whose sections bend and lengthen, with rigid parts between them.

The joints of a section share its length; behind every section lies a rigid part, and to its end a body is fixed. In
planar vectors z + i x (see `kinematics`), with h_s the heading at the end of section s,

    e_s = p_base + exp(i tilt) chain_s + sum over sections r before s of  d_r exp(i h_r) ,
    p_s = e_s + m_s exp(i h_s) ,

where chain_s is the end of section s along the stretched chain.

Leading axes are free; S sections, N joints.

How an arm lengthens bypasses its estimators, from the wires to `StretchedArm`: a finger in bending is inextensible,
and its joint angles do not depend on length.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from pydrake.systems.framework import BasicVector, Context, LeafSystem

from soft_gripper.arrays import Array, Planar
from soft_gripper.estimators.finger_shape import ANGLES
from soft_gripper.fingers.finger import Finger
from soft_gripper.fingers.kinematics import as_points, forward_kinematics
from soft_gripper.sensors.sensor_layout import SensorLayout
from soft_gripper.signals import XZ, describe


@dataclass(frozen=True)
class RigidParts:
    """The rigid parts of a certain arm."""

    base: complex  # m, of the first section in B
    tilt: float  # rad, of the first section in B
    couplings: Planar  # (S,) m, d: from the end of a section to the beginning of the next
    bodies: Planar  # (S,) m, m: from the end of a section to the body that is fixed there
    turns: Array  # (S,) rad, of the axes of the bodies from the headings of their sections


def stretched_arm(
    parts: RigidParts, q: Array, lengths: Array, section_ends: NDArray[np.int_]
) -> tuple[Planar, Planar, Array]:
    """Joints (..., N) m, bodies (..., S) m, both in B, and headings of the bodies (..., S) rad.

    Args:
        parts: what is rigid.
        q: joint angles, (..., N) rad.
        lengths: of the sections, (..., S) m.
        section_ends: joints up to the end of every section, from 0 to N, (S + 1,).
    """
    joints = np.diff(section_ends)
    chain = forward_kinematics(q, np.repeat(lengths / joints, joints, axis=-1))
    headings = parts.tilt + chain.headings[..., section_ends[1:]]
    shifts = parts.couplings * np.exp(1j * headings)
    before = shifts.cumsum(axis=-1) - shifts
    turned = np.exp(1j * parts.tilt)
    ends = parts.base + turned * chain.segment_ends[..., section_ends[1:]] + before
    along = parts.base + turned * chain.joints + np.repeat(before, joints, axis=-1)
    return along, ends + parts.bodies * np.exp(1j * headings), headings + parts.turns


class StretchedArm(LeafSystem):
    """The positions of joints and bodies of an arm that lengthens, and the errors of the bodies.

    ::

        estimated_joint_angles (N) rad ---> +--------------+ ---> joint_positions  (N x 2) x, z; m in B
        section_lengths (S) m ------------> | StretchedArm | ---> body_positions   (S x 2) x, z; m in B
        measured_bodies (S x 2) m in B ---> +--------------+ ---> body_error       (S) m

    Matrices are passed row after row. Stateless.
    """

    def __init__(self, parts: RigidParts, finger: Finger, bodies: Sequence[str], arcs: SensorLayout | None = None):
        """`arcs`: sensors whose sections are arcs, whatever the joint angles within them; None: these count."""
        super().__init__()
        self._parts, self._arcs, self._ends = parts, arcs, finger.section_ends(len(bodies))
        joints = range(finger.segments)
        self._angles = self.DeclareVectorInputPort(ANGLES, finger.segments)
        self._lengths = self.DeclareVectorInputPort("section_lengths", len(bodies))
        self._measured = self.DeclareVectorInputPort("measured_bodies", 2 * len(bodies))
        shape = {self._angles.ticket(), self._lengths.ticket()}
        positions = self.DeclareVectorOutputPort("joint_positions", 2 * len(joints), self._calc_joints, shape)
        describe(positions, "m", joint=joints, xz=XZ)
        places = self.DeclareVectorOutputPort("body_positions", 2 * len(bodies), self._calc_bodies, shape)
        describe(places, "m", body=bodies, xz=XZ)
        errors = self.DeclareVectorOutputPort("body_error", len(bodies), self._calc_error)
        describe(errors, "m", body=bodies)

    def _points(self, context: Context) -> tuple[np.ndarray, np.ndarray]:
        q = self._angles.Eval(context)
        q = q if self._arcs is None else self._arcs.shared_equally(self._arcs.sums(q))
        joints, bodies, _ = stretched_arm(self._parts, q, self._lengths.Eval(context), self._ends)
        return as_points(joints), as_points(bodies)

    def _calc_joints(self, context: Context, output: BasicVector) -> None:
        output.SetFromVector(self._points(context)[0].ravel())

    def _calc_bodies(self, context: Context, output: BasicVector) -> None:
        output.SetFromVector(self._points(context)[1].ravel())

    def _calc_error(self, context: Context, output: BasicVector) -> None:
        apart = self._points(context)[1].ravel() - self._measured.Eval(context)
        output.SetFromVector(np.linalg.norm(apart.reshape(-1, 2), axis=1))
