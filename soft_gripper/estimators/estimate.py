"""The interface of shape estimators: inputs and results.

An estimator of this project is a function of arrays whose leading axes are free, so that a block calls it for one
sample and an evaluation once for a whole recording, or for many of them.

Another estimator is such a function and its name in `named_estimators.SHAPE_FUNCTIONS`.
"""

from typing import Any, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from soft_gripper.arrays import Array, Planar
from soft_gripper.estimators.arcs import ArcCurve
from soft_gripper.fingers.finger import Finger
from soft_gripper.fingers.kinematics import forward_kinematics

# Direction in B in which a grasped object pushes the finger: against the direction of closing.
CLOSING = np.array([-1.0, 0.0, 0.0])


class ContactForce(NamedTuple):
    """Contact on a finger as one force; None for fields that an estimator of the bending plane lacks."""

    force: Array  # (...) N, across the finger in the bending plane of the link, positive on the inner side, 0 without
    arc_length: Array  # (...) m, from the base to the centre of pressure, NaN without contact
    force_std: Array  # (...) N, standard deviation
    arc_length_std: Array  # (...) m, standard deviation
    vector: Array | None = None  # (..., 3) N in B, 0 without contact
    vector_covariance: Array | None = None  # (..., 3, 3) N^2
    # (...) rad, root mean square of the angle to the true force, NaN without contact
    direction_std: Array | None = None
    # (...) rad around the finger, where it is pressed: 0 on the inner side, pi / 2 toward +y; NaN without contact
    side: Array | None = None
    # (...) N, size of the part at right angles to the line from the base to the contact, which bends the finger
    transverse_force: Array | None = None
    transverse_force_std: Array | None = None  # (...) N

    def at(self, rows: NDArray[np.int_]) -> "ContactForce":
        """The contacts of some samples, by their numbers along the first axis."""
        return ContactForce(*(None if values is None else values[rows] for values in self))  # type: ignore[arg-type]


def force_along(vector: Array, covariance: Array, direction: Array) -> tuple[Array, Array]:
    """The component of a force along a direction, and its standard deviation, (...) N.

    Args:
        vector: the force, (..., 3) N.
        covariance: of it, (..., 3, 3) N^2.
        direction: of length 1, (..., 3), in the same frame.
    """
    variance = np.einsum("...i,...ij,...j->...", direction, covariance, direction)
    return np.asarray((vector * direction).sum(axis=-1)), np.sqrt(np.maximum(variance, 0.0))


class ShapeEstimate(NamedTuple):
    """The estimated shape; None for quantities that a method does not estimate.

    The joints are in the order of `MeasurementModel.deformations`, bending first: D in all, N if the finger only bends.
    """

    q: Array  # (..., D) rad, and m where joints slide
    covariance: Array | None = None  # (..., D, D), of these
    contact: ContactForce | None = None
    curve: ArcCurve | None = None  # if joints and tip do not follow from the joint angles
    external_torque: Array | None = None  # (..., N) N m, if it is not that of the dynamic balance

    def at(self, rows: NDArray[np.int_]) -> "ShapeEstimate":
        """The estimates of some samples, by their numbers along the first axis."""
        contact = None if self.contact is None else self.contact.at(rows)
        covariance = None if self.covariance is None else self.covariance[rows]
        curve = None if self.curve is None else self.curve.at(rows)
        torque = None if self.external_torque is None else self.external_torque[rows]
        return ShapeEstimate(self.q[rows], covariance, contact, curve, torque)

    def points(self, finger: Finger) -> Planar:
        """Joints and tip in the bending plane, (..., N + 1) m in B; of a finger that only bends."""
        curve = self.curve or forward_kinematics(self.q, finger.segment_length)
        return curve.points


class ShapeFunction(Protocol):
    """An estimator: from readings, driving torque and gravity to the shape."""

    def __call__(self, readings: Array, driving: Array, gravity: Array) -> ShapeEstimate:
        """
        Args:
            readings: of the sensors, (..., R); NaN where there is none.
            driving: torque at the joints known before the sensors are read, (..., D) N m, and N where they slide;
                see `driving_torque`.
            gravity: in B, (..., 3) m/s^2.
        """


def estimates_at(function: ShapeFunction, rows: NDArray[np.int_], *samples: Any) -> ShapeEstimate:
    """Estimates at some samples of a recording, by increasing indices; a filter takes all samples before them.

    `samples` are the arguments of the function at all samples, as of `recorded_inputs`.
    """
    if hasattr(function, "at"):
        return function.at(rows, *samples)
    return function(*samples_at(rows, *samples))


def samples_at(rows: NDArray[np.int_], *samples: Any) -> tuple[Any, ...]:
    """Some samples of arrays, (T, ...), or of tuples of arrays."""
    return tuple(
        type(values)(*(part[rows] for part in values)) if isinstance(values, tuple) else values[rows]
        for values in samples
    )
