"""Driving torque of a finger: the torque at its joints known before its sensors are read, (..., N) N m.

    driving torque = torque of the pressure + torque of the stiffness lost to pressure + memory torque of creep

The memory of a creeping finger (`fingers.creep`), and the stiffness that a bent one loses to pressure
(`fingers.taken_stiffness`), follow from its estimated bend: the estimate of the previous sample, constant for a period.
So an estimate needs the driving torque, this the previous estimate, and there is no loop. Where no angle is estimated
the bend stays: a sensor that fails for a few samples leaves no trace, and an unseen finger is taken to rest. Before the
first estimate it is taken to bend freely, without creep.

Leading axes are free; T samples, B branches of creep, N joints. A bend is the B internal angles and, last, the joint
angles, (..., B + 1, N) rad.
"""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from soft_gripper.array_block import ArrayBlock
from soft_gripper.arrays import Array
from soft_gripper.estimators.estimate import ShapeFunction
from soft_gripper.estimators.finger_shape import ANGLES
from soft_gripper.estimators.free_motion import recorded_lag
from soft_gripper.estimators.zeroing import recorded_zeros
from soft_gripper.fingers.creep import advance, memory_torque
from soft_gripper.fingers.finger import Finger
from soft_gripper.fingers.finger_parts import SLIDES
from soft_gripper.fingers.statics import free_bending_angles
from soft_gripper.fingers.taken_stiffness import taken_torque

DRIVING_TORQUE = "driving_torque"


def driving_port(deformation: str) -> str:
    """Name of the port with the driving torque of the joints of one deformation."""
    return DRIVING_TORQUE if deformation == "bending" else f"{deformation}_{DRIVING_TORQUE}"


_TORQUE_TOLERANCE = 1e-7  # N m, convergence tolerance


def later_bend(finger: Finger, bend: Array, q: Array, pressure: Array | float, period: float) -> Array:
    """The bend a period later, (..., B + 1, N) rad, by estimated joint angles and a pressure that are held.

    Args:
        finger: the nominal one.
        bend: (..., B + 1, N) rad.
        q: joint angles, (..., N) rad; the bend of those that are not finite stays.
        pressure: in the chamber, (...) Pa; without it the bend stays, if there is a pressure law.
        period: s.
    """
    effective = q / finger.softening(pressure)[..., None]
    branch_bend = advance(finger.creep, bend[..., :-1, :], effective, effective, period)
    next_bend = np.concatenate([branch_bend, q[..., None, :]], axis=-2)
    return np.where(np.isfinite(effective)[..., None, :], next_bend, bend)


def driving_torque(finger: Finger, pressure: Array, bend: Array) -> Array:
    """Torque of a chamber's pressure, (...) Pa, on a finger of some bend, (..., B + 1, N) rad; (..., N) N m."""
    return finger.pressure_torque(pressure) + torque_of_bend(finger, pressure, bend)


def torque_of_bend(finger: Finger, pressure: Array | float, bend: Array) -> Array:
    """Torque that a bend, (..., B + 1, N) rad, adds at a pressure, (...) Pa; (..., N) N m."""
    memory = memory_torque(finger, bend[..., :-1, :], pressure)
    if not finger.takes_stiffness:
        return memory
    q, q_free = bend[..., -1, :], free_bending_angles(finger, np.asarray(pressure))
    return memory + taken_torque(finger, np.where(np.isnan(q), q_free, q), pressure)


def unknown_bend(finger: Finger, shape: Sequence[int] = ()) -> Array:
    """Bend before the first estimate, (*shape, B + 1, N) rad: no creep, and unknown joint angles.

    The finger is then taken to bend freely: from straight, an estimator of a finger near ballooning would take the
    stiffness lost to pressure for a load, and might not recover.
    """
    bend: Array = np.zeros((*shape, len(finger.creep) + 1, finger.segments))
    bend[..., -1, :] = np.nan
    return bend


def depends_on_bend(finger: Finger) -> bool:
    """Whether what drives a finger depends on how it was bent."""
    return bool(finger.creep) or finger.takes_stiffness


def driving_torques(finger: Finger, q: Array, pressure: Array, period: float) -> Array:
    """The driving torque at every sample of a recording, (T, ..., N) N m.

    Args:
        finger: the nominal one; nothing of it has crept.
        q: joint angles, (T, ..., N) rad, each held for a period.
        pressure: in the chamber, (T, ...) Pa, likewise.
        period: of the samples, s.
    """
    torques, bend = np.zeros_like(q), unknown_bend(finger, q.shape[1:-1])
    for i, (angles, chamber_pressure) in enumerate(zip(q, pressure, strict=True)):
        torques[i] = driving_torque(finger, chamber_pressure, bend)
        bend = later_bend(finger, bend, angles, chamber_pressure, period)
    return torques


