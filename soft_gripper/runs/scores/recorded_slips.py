"""Slips of the objects in a recording, with their causes; see `slipping`."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from soft_gripper.diagrams.recording import Recording
from soft_gripper.diagrams.station_parts import Station
from soft_gripper.runs.scores.grasp import NAN, slip_ratio
from soft_gripper.runs.scores.recorded_grasps import OfObject, objects_of
from soft_gripper.runs.scores.recorded_object import RecordedObject, finger_friction
from soft_gripper.runs.scores.slipping import (
    RESTS,
    WILL_HOLD,
    WILL_SLIP,
    Slip,
    has_settled,
    held_span,
    object_friction,
    preceding_window,
    sliding_since,
    weight_share,
)


@dataclass(frozen=True)
class ObjectSlip(Slip, OfObject):
    """Slip of a named object, and its cause."""


def recorded_slips(station: Station, recording: Recording) -> list[ObjectSlip]:
    """A row for each object."""
    objects = [RecordedObject(station, recording, name) for name in objects_of(station)]
    return [ObjectSlip(item.name, **vars(recorded_slip(item))) for item in objects]


def recorded_slip(item: RecordedObject) -> Slip:
    """Finds the cause of an object's slip, and predicts the slip from the forces before the lift."""
    station, samples, signals = item.station, item.samples, item.signals
    span = held_span(signals.time, signals.normal.sum(axis=1))
    if span is None:
        return Slip()
    begin, end = span
    prediction = _predicted(item, begin)
    loss_time = float(signals.time[end]) if end < len(samples) else NAN
    slides = _sliding(item, samples[:end], begin)
    if slides is None:
        return replace(prediction, lost_s=loss_time)
    since, sliding_fingers = slides
    window = preceding_window(signals.time, since)
    normal, friction = signals.normal[window].mean(axis=0), signals.friction[window].mean(axis=0)
    share = weight_share(normal, signals.coefficients, signals.weight)
    names = [finger.name for finger in station.fingers]
    weakest = int(np.argmin(signals.coefficients))
    friction_now, force = float(signals.coefficients[weakest]), float(normal.mean())
    return replace(
        prediction,
        slips_s=float(signals.time[since]),
        slips_in=_phase(item, int(samples[since])),
        slips_on=" and ".join(name for name, slips in zip(names, sliding_fingers, strict=True) if slips),
        lost_s=loss_time,
        used_share=slip_ratio(normal, friction, signals.coefficients),
        present_friction=friction_now,
        least_friction=share * friction_now,
        least_object_friction=object_friction(share * friction_now, finger_friction(station, station.fingers[weakest])),
        present_force_n=force,
        needed_force_n=share * force,
    )


def _sliding(item: RecordedObject, samples: NDArray[np.int_], begin: int) -> tuple[int, NDArray[np.bool_]] | None:
    """`sliding_since` from `begin` to the last of some samples; it looks back only as far as the object slides."""
    time, reach = item.recording.values("time")[samples], 2 * RESTS
    while True:
        first = max(begin, int(np.searchsorted(time, time[-1] - reach)))
        slides = sliding_since(time[first:], item.sliding_speeds(samples[first:]))
        if slides is None:
            return None
        since = first + slides[0]
        if first == begin or time[since] - time[first] > RESTS:
            return since, slides[1]
        reach *= 2


def _predicted(item: RecordedObject, touch: int) -> Slip:
    """The prediction from the forces before an object is lifted.

    They are those at the end of the phase before the first that holds it; without phases that hold it,
    those at the end of the phase of the first touch.
    """
    task, signals = item.station.task, item.signals
    if task is None:
        return Slip()
    numbers = item.phases[item.samples]
    holds = [number for number, phase in enumerate(task.phases) if phase.holds]
    lifts = np.flatnonzero(np.isin(numbers, holds) if holds else numbers > numbers[touch])
    if not len(lifts) or lifts[0] <= touch:
        return Slip()
    normal = signals.normal[preceding_window(signals.time, int(lifts[0]))]
    if not has_settled(normal @ signals.coefficients):
        return Slip()
    share = weight_share(normal.mean(axis=0), signals.coefficients, signals.weight)
    return Slip(WILL_HOLD if share < 1 else WILL_SLIP, share)


def _phase(item: RecordedObject, sample: int) -> str:
    """The name of the phase of a sample; "" without a task, and after its end."""
    if item.station.task is None:
        return ""
    phase_index, phases = int(item.phases[sample]), item.station.task.phases
    return phases[phase_index].name if phase_index < len(phases) else ""
