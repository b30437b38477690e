"""Measures of a grasp: pure functions over the signals of one object in a recording of T samples, with F fingers.

A grasp is judged at the end of the signals: forces, areas and pressures are means over the last WINDOW. The ground
truth is that of the plant (`TrueContact`), sampled with the sensors.

Another measure is a field of `Grasp`, which sweeps and tables follow, and its value in `judge`.
"""

from dataclasses import dataclass, fields
from typing import Annotated, NamedTuple

import numpy as np
from numpy.typing import NDArray

from soft_gripper.arrays import Array
from soft_gripper.truth.contact import TOUCH

WINDOW = 0.5  # s at the end, over which a grasp is judged
IMPULSE_TIME = 0.05  # s, over which a force is summed up to an impulse
SLIDES = 1e-3  # m/s on the fingers, above which an object slips
SUPPORTED = 0.1  # share of its weight that counts as nothing, whether other bodies carry it or the fingers
NEVER_TOUCHED, DROPPED, SLIPPING, RESTING, HELD = "never touched", "dropped", "slipping", "resting", "held"
_LEAST_CORRELATION = 0.5  # share of the variance of the force that a stiffness must explain
NAN = float("nan")


class GraspSignals(NamedTuple):
    """The signals of one object; positions of a point are in the frame of the palm, B of its first finger."""

    time: Array  # (T,) s
    normal: Array  # (T, F) N
    friction: Array  # (T, F, 3) N on the object
    area: Array  # (T, F) m^2
    pressure: Array  # (T, F) Pa, largest
    support: Array  # (T,) N, upward force of all other bodies on the object
    place: Array  # (T, 3) m, of the object
    turn: Array  # (T, 3, 3) rotation of the object
    weight: float  # N
    coefficients: Array  # (F,) of friction between each finger and the object


@dataclass(frozen=True)
class FingerGrip:
    """Grip of one finger on an object: means over the window at the end, and the largest impulse of all.

    largest_impulse_mns: the largest integral of the normal force over IMPULSE_TIME.
    """

    finger: str
    normal_force_n: Annotated[float, ".3f"]
    friction_force_n: Annotated[float, ".3f"]
    contact_area_mm2: Annotated[float, ".1f"]
    mean_pressure_kpa: Annotated[float, ".1f"]
    largest_pressure_kpa: Annotated[float, ".1f"]
    largest_impulse_mns: Annotated[float, ".1f"]


@dataclass(frozen=True)
class Grasp:
    """A grasp of one object; NaN where there is nothing to measure.

    grasp: "held", if it does not slide and the fingers carry its weight, or a part of it with friction for all, see
        `is_carried`; "resting", if it needs other bodies; "slipping", "dropped" or "never touched".
    normal_force_n, friction_force_n: held force of the finger that presses most.
    slip_ratio: the least force that would hold the object over the force of the grasp; at 1 it slips, see `slip_ratio`.
    least_force_n: that least force, of the finger that presses most.
    contact_area_mm2: of all fingers; the mean pressure is the normal forces over it.
    largest_impulse_mns: see FingerGrip; of the finger that has the largest.
    slid_mm: length of its path along the fingers while held, see `held_since`; creep adds to it.
    moved_mm, turned_deg: largest change of the object's pose in the palm while held.
    sideways_play_mm: range of its motion across the bending plane of the first finger while held.
    true_width_mm: of the object, between the contacts of all fingers at the end.
    estimated_stiffness_n_m: of the object, from the sensors; see `stiffness`.
    pump_energy_mj: work of the pressure on the fingers up to the end, see `pump_energy`.
    """

    grasp: str
    normal_force_n: float
    friction_force_n: float
    slip_ratio: float
    least_force_n: float
    contact_area_mm2: float
    mean_pressure_kpa: float
    largest_pressure_kpa: float
    largest_impulse_mns: float
    slid_mm: float
    moved_mm: float
    turned_deg: float
    sideways_play_mm: float
    true_width_mm: float
    estimated_stiffness_n_m: float
    pump_energy_mj: float