def recorded_driving(
    function: ShapeFunction,
    finger: Finger,
    readings: Array,
    pressure: Array,
    gravity: Array,
    period: float,
    apparent_gravity: Array | None = None,
) -> Array:
    """The driving torque over a recording, N m, (T, ..., N), as DrivingTorque computes it next to an estimator.

    Shape and bend are computed in turn, all samples at once. A sample depends only on those before it, and every
    iteration reduces an error at least to the fractions of creep and pressure, so it converges.

    Args:
        function: the estimator.
        finger: the nominal one.
        readings: of the strain sensors, (T, ..., paths * S).
        pressure: in the chamber, Pa, (T, ...).
        gravity: in B, m/s^2, (T, ..., 3).
        period: of the samples, s.
        apparent_gravity: gravity less the acceleration of the base, likewise; None: the base is at rest.
    """
    driving, is_settled = finger.pressure_torque(pressure), not depends_on_bend(finger)
    while not is_settled:
        q = function(*recorded_inputs(function, readings, driving, gravity, apparent_gravity)).q
        last_driving = driving
        driving = driving_torques(finger, q, pressure, period)
        is_settled = np.allclose(driving, last_driving, rtol=0, atol=_TORQUE_TOLERANCE, equal_nan=True)
    return driving


class DrivingTorque(ArrayBlock):
    """The driving torque of one finger, sample by sample.

    ::

        pressure (C) Pa ------------------> +---------------+
        tension (T) N --------------------> | DrivingTorque | ---> driving_torque  (N) N m, positive closes
        estimated_joint_angles (N) rad ---> +---------------+

    and the torques of `others`, such as `sideways_driving_torque` (N) N m, where an estimator in space takes them.
    C chambers and T tendons, if there are any; of tendons without friction. Only a finger that creeps, or of whose
    stiffness pressure takes a part, has its estimated joint angles for an input, and state. They act from the next
    sample on, so they may be estimated from this very torque. Give it inputs that are sampled together every `period`
    s, from time 0, in discrete state.
    """

    def __init__(self, finger: Finger, period: float, deformations: Sequence[str] = ()):
        """The nominal finger; nothing of it has crept. `deformations` are further driven deformations."""
        bends = depends_on_bend(finger)
        super().__init__(period if bends else None)
        joints, sizes = finger.segments, {"pressure": finger.pressures, "tension": len(finger.tendons)}
        driving = [kind for kind, size in sizes.items() if size]
        for kind in driving:
            self.take(kind, sizes[kind])

        chambers = () if finger.pressures else (np.zeros(0),)  # Tendons alone drive it.

        def drive_torque(deformation: str) -> Callable[..., Array]:
            return lambda *efforts: finger.torque_of_drive(deformation, *chambers, *efforts)

        def torque_with_bend(*inputs: Array) -> Array:
            *efforts, bend = inputs
            return drive_torque("bending")(*efforts) + torque_of_bend(finger, _pressure_of_law(finger, *efforts), bend)

        if bends:
            self.take(ANGLES, joints)
            self.remember(
                *("bend", lambda bend: bend),
                begin=unknown_bend(finger),
                keep=lambda bend, q, *pressure: later_bend(
                    finger, bend, q, _pressure_of_law(finger, *pressure), period
                ),
                kept=(ANGLES, *(driving[:1] if finger.pressure_law is not None else [])),
            )
        torque, remembered = (torque_with_bend, ["bend"]) if bends else (drive_torque("bending"), [])
        self.put_out(DRIVING_TORQUE, torque, *driving, *remembered, unit="N m", joint=range(joints))
        for deformation in deformations:
            unit = "N" if deformation in SLIDES else "N m"
            port, torque = driving_port(deformation), drive_torque(deformation)
            self.put_out(port, torque, *driving, unit=unit, joint=range(joints))


def _pressure_of_law(finger: Finger, *pressure: Array) -> Array | float:
    """Input of the pressure law, Pa: the pressure of the one chamber of a finger, (..., 1), if it has a law."""
    return 0.0 if finger.pressure_law is None else pressure[0][..., 0]


def recorded_inputs(
    function: object, readings: Array, driving: Array, gravity: Array, apparent_gravity: Array | None = None
) -> tuple[Any, ...]:
    """The arguments of an estimator at all samples of a recording, as `ShapeEstimator` gives them one by one.

    Args:
        function: the estimator.
        readings: of its sensors, (T, ..., R).
        driving: torque, (T, ..., D) N m.
        gravity: in B, (T, ..., 3) m/s^2.
        apparent_gravity: gravity less the acceleration of the base, likewise; None: the base is at rest.
    """
    gravity = np.broadcast_to(gravity, (*driving.shape[:-1], 3))
    lag = recorded_lag(function, driving, gravity, gravity if apparent_gravity is None else apparent_gravity)
    zeroed, std = recorded_zeros(function, readings, driving, gravity)
    return zeroed, driving, gravity, *lag, *std
