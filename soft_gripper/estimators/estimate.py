"""The interface of shape estimators: inputs and results.

An estimator of this project is a function of arrays whose leading axes are free, so that a block calls it for one
sample and an evaluation once for a whole recording, or for many of them.
"""

from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from soft_gripper.arrays import Array, Planar
from soft_gripper.estimators.arcs import ArcCurve
from soft_gripper.fingers.finger import Finger
from soft_gripper.fingers.kinematics import forward_kinematics


class ContactForce(NamedTuple):
    """The contact forces on a finger, combined into one force across it, each (...)."""

    force: Array  # N, positive on the inner side, 0 without contact
    arc_length: Array  # m, from the base to the centre of pressure, NaN without contact
    force_std: Array  # N, standard deviation
    arc_length_std: Array  # m, standard deviation


class ShapeEstimate(NamedTuple):
    """The estimated shape; None for quantities that a method does not estimate."""

    q: Array  # (..., N) rad, joint angles
    covariance: Array | None = None  # (..., N, N) rad^2, of the joint angles
    contact: ContactForce | None = None
    curve: ArcCurve | None = None  # if joints and tip do not follow from the joint angles
    external_torque: Array | None = None  # (..., N) N m, if it is not that of the dynamic balance

    def at(self, rows: NDArray[np.int_]) -> "ShapeEstimate":
        """The estimates of some samples, by their numbers along the first axis."""
        contact = None if self.contact is None else ContactForce(*(values[rows] for values in self.contact))
        covariance = None if self.covariance is None else self.covariance[rows]
        curve = None if self.curve is None else self.curve.at(rows)
        torque = None if self.external_torque is None else self.external_torque[rows]
        return ShapeEstimate(self.q[rows], covariance, contact, curve, torque)

    def points(self, finger: Finger) -> Planar:
        """Joints and tip, (..., N + 1) m in B."""
        curve = self.curve or forward_kinematics(self.q, finger.segment_length)
        return curve.points


class SpatialContact(NamedTuple):
    """The contact on a finger in space, as one force."""

    across: ContactForce  # across the finger in the bending plane of the link that is pressed, as in the plane
    force: Array  # (..., 3) N in B, 0 without contact
    force_std: Array  # (..., 3) N, along x, y and z of B
    direction_std: Array  # (...) rad, root mean square of the angle to the true force, NaN without contact
    # (...) rad around the finger, where it is pressed: 0 on the inner side, pi / 2 toward +y; NaN without contact
    side: Array


class SpatialShape(NamedTuple):
    """The estimated shape of a finger in space: its joints way after way (`MeasurementModel.ways`), D in all."""

    q: Array  # (..., D) rad, and m where joints slide
    covariance: Array  # (..., D, D)
    contact: SpatialContact | None = None


class ShapeFunction(Protocol):
    """An estimator: from readings, driving torque and gravity to the shape."""

    def __call__(self, readings: Array, driving: Array, gravity: Planar | complex) -> ShapeEstimate:
        """
        Args:
            readings: of the sensors, (..., R); NaN where there is none.
            driving: torque at the joints that is known before anything is read, N m, (..., N); see `driving_torque`.
            gravity: in the bending plane, z + i x in B, m/s^2, a number or (...).
        """
