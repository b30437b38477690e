"""ShapeEstimator: any ShapeFunction as a block; a new field of an estimate needs its unit and axes here."""

from collections.abc import Callable, Sequence
from functools import cached_property, partial
from operator import attrgetter
from typing import Any, Protocol, runtime_checkable

import numpy as np

from soft_gripper.array_block import ArrayBlock
from soft_gripper.arrays import Array
from soft_gripper.errors import InputError
from soft_gripper.estimators.batches import map_batches
from soft_gripper.estimators.driving_torque import driving_port
from soft_gripper.estimators.estimate import ContactForce, ShapeEstimate, ShapeFunction
from soft_gripper.estimators.finger_shape import TIP, Places, put_out_arcs, put_out_curve, put_out_places
from soft_gripper.estimators.force_posterior import ANSWERS, INTERVAL
from soft_gripper.estimators.free_motion import motion_of
from soft_gripper.estimators.plane import rotate_from_base, to_base
from soft_gripper.estimators.zeroing import Zeros, zeroing_of
from soft_gripper.fingers.finger import Finger
from soft_gripper.fingers.finger_parts import SLIDES
from soft_gripper.sensors.measurement import MeasurementModel
from soft_gripper.sensors.sensor_block import joints_port
from soft_gripper.signals import XYZ

CONTACT: dict[str, tuple[str, dict[str, Any]]] = {  # unit and axes of the fields of ContactForce
    "force": ("N", {}),
    "arc_length": ("m", {}),
    "force_std": ("N", {}),
    "arc_length_std": ("m", {}),
    "vector": ("N", {"xyz": XYZ}),
    "vector_covariance": ("N^2", {"xyz": XYZ, "other_xyz": XYZ}),
    "direction_std": ("rad", {}),
    "side": ("rad", {}),
    "transverse_force": ("N", {}),
    "transverse_force_std": ("N", {}),
}
_SET_ENDS, MODES = ("least", "most"), ("first", "second")
POSTERIOR: dict[str, tuple[str, dict[str, Any]]] = {  # unit and axes of the fields of ContactPosterior
    "probability": ("1", {}),
    "answer": ("1", {}),
    "force_interval": ("N", {"force": INTERVAL}),
    "transverse_force_interval": ("N", {"force": INTERVAL}),
    "force_set": ("N", {"end": _SET_ENDS}),
    "force_bounds": ("N", {"given": ("one", "one beyond", "several beyond")}),
    "arc_length_set": ("m", {"end": _SET_ENDS}),
    "mode_forces": ("N", {"mode": MODES}),
    "mode_arc_lengths": ("m", {"mode": MODES}),
    "mode_sides": ("rad", {"mode": MODES}),
    "misfit": ("1", {}),
}


@runtime_checkable
class Filter(Protocol):
    """Estimator with state, which declares its steps in a block by itself."""

    period: float  # s, between samples

    def declare(self, block: ArrayBlock, driving: str) -> ShapeEstimate:
        """Declares the steps "q", "shape" and "posterior", and further outputs, of a block; returns the initial shape.

        "q" are the joint positions, a step of their own because contacts take far longer and are often not read.
        `driving` is the step with the driving torque; the readings are the step of the sensors' quantity, and gravity
        is "gravity".
        """


class Estimates:
    """Shape and contact posterior of samples, each computed when first read; a posterior brings its shape along."""

    def __init__(self, shape: Callable[..., ShapeEstimate], posterior: Callable[..., Any], *samples: Any):
        """Functions of the samples."""
        self._shape, self._posterior, self._samples = shape, posterior, samples

    @cached_property
    def posterior(self) -> Any:
        """See `ContactPosterior`."""
        return self._posterior(*self._samples)

    @cached_property
    def shape(self) -> ShapeEstimate:
        """The shape, with the contact."""
        shared = getattr(self.__dict__.get("posterior"), "shape", None)
        return self._shape(*self._samples) if shared is None else shared.value


def derive_estimates(
    block: ArrayBlock, shape: Callable[..., ShapeEstimate], posterior: Callable[..., Any], *sources: str
) -> None:
    """Declares the steps "shape" and "posterior" of a block, functions of the same sources."""
    block.derive("estimates", partial(Estimates, shape, posterior), *sources)
    block.derive("shape", attrgetter("shape"), "estimates")
    block.derive("posterior", attrgetter("posterior"), "estimates")


