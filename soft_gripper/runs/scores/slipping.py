"""Causes of an object's slip: pure functions over the signals of one grasp, see `GraspSignals`.

By Coulomb's law the fingers carry at most the sum of their normal forces times their coefficients of friction: the
friction that is available. The share of it that is used is the margin to slip; before an object is lifted, the share
that its weight would use predicts whether it will be held.
"""

from dataclasses import dataclass
from typing import Annotated

import numpy as np
from numpy.typing import NDArray

from soft_gripper.arrays import Array
from soft_gripper.runs.scores.grasp import HELD, NAN, RESTING, SLIDES, WINDOW
from soft_gripper.truth.contact import TOUCH

LET_GO = 0.1  # s without a touch, after which an object is lost; shorter ones are bounces
STEADY = 0.05  # share by which a settled force changes in half of the WINDOW
RESTS = 0.2  # s without sliding, after which a slide is another one; it sticks and slips
_SMOOTH = 0.05  # s, over which the speed at which it slides is averaged
WILL_HOLD, WILL_SLIP = "will be held", "will slip"


@dataclass(frozen=True)
class Slip:
    """Slip of an object and its cause; NaN and "" where there is none.

    predicted: "will be held" if before it is lifted the friction available exceeds its weight, else "will slip"; "" if
        the grip has not settled by then.
    weight_share: its weight over the friction available before it is lifted; above 1 it will slip.
    slips_s, slips_in, slips_on: since when it slides until it is lost, or to the end: time, phase, and the fingers.
    lost_s: when no finger touches it any more.
    used_share: friction used over that available, in the half second before it slides.
    present_friction, least_friction: the smallest coefficient of friction of a finger, and the one that would carry
        its weight with the normal forces of that half second.
    least_object_friction: the friction of the object that gives that coefficient; infinite if none does.
    present_force_n, needed_force_n: the mean normal force of a finger in it, and the one that would carry the weight.
    """

    predicted: str = ""
    weight_share: Annotated[float, ".2f"] = NAN
    slips_s: Annotated[float, ".2f"] = NAN
    slips_in: str = ""
    slips_on: str = ""
    lost_s: Annotated[float, ".2f"] = NAN
    used_share: Annotated[float, ".2f"] = NAN
    present_friction: Annotated[float, ".2f"] = NAN
    least_friction: Annotated[float, ".2f"] = NAN
    least_object_friction: Annotated[float, ".2f"] = NAN
    present_force_n: Annotated[float, ".2f"] = NAN
    needed_force_n: Annotated[float, ".2f"] = NAN


def as_predicted(predicted: str, grasp: str) -> bool:
    """Whether an object is held, or not, as was predicted."""
    return (predicted == WILL_HOLD) == (grasp in (HELD, RESTING))


def weight_share(normal: Array, coefficients: Array, weight: float) -> float:
    """The weight of an object over the friction available, from mean normal forces (F,) N; infinite without any."""
    max_friction = float(coefficients @ normal)
    return weight / max_friction if max_friction > 0 else np.inf


def object_friction(coefficient: float, finger: float) -> float:
    """Friction of an object that combines with a finger's friction to a coefficient; infinite if none does.

    The inverse of `combined_friction`, which stays below twice the friction of the finger.
    """
    return coefficient * finger / (2 * finger - coefficient) if coefficient < 2 * finger else np.inf


def has_settled(force: Array) -> bool:
    """Whether the mean of a force (K,) in the second half of its samples is that in the first, within STEADY."""
    early_force, late_force = (float(half.mean()) for half in np.array_split(force, 2))
    return abs(late_force - early_force) <= STEADY * max(early_force, late_force)


def held_span(time: Array, normal: Array) -> tuple[int, int] | None:
    """The first touch, and the sample after the last touch before the object is lost; None: it is never touched.

    An object is lost when no finger touches it for LET_GO; what touches it later does not hold it. `normal` is the
    force of all fingers, (T,) N, at times (T,) s.
    """
    touched_samples = np.flatnonzero(normal > TOUCH)
    if not len(touched_samples):
        return None
    gaps = np.flatnonzero(np.diff(time[touched_samples], append=time[-1]) > LET_GO)
    return int(touched_samples[0]), int(touched_samples[gaps[0]]) + 1 if len(gaps) else len(time)


def sliding_since(time: Array, speed: Array) -> tuple[int, NDArray[np.bool_]] | None:
    """The sample since which an object slides to the end of the signals, and the fingers on which it then does.

    None if it does not slide at the end. `speed` is that on each finger, (K, F) m/s, at times (K,) s; NaN without
    contact.
    """
    reach = max(round(_SMOOTH / (time[1] - time[0])), 1) if len(time) > 1 else 1
    kernel, is_known = np.ones(reach), np.isfinite(speed)
    sums, counts = (
        np.apply_along_axis(np.convolve, 0, values, kernel, "same")[: len(time)]
        for values in (np.where(is_known, speed, 0.0), is_known.astype(float))
    )
    slides = sums > SLIDES * np.maximum(counts, 1.0)
    sliding_samples = np.flatnonzero(slides.any(axis=1))
    if not len(sliding_samples) or time[-1] - time[sliding_samples[-1]] > RESTS:
        return None
    rests = np.flatnonzero(np.diff(time[sliding_samples]) > RESTS)
    begin = int(sliding_samples[rests[-1] + 1 if len(rests) else 0])
    return begin, slides[begin]


def preceding_window(time: Array, sample: int) -> slice:
    """The samples of the WINDOW before a sample, of times (T,) s; at least one."""
    return slice(int(np.searchsorted(time, time[sample] - WINDOW)), max(sample, 1))