UNKNOWN = Grasp("", *[NAN] * (len(fields(Grasp)) - 1))  # there is no recording


def last(time: Array) -> NDArray[np.bool_]:
    """The samples of the window at the end, (T)."""
    return time > time[-1] - WINDOW


def held_since(signals: GraspSignals) -> int:
    """The sample since which the fingers alone hold the object; at the latest the beginning of the window."""
    is_lifted = (signals.normal.sum(axis=1) > TOUCH) & (signals.support <= SUPPORTED * signals.weight)
    unlifted_samples = np.flatnonzero(~is_lifted)
    begin = int(unlifted_samples[-1]) + 1 if len(unlifted_samples) else 0
    return min(begin, int(np.argmax(last(signals.time))))


def verdict(signals: GraspSignals, speed: float) -> str:
    """State of an object at the end: held, resting, slipping, dropped or never touched.

    `speed`, at which it slides on the fingers over the window, m/s, is NaN if they do not touch it at its beginning.
    """
    touches = signals.normal.sum(axis=1) > TOUCH
    if not touches.any():
        return NEVER_TOUCHED
    if not touches[-1]:
        return DROPPED
    if not speed <= SLIDES:
        return SLIPPING
    return HELD if is_carried(signals) else RESTING


def is_carried(signals: GraspSignals) -> bool:
    """Whether the fingers carry an object at the end, or would without the other bodies that it touches.

    An object that creeps in the grasp, as friction that is regularised in time steps lets it, comes down on a table,
    which then carries a part of its weight. It is still held if the fingers carry some of it, and by Coulomb's law have
    friction for all of it. What they only press down, or squeeze with less, is not.
    """
    window = last(signals.time)
    support, normal = signals.support[window].mean(), signals.normal[window].mean(axis=0)
    if support <= SUPPORTED * signals.weight:
        return True
    has_friction = float(signals.coefficients @ normal) > signals.weight
    return bool(has_friction and support <= (1 - SUPPORTED) * signals.weight)


def slip_ratio(normal: Array, friction: Array, coefficients: Array) -> float:
    """The least force that would hold an object over the force of the grasp, from held forces, (F,) and (F, 3) N.

    Friction forces of several fingers that oppose each other do not carry anything, and would be less if the fingers
    pressed less. Their sum is what has to be carried; by Coulomb's law it takes at least that sum over the coefficient
    of friction, (F,).
    """
    max_friction = float(coefficients @ normal)
    return float(np.linalg.norm(friction.sum(axis=0))) / max_friction if max_friction > 0 else NAN


def largest_impulse(time: Array, force: Array) -> float:
    """The largest integral of a force over IMPULSE_TIME, N s; (T,) s and (T,) N.

    Over any shorter time a force in a discrete simulation depends on the time step: a collision ends within one step.
    """
    if len(time) < 2:
        return 0.0
    total = np.concatenate([[0.0], np.cumsum((force[1:] + force[:-1]) / 2 * np.diff(time))])
    ends = np.interp(time + IMPULSE_TIME, time, total)
    return float((ends - total).max())


def pump_energy(pressure: Array, volume: Array) -> float:
    """Work of pressures on the walls of their chambers, J: the integral of pressure over volume where it grows.

    Pressures, (T, C) Pa, are relative to the atmosphere; `volume` is that by which each chamber has grown, (T, C) m^3.
    What flows back as the volume shrinks is vented. The compression of the gas itself is extra.
    """
    work = (pressure[1:] + pressure[:-1]) / 2 * np.diff(volume, axis=0)
    return float(np.maximum(work, 0.0).sum())


def stiffness(width: Array, force: Array) -> float:
    """Stiffness of a held object, N/m: the slope of the estimated force over the decrease of the estimated width.

    Taken by least squares over the samples of more than a tenth of the largest force: (T,) m, NaN without contact, and
    the mean of the fingers, (T,) N. NaN if the width does not decrease as the force grows, or explains less than half
    of its variance: then the object is too stiff for the sensors.
    """
    is_known = np.isfinite(width) & np.isfinite(force)
    is_known &= force > 0.1 * np.max(force[is_known], initial=0.0)
    if is_known.sum() < 3 or np.ptp(width[is_known]) == 0:
        return NAN
    w, f = (values[is_known] - values[is_known].mean() for values in (width, force))
    slope = -float(w @ f) / float(w @ w)
    return slope if slope > 0 and slope * -float(w @ f) > _LEAST_CORRELATION * float(f @ f) else NAN


