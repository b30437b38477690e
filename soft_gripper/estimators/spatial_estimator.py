"""SpatialEstimator: an estimator of shapes in space as a block."""

from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from soft_gripper.array_block import ArrayBlock
from soft_gripper.arrays import Array
from soft_gripper.estimators.driving_torque import driving_port
from soft_gripper.estimators.estimate import SpatialContact, SpatialShape
from soft_gripper.estimators.finger_shape import POSE_UNITS, put_out_arcs, segment_arcs
from soft_gripper.estimators.shape_estimator import (
    MODES,
    derive_lag,
    derive_posterior,
    period_of,
    put_out_contact,
    put_out_posterior,
)
from soft_gripper.fingers.finger import Finger
from soft_gripper.fingers.finger_parts import SLIDES
from soft_gripper.fingers.spatial_chain import posture, spatial_chain, vector_product
from soft_gripper.sensors.measurement import MeasurementModel
from soft_gripper.sensors.sensor_block import joints_port
from soft_gripper.signals import POSE, XYZ, XZ

TIP = "estimated_tip_position"


class SpatialFunction(Protocol):
    """An estimator: readings (..., R), driving torque (..., D) and gravity in B, (..., 3) m/s^2 -> shape in space."""

    def __call__(self, readings: Array, driving: Array, gravity: Array) -> SpatialShape: ...


class Places:
    """Joints and tip of a finger in space, and how the positions of its joints, way after way, move them."""

    def __init__(self, finger: Finger, ways: tuple[str, ...]):
        chain = self._chain = spatial_chain(finger)
        self._in_chain = chain.places(ways)
        self._from_chain = np.argsort(self._in_chain)
        frames = chain.beyond(np.arange(1, finger.segments + 1))
        self._frames, self._beyond = np.append(frames, frames[-1]), np.append(np.zeros(finger.segments), 1.0)
        self._half = finger.segment_length / 2
        self._moved = self._frames > np.arange(len(chain.ways))[:, None]

    def __call__(self, q: Array) -> tuple[Array, Array, Array]:
        """Places P = N + 1 of joints and tip, at joint positions (..., D).

        Returns:
            the places, (..., P, 3) m in B; the direction of the tip, (..., 3); and how joints move the places,
            (..., D, P, 3) m/rad, or 1.
        """
        at = posture(self._chain, q[..., self._in_chain])
        along = at.rotations[..., self._frames, :, :][..., 2]
        places = at.origins[..., self._frames, :] + (self._beyond * self._half)[:, None] * along
        screws = at.screws[..., None, :]
        moves = vector_product(screws[..., :3], places[..., None, :, :]) + screws[..., 3:]
        moves = moves * self._moved[..., None]
        return places, along[..., -1, :], moves[..., self._from_chain, :, :]