class ShapeEstimator(ArrayBlock):
    """Estimates the shape of one finger, and all other fields of its function's estimate.

    ::

        strain (R) ---------------> +----------------+ ---> estimated_joint_angles      (N) rad, in the plane
        driving_torque (N) N m ---> | ShapeEstimator | ---> estimated_sideways_angles   (N) rad
        X_WB (12) [R | p] --------> |                | ---> estimated_twist_angles      (N) rad
                                    |                | ---> estimated_joint_positions   (N x 3) m in B
                                    |                | ---> estimated_tip_position      (3) m in B
                                    |                | ---> estimated_twist             (1) rad, of the whole finger
                                    |                | ---> arcs ... tip_pose           as of FingerShape
                                    |                | ---> joint_angle_covariance      (N x N) rad^2, in the plane
                                    |                | ---> position_std                (N + 1) m, of joints and tip
                                    |                | ---> tip_position_std            (3) m, along x, y and z of B
                                    |                | ---> twist_std                   (1) rad
                                    |                | ---> transverse_force            (1) N, bends the finger
                                    |                | ---> transverse_force_std        (1) N
                                    |                | ---> transverse_force_interval   (3) N
                                    |                | ---> contact_force               (1) N, positive inside
                                    |                | ---> contact_arc_length          (1) m, from the base
                                    |                | ---> contact_force_std           (1) N
                                    |                | ---> contact_arc_length_std      (1) m
                                    |                | ---> contact_force_vector        (3) N in B
                                    |                | ---> contact_force_vector_covariance  (3 x 3) N^2
                                    |                | ---> contact_force_world         (3) N in the world
                                    |                | ---> contact_direction_std       (1) rad, of the force
                                    |                | ---> contact_side                (1) rad around the section:
                                    |                |                                  0 inside, pi / 2 at +y
                                    |                | ---> contact_probability         (1) that something touches
                                    |                | ---> contact_answer              (1) 0 nothing, 1 somewhere,
                                    |                |                                  2 here, 3 not known
                                    |                | ---> contact_force_interval      (3) N
                                    |                | ---> contact_force_set ...       as of ContactPosterior
                                    |                | ---> zeroed_strain               (R) readings, as they are used
                                    |                | ---> theta                       (S) rad, bend of each section
                                    |                | ---> kappa                       (S) 1/m, its curvature
                                    +----------------+ ---> external_torque             (N) N m

    `strain` holds the readings, and is called after what the sensors measure; `X_WB` is the known pose of the finger's
    base. There is an output for every deformation that the sensors see,
    `estimated_stretch_lengths` (N) m among them, and an input such as `sideways_driving_torque` (N) N m for every other
    deformation that is driven. `zeroed_strain` is there with a `free_pressure`, below which sensors are zeroed.
    Covariance, contact, curve and torque are there if the function gives them, and the contact's posterior if it has a
    method `posterior` of the same inputs. `position_std` is that of the distance from
    the estimated location, in all directions. `transverse_force` is the size of the part of the force at right angles
    to the line from the base to the contact, which bends the finger, and so is the one that is known best;
    `contact_force` is the part across the finger in the bending plane, the normal force of most contacts. Of the
    ports as of FingerShape, `joint_positions` and `tip_pose` are the shape as seen in the bending plane, and `arcs` has
    its bends in the plane. If the function gives a curve, they are of that: an arc a section, by where and in which
    direction it begins, in B, with its centre (NaN for a straight arc, which has none). Matrices leave their ports row
    after row. A reading that is not finite matters as long as it lasts.

    Stateless, unless the function remembers (`Filter`), has a `motion` (`free_motion`): then the driving torque of the
    samples before says how a free finger moves; or follows the zeros of its sensors (`zeroing`). Give the block inputs
    that are sampled together every period of it, from time 0, in discrete state.
    """

    def __init__(self, function: ShapeFunction, layout: MeasurementModel, gravity: Array):
        """The nominal sensors and finger; `gravity` in the world, (3,) m/s^2, zero for none.

        Raises:
            InputError: if the function does not estimate the joint angles of one sample and of several.
        """
        super().__init__(_period_of(function))
        self.function, finger = function, layout.finger
        self.take(layout.quantity, layout.readings)
        self._take_driving(layout)
        self.take("X_WB", 12)

        self.derive("gravity", lambda X_WB: to_base(X_WB, gravity), "X_WB")
        estimate = self._derive_shape(function, layout, gravity)
        if "posterior" in self.steps:
            self._put_out_posterior()  # first, as it brings the shape along when all is read in this order
        self._put_out_joints(layout, estimate)
        if estimate.curve is None:
            self._put_out_places(finger, layout.deformations, estimate)
        else:
            self._put_out_curve(range(layout.sections), range(finger.segments))
        if estimate.contact is not None:
            self._put_out_contact(estimate.contact)
        if estimate.external_torque is not None:
            joints = range(finger.segments)
            self.put_out("external_torque", lambda shape: shape.external_torque, "shape", unit="N m", joint=joints)

    def _take_driving(self, layout: MeasurementModel) -> None:
        """Takes the driving torques of all driven deformations, and joins them to one vector, (D)."""
        names = {"bending", *layout.finger.driven_deformations}
        driven_deformations = [name for name in layout.deformations if name in names]
        ports = [driving_port(deformation) for deformation in driven_deformations]
        for port in ports:
            self.take(port, layout.finger.segments)

        def driving(*torques: Array) -> Array:
            torque_of = dict(zip(driven_deformations, torques, strict=True))
            zeros = np.zeros_like(torques[0])
            return np.concatenate([torque_of.get(deformation, zeros) for deformation in layout.deformations], axis=-1)

        self.driving = ports[0]  # the port or step with it
        if tuple(layout.deformations) != ("bending",):
            self.driving = "driving"
            self.derive(self.driving, driving, *ports)

    def _derive_shape(self, function: ShapeFunction, layout: MeasurementModel, gravity: Array) -> ShapeEstimate:
        """Declares the steps "q", "shape" and perhaps "posterior"; returns the shape of a straight finger."""
        if isinstance(function, Filter):
            return function.declare(self, self.driving)
        readings, *std = self._derive_zeros(function, layout)
        inputs = readings, self.driving, "gravity", *self._derive_lag(function, gravity), *std
        estimate_posterior = getattr(function, "posterior", None)
        if estimate_posterior is None:
            self.derive("shape", function, *inputs)
        else:
            derive_estimates(self, function, estimate_posterior, *inputs)
        self.derive("q", attrgetter("q"), "shape")
        return straight_shape(function, layout)

    def _derive_lag(self, function: ShapeFunction, gravity: Array) -> tuple[str, ...]:
        """Declares the step "lag", if a function follows how the finger moves; returns the steps that it takes."""
        motion = motion_of(function)
        if motion is None:
            return ()
        places: dict[str, Any] = {"begin": np.full((2, 3), np.nan), "keep": lambda middles: middles[..., 1:, :]}
        self.remember("middles", motion.middles, "X_WB", **places, over_time=motion.middles_over_time)

        def apparent_gravity(X_WB: Array, middles: Array) -> Array:
            return to_base(X_WB, gravity - motion.acceleration(middles))

        self.derive("apparent_gravity", apparent_gravity, "X_WB", "middles")
        self.remember(
            *("motion", motion.step, self.driving, "gravity", "apparent_gravity"),
            begin=motion.begin,
            keep=lambda motion: motion,
            over_time=partial(motion.motion_over_time, first=1),
            loops=True,
        )
        self.derive("lag", motion.lag, "motion")
        return ("lag",)

    def _derive_zeros(self, function: ShapeFunction, layout: MeasurementModel) -> tuple[str, ...]:
        """Declares the steps "zeros", "zeroed" and "std", if a function follows the zeros of its sensors.

        Returns the step with the readings that the function takes, and further ones.
        """
        zeroing = zeroing_of(function)
        if zeroing is None:
            return (layout.quantity,)
        self.remember(
            "zeros",
            lambda memory, *sample: zeroing.step(Zeros(*np.moveaxis(memory, -2, 0)), *sample),
            *(layout.quantity, self.driving, "gravity"),
            begin=np.stack(zeroing.begin(), axis=-2),
            keep=lambda zeros: np.stack(zeros, axis=-2),
            over_time=partial(zeroing.zeros_over_time, first=1),
            loops=True,
        )
        self.derive("zeroed", zeroing.correct, "zeros", layout.quantity)
        if zeroing.mechanics.uncertainty.free_pressure > 0:
            self.put_out(zeroed(layout.quantity), lambda readings: readings, "zeroed", unit=layout.unit, **layout.axes)
        self.derive("std", zeroing.std, "zeros", layout.quantity)
        return "zeroed", "std"

    def _put_out_joints(self, layout: MeasurementModel, estimate: ShapeEstimate) -> None:
        N, joints = layout.finger.segments, range(layout.finger.segments)
        for i, deformation in enumerate(layout.deformations):
            unit = "m" if deformation in SLIDES else "rad"
            self.put_out(
                f"estimated_{joints_port(deformation)}", _rows(slice(i * N, (i + 1) * N)), "q", unit=unit, joint=joints
            )
        if estimate.covariance is not None:
            self.put_out(
                "joint_angle_covariance",
                lambda shape: shape.covariance[..., :N, :N],
                "shape",
                unit="rad^2",
                joint=joints,
                other_joint=joints,
            )
        if "twist" in layout.deformations:
            self._put_out_twist(layout.deformations.index("twist") * N + np.arange(N), estimate)

    def _put_out_twist(self, joints: Any, estimate: ShapeEstimate) -> None:
        def std(shape: ShapeEstimate) -> Array:
            return np.sqrt(shape.covariance[..., joints[:, None], joints].sum(axis=(-2, -1)))  # type: ignore[index]

        self.put_out("estimated_twist", lambda q: q[..., joints].sum(axis=-1), "q", unit="rad")
        if estimate.covariance is not None:
            self.put_out("twist_std", std, "shape", unit="rad")

    def _put_out_places(self, finger: Finger, deformations: Sequence[str], estimate: ShapeEstimate) -> None:
        joints, places = range(finger.segments), Places(finger, deformations)
        put_out_places(self, finger, deformations, "q")
        self.put_out(
            "estimated_joint_positions",
            lambda places: places[0][..., :-1, :],
            "places",
            unit="m",
            joint=joints,
            xyz=XYZ,
        )
        self.put_out(TIP, lambda places: places[0][..., -1, :], "places", unit="m", xyz=XYZ)
        if estimate.covariance is not None:
            point = (*map(str, joints), "tip")
            self.derive(
                "variance",
                lambda shape: places.variance(shape.q, shape.covariance),
                "shape",
                over_time=lambda shape: map_batches(places.variance, shape.q, shape.covariance),
            )
            self.put_out(
                "position_std", lambda variance: np.sqrt(variance.sum(axis=-1)), "variance", unit="m", point=point
            )
            self.put_out(
                "tip_position_std", lambda variance: np.sqrt(variance[..., -1, :]), "variance", unit="m", xyz=XYZ
            )

    def _put_out_curve(self, sections: range, joints: range) -> None:
        if "curve" not in self.steps:
            self.derive("curve", attrgetter("curve"), "shape")
        self.put_out("theta", lambda curve: curve.theta, "curve", unit="rad", section=sections)
        self.put_out("kappa", lambda curve: curve.arcs.kappa, "curve", unit="1/m", section=sections)
        put_out_arcs(self, lambda curve: curve.arcs, "curve", section=sections)
        put_out_curve(self, "curve", joints)

    def _put_out_contact(self, contact: ContactForce) -> None:
        self.derive("contact", lambda shape: shape.contact, "shape")
        for field, (unit, axes) in CONTACT.items():
            if getattr(contact, field) is not None:
                self.put_out(contact_port(field), _field(field), "contact", unit=unit, **axes)
        if contact.vector is not None:
            self.put_out("contact_force_world", _world_force, "contact", "X_WB", unit="N", xyz=XYZ)

    def _put_out_posterior(self) -> None:
        for field, (unit, axes) in POSTERIOR.items():
            meanings = ANSWERS if field == "answer" else ()
            self.put_out(contact_port(field), _field(field), "posterior", unit=unit, meanings=meanings, **axes)


