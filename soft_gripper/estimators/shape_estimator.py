"""ShapeEstimator: any ShapeFunction as a block."""

from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np

from soft_gripper.array_block import ArrayBlock
from soft_gripper.arrays import Array, Planar
from soft_gripper.errors import InputError
from soft_gripper.estimators.driving_torque import DRIVING_TORQUE
from soft_gripper.estimators.estimate import ContactForce, ShapeEstimate, ShapeFunction
from soft_gripper.estimators.finger_shape import ANGLES, put_out_arcs, put_out_pose
from soft_gripper.estimators.force_posterior import ANSWERS, INTERVAL
from soft_gripper.estimators.free_motion import motion_of
from soft_gripper.estimators.plane import bending_plane
from soft_gripper.estimators.uncertainty import position_std
from soft_gripper.sensors.measurement import MeasurementModel

CONTACT_UNITS = {"force": "N", "arc_length": "m", "force_std": "N", "arc_length_std": "m"}
_ENDS, MODES = ("least", "most"), ("first", "second")
POSTERIOR: dict[str, tuple[str, dict[str, Any]]] = {  # unit and axes of the fields of ContactPosterior
    "probability": ("1", {}),
    "answer": ("1", {}),
    "force_interval": ("N", {"force": INTERVAL}),
    "force_set": ("N", {"end": _ENDS}),
    "force_bounds": ("N", {"given": ("one", "one beyond", "several beyond")}),
    "arc_length_set": ("m", {"end": _ENDS}),
    "mode_forces": ("N", {"mode": MODES}),
    "mode_arc_lengths": ("m", {"mode": MODES}),
    "misfit": ("1", {}),
}


class ShapeEstimator(ArrayBlock):
    """Estimates the shape of one finger, and whatever else its function estimates.

    ::

        strain (R) ---------------> +----------------+ ---> estimated_joint_angles  (N) rad
        driving_torque (N) N m ---> | ShapeEstimator | ---> joint_angle_covariance  (N x N) rad^2
        X_WB (12) [R | p] --------> |                | ---> position_std            (N + 1) m, of joints and tip across
                                    |                |                              the finger
                                    |                | ---> contact_force           (1) N, positive on the inner side
                                    |                | ---> contact_arc_length      (1) m, from the base
                                    |                | ---> contact_force_std       (1) N
                                    |                | ---> contact_arc_length_std  (1) m
                                    |                | ---> contact_probability     (1) that something touches
                                    |                | ---> contact_answer          (1) 0 nothing, 1 somewhere, 2 here,
                                    |                |                              3 not known
                                    |                | ---> contact_force_interval (3) N
                                    |                | ---> contact_force_set ...   as of ContactPosterior
                                    |                | ---> theta                   (S) rad, bend of each section
                                    |                | ---> kappa                   (S) 1/m, curvature of each section
                                    |                | ---> arcs ... tip_pose       as of FingerShape, an arc a section
                                    +----------------+ ---> external_torque         (N) N m

    `strain` holds the readings, and is called after what the sensors measure; `X_WB` is the known pose of the finger's
    base. Covariance, contact, arcs and torque are there if the function gives them, and the contact's posterior if it
    has a method `posterior` of the same inputs. Arcs are given by where and in
    which direction they begin, in B, with their centres (NaN for a straight arc, which has none). Matrices leave their
    ports row after row. A reading that is not finite matters as long as it lasts.

    Stateless, unless the function has a `motion` (`free_motion`): then the driving torque of the samples before says
    how a free finger moves. Give the block inputs that are sampled together every period of it, from time 0, in
    discrete state.
    """

    driving = DRIVING_TORQUE

    def __init__(self, function: ShapeFunction, layout: MeasurementModel, gravity: Array, period: float | None = None):
        """The nominal sensors and finger; `gravity` in the world, (3,) m/s^2, zero for none.

        `period` is that of the samples, s, of a function that remembers.

        Raises:
            InputError: if the function does not estimate the joint angles of one sample and of several.
        """
        super().__init__(period_of(function, period))
        self.function = function
        self.take(layout.quantity, layout.readings)
        self.take(DRIVING_TORQUE, layout.finger.segments)
        self.take("X_WB", 12)
        self.derive("gravity", lambda X_WB: bending_plane(X_WB).planar(gravity), "X_WB")
        self._known = (
            layout.quantity,
            self.driving,
            "gravity",
            *derive_lag(self, function, self.driving, gravity, _in_plane),
        )
        self._put_out_shape(layout, self._derive_shape(function, layout))
        if self._derive_posterior(function):
            put_out_posterior(self, "posterior")

    def _derive_shape(self, function: ShapeFunction, layout: MeasurementModel) -> ShapeEstimate:
        """Declares the step "shape", a ShapeEstimate; returns one, of a straight finger."""
        self.derive("shape", function, *self._known)
        return straight_shape(function, layout)

    def _derive_posterior(self, function: ShapeFunction) -> bool:
        """Declares the step "posterior", if the function has it."""
        return derive_posterior(self, function, *self._known)

    def _put_out_shape(self, layout: MeasurementModel, found: ShapeEstimate) -> None:
        finger, joints = layout.finger, range(layout.finger.segments)
        self.put_out(ANGLES, lambda shape: shape.q, "shape", unit="rad", joint=joints)
        if found.covariance is not None:
            self.put_out(
                *("joint_angle_covariance", lambda shape: shape.covariance, "shape"),
                unit="rad^2",
                joint=joints,
                other_joint=joints,
            )
            self.put_out(
                *("position_std", lambda shape: position_std(finger, shape.q, shape.covariance), "shape"),
                unit="m",
                point=(*map(str, joints), "tip"),
            )
        if found.contact is not None:
            put_out_contact(self, lambda shape: shape.contact, "shape")
        if found.curve is not None:
            self._put_out_curve(range(layout.sections), joints)
        if found.external_torque is not None:
            self.put_out("external_torque", lambda shape: shape.external_torque, "shape", unit="N m", joint=joints)

    def _put_out_curve(self, sections: range, joints: range) -> None:
        self.derive("curve", lambda shape: shape.curve, "shape")
        self.put_out("theta", lambda curve: curve.theta, "curve", unit="rad", section=sections)
        self.put_out("kappa", lambda curve: curve.arcs.kappa, "curve", unit="1/m", section=sections)
        put_out_arcs(self, lambda curve: curve.arcs, "curve", section=sections)
        put_out_pose(self, "curve", joints)