class SpatialEstimator(ArrayBlock):
    """Estimates the shape of one finger that leaves its plane.

    ::

        strain (R) ---------------> +------------------+ ---> estimated_joint_angles      (N) rad, in the plane
        driving_torque (N) N m ---> | SpatialEstimator | ---> estimated_sideways_angles   (N) rad
        X_WB (12) [R | p] --------> |                  | ---> estimated_twist_angles      (N) rad
                                    |                  | ---> estimated_joint_positions   (N x 3) m in B
                                    |                  | ---> estimated_tip_position      (3) m in B
                                    |                  | ---> estimated_twist             (1) rad, of the whole finger
                                    |                  | ---> joint_angle_covariance      (N x N) rad^2, in the plane
                                    |                  | ---> position_std                (N + 1) m, of joints and tip
                                    |                  | ---> tip_position_std            (3) m, along x, y and z of B
                                    |                  | ---> twist_std                   (1) rad
                                    |                  | ---> arcs ... tip_pose           as of FingerShape
                                    |                  | ---> contact_force ...           as of ShapeEstimator
                                    |                  | ---> contact_force_vector        (3) N in B
                                    |                  | ---> contact_force_vector_std    (3) N, along x, y and z of B
                                    |                  | ---> contact_force_world         (3) N in the world
                                    |                  | ---> contact_direction_std       (1) rad, of the force
                                    |                  | ---> contact_side                (1) rad around the section:
                                    |                  |                                  0 inside, pi / 2 at +y
                                    +------------------+ ---> contact_mode_sides          (2) rad, likewise

    There is an output for every way in which the finger yields, `estimated_stretch_lengths` (N) m among them, and an
    input such as `sideways_driving_torque` (N) N m for every other way in which it is driven. `position_std` is that of
    the distance from the estimated place, in all directions. The contact is there if the function has a method
    `posterior`; `contact_force` is the part across the finger in the bending plane. Of the ports as of FingerShape,
    `joint_positions` and `tip_pose` are the shape in space as seen in the bending plane, and `arcs` has its bends in
    the plane. Stateless, or as ShapeEstimator if the function has a `motion`.
    """

    driving = "driving"

    def __init__(
        self, function: SpatialFunction, layout: MeasurementModel, gravity: Array, period: float | None = None
    ):
        """The nominal sensors and finger; `gravity` in the world, (3,) m/s^2, zero for none.

        `period` is that of the samples, s, of a function that remembers.
        """
        super().__init__(period_of(function, period))
        self.function = function
        finger, ways = layout.finger, layout.ways
        self.take(layout.quantity, layout.readings)
        driven = [way for way in ways if way == "bending" or way in finger.driven_ways]
        ports = [driving_port(way) for way in driven]
        for port in ports:
            self.take(port, finger.segments)
        self.take("X_WB", 12)

        def driving(*found: Array) -> Array:
            known = dict(zip(driven, found, strict=True))
            return np.concatenate([known.get(way, np.zeros_like(found[0])) for way in ways], axis=-1)

        self.derive(self.driving, driving, *ports)
        self.derive("gravity", lambda X_WB: _in_base(X_WB, gravity), "X_WB")
        self._known = (
            layout.quantity,
            self.driving,
            "gravity",
            *derive_lag(self, function, self.driving, gravity, _in_base),
        )
        self._derive_shape(function, layout)
        self.derive("places", lambda shape: places(shape.q), "shape")
        places = Places(finger, ways)
        self._put_out_joints(finger, ways)
        self._put_out_pose(finger)
        if "twist" in ways:
            self._put_out_twist(ways.index("twist") * finger.segments + np.arange(finger.segments))
        if self._derive_posterior(function):
            self._put_out_contact()

    def _derive_shape(self, function: SpatialFunction, layout: MeasurementModel) -> None:
        """Declares the step "shape", a SpatialShape."""
        self.derive("shape", function, *self._known)

    def _derive_posterior(self, function: SpatialFunction) -> bool:
        """Declares the step "posterior", if the function has it."""
        return derive_posterior(self, function, *self._known)

    def _put_out_joints(self, finger: Finger, ways: tuple[str, ...]) -> None:
        joints = range(finger.segments)
        for i, way in enumerate(ways):
            rows = slice(i * finger.segments, (i + 1) * finger.segments)
            unit = "m" if way in SLIDES else "rad"
            self.put_out(f"estimated_{joints_port(way)}", _rows(rows), "shape", unit=unit, joint=joints)
        plane = slice(finger.segments)
        self.put_out(
            *("joint_angle_covariance", lambda shape: shape.covariance[..., plane, plane], "shape"),
            unit="rad^2",
            joint=joints,
            other_joint=joints,
        )
        put_out_arcs(self, lambda shape: segment_arcs(finger, shape.q[..., plane]), "shape", segment=joints)

    def _put_out_pose(self, finger: Finger) -> None:
        joints = range(finger.segments)
        self.put_out(
            *("estimated_joint_positions", lambda places: places[0][..., :-1, :], "places"),
            unit="m",
            joint=joints,
            xyz=XYZ,
        )
        self.put_out(TIP, lambda places: places[0][..., -1, :], "places", unit="m", xyz=XYZ)
        self.put_out(
            "joint_positions", lambda places: places[0][..., :-1, ::2], "places", unit="m", joint=joints, xz=XZ
        )
        self.put_out("joint_positions_world", _in_world, "places", "X_WB", unit="m", joint=joints, xyz=XYZ)
        self.put_out("tip_pose", _tip_pose, "places", unit=POSE_UNITS, pose=POSE)
        self.derive("variance", _variance, "places", "shape")
        point = (*map(str, joints), "tip")
        self.put_out("position_std", lambda variance: np.sqrt(variance.sum(axis=-1)), "variance", unit="m", point=point)
        self.put_out("tip_position_std", lambda variance: np.sqrt(variance[..., -1, :]), "variance", unit="m", xyz=XYZ)

    def _put_out_twist(self, joints: NDArray[np.int_]) -> None:
        def std(shape: SpatialShape) -> Array:
            return np.sqrt(shape.covariance[..., joints[:, None], joints].sum(axis=(-2, -1)))

        self.put_out("estimated_twist", lambda shape: shape.q[..., joints].sum(axis=-1), "shape", unit="rad")
        self.put_out("twist_std", std, "shape", unit="rad")

    def _put_out_contact(self) -> None:
        self.derive("contact", lambda shape: shape.contact, "shape")
        self.derive("posterior of force", lambda posterior: posterior.known, "posterior")
        put_out_contact(self, lambda contact: contact.across, "contact")
        self.put_out("contact_force_vector", lambda contact: contact.force, "contact", unit="N", xyz=XYZ)
        self.put_out("contact_force_vector_std", lambda contact: contact.force_std, "contact", unit="N", xyz=XYZ)
        self.put_out("contact_force_world", _turned, "contact", "X_WB", unit="N", xyz=XYZ)
        self.put_out("contact_direction_std", lambda contact: contact.direction_std, "contact", unit="rad")
        self.put_out("contact_side", lambda contact: contact.side, "contact", unit="rad")
        put_out_posterior(self, "posterior of force")
        self.put_out("contact_mode_sides", lambda posterior: posterior.mode_sides, "posterior", unit="rad", mode=MODES)


