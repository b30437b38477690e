"""The driving torque of a finger: the torque at its joints that is known before its sensors are read.

    driving torque = torque of the pressure + memory torque of creep

What a creeping finger remembers (`fingers.creep`) follows from how it was bent, as far as that is estimated: the
internal angles go by the estimate of the sample before, held for a period. So an estimate asks for what drives the
finger, this for the estimates before, and there is no loop. Where no angle is estimated they stay as they are: a sensor
that fails for a few samples leaves no trace, and a finger that is not seen is taken to rest.

Leading axes are free; T samples, B branches of creep, N joints.
"""

from collections.abc import Callable, Sequence

import numpy as np

from soft_gripper.array_block import ArrayBlock
from soft_gripper.arrays import Array
from soft_gripper.estimators.estimate import ShapeFunction
from soft_gripper.estimators.finger_shape import ANGLES
from soft_gripper.estimators.recorded_inputs import recorded_inputs
from soft_gripper.fingers.creep import advance, memory_torque
from soft_gripper.fingers.finger import Finger
from soft_gripper.fingers.finger_parts import SLIDES

DRIVING_TORQUE = "driving_torque"


def driving_port(way: str) -> str:
    """Name of the port with the driving torque of the joints that yield in one way."""
    return DRIVING_TORQUE if way == "bending" else f"{way}_{DRIVING_TORQUE}"


_SETTLED = 1e-7  # N m, convergence tolerance of a driving torque


def internal_angles(finger: Finger, z: Array, q: Array, pressure: Array | float, period: float) -> Array:
    """Internal angles of creep a period later, (..., B, N) rad, by estimated joint angles and a pressure that are held.

    Args:
        finger: the nominal one.
        z: internal angles, (..., B, N) rad.
        q: joint angles, (..., N) rad; z of those that are not finite stays.
        pressure: in the chamber, (...) Pa.
        period: s.
    """
    held = q / finger.softening(pressure)[..., None]
    later = advance(finger.creep, z, held, held, period)
    return np.where(np.isfinite(q)[..., None, :], later, z)


def driving_torque(finger: Finger, pressure: Array, z: Array) -> Array:
    """Torque of a chamber's pressure, (...) Pa, and of internal angles of creep, (..., B, N) rad; (..., N) N m."""
    torque = finger.pressure_torque(pressure)
    return torque + memory_torque(finger, z, pressure) if finger.creep else torque


def driving_torques(finger: Finger, q: Array, pressure: Array, period: float) -> Array:
    """The driving torque at every sample of a recording, (T, ..., N) N m; the finger begins straight.

    Args:
        finger: the nominal one.
        q: joint angles, (T, ..., N) rad, each held for a period.
        pressure: in the chamber, (T, ...) Pa, likewise.
        period: of the samples, s.
    """
    torques, z = np.zeros_like(q), np.zeros((*q.shape[1:-1], len(finger.creep), q.shape[-1]))
    for i, (angles, inside) in enumerate(zip(q, pressure, strict=True)):
        torques[i] = driving_torque(finger, inside, z)
        z = internal_angles(finger, z, angles, inside, period)
    return torques


def recorded_driving(
    function: ShapeFunction,
    finger: Finger,
    readings: Array,
    pressure: Array,
    gravity: Array,
    period: float,
    pull: Array | None = None,
) -> Array:
    """The driving torque over a recording, N m, (T, ..., N), as DrivingTorque computes it next to an estimator.

    Shape and memory are found by turns, all samples at once. A sample depends on those before it alone, and every turn
    leaves of an error no more than the shares of the branches, so that this ends.

    Args:
        function: the estimator.
        finger: the nominal one.
        readings: of the strain sensors, (T, ..., paths * S).
        pressure: in the chamber, Pa, (T, ...).
        gravity: in B, m/s^2, (T, ..., 3).
        period: of the samples, s.
        pull: gravity less the acceleration of the base, likewise; None: the base is at rest.
    """
    driving, settled = finger.pressure_torque(pressure), not finger.creep
    while not settled:
        q, before = function(*recorded_inputs(function, readings, driving, gravity, pull)).q, driving
        driving = driving_torques(finger, q, pressure, period)
        settled = np.allclose(driving, before, rtol=0, atol=_SETTLED, equal_nan=True)
    return driving


class DrivingTorque(ArrayBlock):
    """The driving torque of one finger, sample by sample.

    ::

        pressure (C) Pa ------------------> +---------------+
        tension (T) N --------------------> | DrivingTorque | ---> driving_torque  (N) N m, positive closes
        estimated_joint_angles (N) rad ---> +---------------+

    and the torques of `others`, such as `sideways_driving_torque` (N) N m, where an estimator in space takes them.
    C chambers and T tendons, if there are any; of tendons without friction. Only a finger that creeps has its estimated
    joint angles for an input, and state. They act from the next sample on, so they may be estimated from this very
    torque. Give it inputs that are sampled together every `period` s, from time 0, in discrete state.
    """

    def __init__(self, finger: Finger, period: float, others: Sequence[str] = ()):
        """The nominal finger; it begins straight. `others` are further ways in which it is driven, beside bending."""
        super().__init__(period if finger.creep else None)
        joints, sizes = finger.segments, {"pressure": finger.pressures, "tension": len(finger.tendons)}
        driving = [kind for kind, size in sizes.items() if size]
        for kind in driving:
            self.take(kind, sizes[kind])

        chambers = () if finger.pressures else (np.zeros(0),)  # Tendons alone drive it.

        def of(way: str) -> Callable[..., Array]:
            return lambda *efforts: finger.torque_of_drive(way, *chambers, *efforts)

        def with_memory(*found: Array) -> Array:
            *efforts, z = found
            memory = memory_torque(finger, z, _softening_pressure(finger, *efforts))
            return finger.torque_of_drive("bending", *chambers, *efforts) + memory

        if finger.creep:
            self.take(ANGLES, joints)
            softens = driving[:1] if finger.pressure_law is not None else []
            self.remember(
                *("internal angles", lambda z: z),
                begin=np.zeros((len(finger.creep), joints)),
                keep=lambda z, q, *pressure: internal_angles(
                    finger, z, q, _softening_pressure(finger, *pressure), period
                ),
                kept=(ANGLES, *softens),
            )
        torque, memories = (with_memory, ["internal angles"]) if finger.creep else (of("bending"), [])
        self.put_out(DRIVING_TORQUE, torque, *driving, *memories, unit="N m", joint=range(joints))
        for way in others:
            self.put_out(
                driving_port(way), of(way), *driving, unit="N" if way in SLIDES else "N m", joint=range(joints)
            )


def _softening_pressure(finger: Finger, *pressure: Array) -> Array | float:
    """Pressure that the softening of a finger follows, Pa: that of its one chamber, (..., 1), if it has a law."""
    return 0.0 if finger.pressure_law is None else pressure[0][..., 0]