def finger_grips(signals: GraspSignals, fingers: list[str]) -> list[FingerGrip]:
    """Grip of each finger on the object."""
    window = last(signals.time)
    normal, area, pressure = (
        values[window].mean(axis=0) for values in (signals.normal, signals.area, signals.pressure)
    )
    friction = np.linalg.norm(signals.friction[window].mean(axis=0), axis=-1)
    return [
        FingerGrip(
            finger,
            normal_force_n=float(normal[i]),
            friction_force_n=float(friction[i]),
            contact_area_mm2=1e6 * float(area[i]),
            mean_pressure_kpa=1e-3 * _ratio(float(normal[i]), float(area[i])),
            largest_pressure_kpa=1e-3 * float(pressure[i]),
            largest_impulse_mns=1e3 * largest_impulse(signals.time, signals.normal[:, i]),
        )
        for i, finger in enumerate(fingers)
    ]


def motion(place: Array, turn: Array) -> tuple[float, float, float]:
    """Largest shift, m, and turn, rad, from the first of some poses, (K, 3) m and (K, 3, 3), and range of y, m."""
    relative = np.swapaxes(turn[:1], -1, -2) @ turn
    cosine = (np.trace(relative, axis1=-2, axis2=-1) - 1) / 2
    shift = np.linalg.norm(place - place[0], axis=-1).max()
    return float(shift), float(np.arccos(np.clip(cosine, -1, 1)).max()), float(np.ptp(place[:, 1]))


class Sizes(NamedTuple):
    """True width, m, and estimated stiffness, N/m, of an object; NaN if that is not known."""

    true_width: float = NAN
    stiffness: float = NAN


def judge(
    signals: GraspSignals, grips: list[FingerGrip], slid_length: float, speed: float, sizes: Sizes, energy: float
) -> Grasp:
    """The grasp of one object.

    `slid_length` is that of its path along the fingers while held, m, NaN without contact; `speed` that at which it
    slides at the end, m/s; `energy` that of the pump, J.
    """
    window, begin = last(signals.time), held_since(signals)
    normal, friction = signals.normal[window].mean(axis=0), signals.friction[window].mean(axis=0)
    highest, word = grips[int(np.argmax(normal))], verdict(signals, speed)
    ratio = slip_ratio(normal, friction, signals.coefficients)
    is_gripped = word in (SLIPPING, RESTING, HELD)
    shift, rotation, play = motion(signals.place[begin:], signals.turn[begin:]) if is_gripped else (NAN, NAN, NAN)
    area = sum(grip.contact_area_mm2 for grip in grips)
    return Grasp(
        grasp=word,
        normal_force_n=highest.normal_force_n,
        friction_force_n=highest.friction_force_n,
        slip_ratio=ratio,
        least_force_n=ratio * highest.normal_force_n,
        contact_area_mm2=area,
        mean_pressure_kpa=1e3 * _ratio(float(normal.sum()), area),
        largest_pressure_kpa=max(grip.largest_pressure_kpa for grip in grips),
        largest_impulse_mns=max(grip.largest_impulse_mns for grip in grips),
        slid_mm=1e3 * slid_length,
        moved_mm=1e3 * shift,
        turned_deg=float(np.degrees(rotation)),
        sideways_play_mm=1e3 * play,
        true_width_mm=1e3 * sizes.true_width,
        estimated_stiffness_n_m=sizes.stiffness,
        pump_energy_mj=1e3 * energy,
    )


def _ratio(value: float, divisor: float) -> float:
    """Ratio; NaN where the divisor is zero or unknown."""
    return value / divisor if divisor else NAN