def _in_base(X_WB: Array, vector: Array) -> Array:
    """A vector of the world, (..., 3), in B."""
    return np.asarray((vector[..., None, :] @ X_WB.reshape(*X_WB.shape[:-1], 3, 4)[..., :3])[..., 0, :])


def _turned(contact: SpatialContact, X_WB: Array) -> Array:
    X = X_WB.reshape(*X_WB.shape[:-1], 3, 4)
    return np.asarray((X[..., :3] @ contact.force[..., None])[..., 0])


def _rows(rows: slice) -> Any:
    return lambda shape: shape.q[..., rows]


def _in_world(places: tuple[Array, Array, Array], X_WB: Array) -> Array:
    X = X_WB.reshape(*X_WB.shape[:-1], 3, 4)
    return np.asarray(places[0][..., :-1, :] @ np.swapaxes(X[..., :3], -1, -2) + X[..., None, :, 3])


def _tip_pose(places: tuple[Array, Array, Array]) -> Array:
    at, along, _ = places
    heading = np.arctan2(along[..., 0], along[..., 2])
    return np.concatenate([at[..., -1, ::2], heading[..., None]], axis=-1)


def _variance(places: tuple[Array, Array, Array], shape: SpatialShape) -> Array:
    """Variances of joints and tip along x, y and z, m^2, (..., N + 1, 3)."""
    moves = np.moveaxis(places[2], -3, -1)  # (..., P, 3, D)
    return np.asarray(np.maximum(((moves @ shape.covariance[..., None, :, :]) * moves).sum(axis=-1), 0))
