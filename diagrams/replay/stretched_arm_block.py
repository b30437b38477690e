"""StretchedArm: estimated joint angles and section lengths -> where the arm and its bodies are."""

from collections.abc import Sequence

import numpy as np
from pydrake.systems.framework import BasicVector, Context, LeafSystem

from soft_gripper.fingers.finger import Finger
from soft_gripper.fingers.kinematics import as_points
from soft_gripper.sensors.sensor_layout import SensorLayout
from soft_gripper.shape.finger_shape import ANGLES
from soft_gripper.shape.stretched_arm import RigidParts, stretched_arm
from soft_gripper.signals import XZ, describe


class StretchedArm(LeafSystem):
    """The places of joints and bodies of an arm that lengthens, and how far the bodies are from where they were seen.

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