def _in_plane(X_WB: Array, vector: Array) -> Planar:
    return bending_plane(X_WB).planar(vector)


def straight_shape(function: ShapeFunction, layout: MeasurementModel) -> ShapeEstimate:
    """The estimate of a function for a straight finger at rest.

    Raises:
        InputError: if that is no shape of this finger, or one sample and two do not give one shape and two.
    """
    readings, driving = layout.read(layout.straight), np.zeros(layout.finger.segments)
    found = function(readings, driving, 0j)
    _check_shape(function, found, driving.shape)
    twice = np.zeros((2, 1))
    _check_shape(function, function(readings + twice, driving + twice, np.zeros(2, dtype=complex)), (2, driving.size))
    return found


def _check_shape(function: ShapeFunction, found: object, shape: tuple[int, ...]) -> None:
    name = getattr(function, "__qualname__", type(function).__name__)
    expected = f"return a ShapeEstimate whose q has the shape {shape}"
    if not isinstance(found, ShapeEstimate):
        raise InputError("ShapeEstimator", "function", name, f"returned {type(found).__name__}; {expected}, rad")
    if np.shape(found.q) != shape:
        given = f"q has the shape {np.shape(found.q)} where driving has {shape}"
        raise InputError("ShapeEstimator", "function", name, f"{given}; {expected}, rad")


def period_of(function: object, period: float | None) -> float | None:
    """Period of the samples of a block around a function: its own, if it follows how the finger moves."""
    motion = motion_of(function)
    return period if motion is None else motion.period


def derive_lag(
    block: ArrayBlock, function: object, driving: str, gravity: Array, in_base: Callable[..., Any]
) -> tuple[str, ...]:
    """Declares the step "lag", if a function follows how the finger moves.

    Args:
        block: with the steps "gravity" and "X_WB".
        function: an estimator.
        driving: step with the driving torque.
        gravity: in the world, (3,) m/s^2.
        in_base: from X_WB and a vector of the world, (..., 3), to that as `function` takes it.

    Returns:
        the steps that the function takes of it.
    """
    motion = motion_of(function)
    if motion is None:
        return ()
    places: dict[str, Any] = {"begin": np.full((2, 3), np.nan), "keep": lambda middles: middles[..., 1:, :]}
    block.remember("middles", motion.middles, "X_WB", **places, over_time=motion.middles_over_time)
    block.derive("pull", lambda X_WB, at: in_base(X_WB, gravity - motion.acceleration(at)), "X_WB", "middles")
    block.remember(
        *("motion", motion.step, driving, "gravity", "pull"),
        begin=motion.begin,
        keep=lambda known: known,
        over_time=partial(motion.over_time, first=1),
    )
    block.derive("lag", motion.lag, "motion")
    return ("lag",)


def derive_posterior(block: ArrayBlock, function: object, *sources: str) -> bool:
    """Declares the step "posterior" if a function has a method of that name; returns whether it has."""
    estimate_posterior = getattr(function, "posterior", None)
    if estimate_posterior is not None:
        block.derive("posterior", estimate_posterior, *sources)
    return estimate_posterior is not None


def put_out_contact(block: ArrayBlock, contact: Callable[[Any], ContactForce], step: str) -> None:
    """Puts out the contact that follows from a step."""
    for field in ContactForce._fields:
        block.put_out(f"contact_{field}", _field(field, contact), step, unit=CONTACT_UNITS[field])


def put_out_posterior(block: ArrayBlock, step: str) -> None:
    """Puts out the fields of a step that is a ContactPosterior."""
    for field, (unit, axes) in POSTERIOR.items():
        meanings = ANSWERS if field == "answer" else ()
        block.put_out(
            *(f"contact_{field}", _field(field, lambda known: known), step), unit=unit, meanings=meanings, **axes
        )


def _field(name: str, part: Callable[[Any], Any]) -> Callable[[Any], Array]:
    return lambda found: getattr(part(found), name)
