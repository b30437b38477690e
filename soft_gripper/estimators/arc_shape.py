"""The shape by arcs, as the paper has it, for arrays of readings."""

from dataclasses import dataclass

import numpy as np

from soft_gripper.arrays import Array, Planar
from soft_gripper.estimators.bend_sharing import BendSharing
from soft_gripper.estimators.section_arcs import arcs_from_readings, joints_on_arcs
from soft_gripper.sensors.sensor_layout import SensorLayout
from soft_gripper.shape.estimate import ShapeEstimate


@dataclass(frozen=True)
class ArcShape:
    """The estimator `arcs` of one finger; a ShapeFunction. Joints and tip lie on the arcs."""

    layout: SensorLayout

    def __call__(self, readings: Array, driving: Array, gravity: Planar | complex) -> ShapeEstimate:
        """Joint angles, joints and tip; see ShapeFunction."""
        arcs = arcs_from_readings(self.layout, readings)
        q = BendSharing(self.layout).joint_angles(arcs.theta, driving, np.asarray(gravity)[..., None])
        curve = np.concatenate([joints_on_arcs(self.layout, arcs), arcs.end[..., -1:]], axis=-1)
        return ShapeEstimate(q, curve=curve)