def contact_port(field: str) -> str:
    """Name of the port with a field of `ContactForce` or `ContactPosterior`."""
    return field if field.startswith("transverse") else f"contact_{field.replace('vector', 'force_vector')}"


def zeroed(quantity: str) -> str:
    """Name of the port with the readings of sensors that are zeroed while the finger is free."""
    return f"zeroed_{quantity}"


def _rows(rows: slice) -> Callable[[Array], Array]:
    return lambda q: q[..., rows]


def _field(name: str) -> Callable[[Any], Array]:
    return lambda record: getattr(record, name)


def _world_force(contact: ContactForce, X_WB: Array) -> Array:
    assert contact.vector is not None
    return rotate_from_base(X_WB, contact.vector)


def _period_of(function: object) -> float | None:
    """Period of the samples of a block around a function: its own, if it remembers or follows how a finger moves."""
    if isinstance(function, Filter):
        return function.period
    for remembers in (motion_of(function), zeroing_of(function)):
        if remembers is not None:
            return remembers.period
    return None


def straight_shape(function: ShapeFunction, layout: MeasurementModel) -> ShapeEstimate:
    """The estimate of a function for a straight finger at rest.

    Raises:
        InputError: if that is no shape of this finger, or one sample and two do not give one shape and two.
    """
    readings, driving, two_times = layout.read(layout.straight), layout.straight, np.zeros((2, 1))
    estimate = function(readings, driving, np.zeros(3))
    _check_shape(function, estimate, driving.shape)
    _check_shape(function, function(readings + two_times, driving + two_times, np.zeros((2, 3))), (2, driving.size))
    return estimate


def _check_shape(function: ShapeFunction, estimate: object, shape: tuple[int, ...]) -> None:
    name = getattr(function, "__qualname__", type(function).__name__)
    expected = f"return a ShapeEstimate whose q has the shape {shape}"
    if not isinstance(estimate, ShapeEstimate):
        raise InputError("ShapeEstimator", "function", name, f"returned {type(estimate).__name__}; {expected}, rad")
    if np.shape(estimate.q) != shape:
        mismatch = f"q has the shape {np.shape(estimate.q)} where driving has {shape}"
        raise InputError("ShapeEstimator", "function", name, f"{mismatch}; {expected}, rad")
