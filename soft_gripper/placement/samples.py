"""Fingers at rest with all sensors that they could have, and what an estimator makes of a placement of these.

The readings of every section that a finger could have, so that each placement only picks its own.

What a sensor reads depends on where its section begins and ends, not on the others. So all spans of whole segments are
read, and disturbed, once; placements that share a section share its errors, and differ by what they are, not by luck.

T samples, N segments, M = N (N + 1) / 2 spans.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from soft_gripper.arrays import Array, Planar
from soft_gripper.estimators.driving_torque import driving_torques
from soft_gripper.estimators.estimate import ShapeEstimate
from soft_gripper.evaluation.contacts.dataset import Contacts
from soft_gripper.fingers.finger import Finger
from soft_gripper.placement.assumptions import Assumptions
from soft_gripper.placement.held_finger import HeldFinger
from soft_gripper.placement.placements import Placement, as_borders
from soft_gripper.runs.estimator_functions import estimator_function
from soft_gripper.sensors.sensor_layout import SensorLayout, extension_ratios
from soft_gripper.sensors.strain_errors import StrainErrors, disturb


class SpanRatios(NamedTuple):
    """Extension ratios of all spans."""

    ratios: Array  # (..., paths, M)
    segments: int

    def of(self, placement: Placement) -> Array:
        """Those of the sections of a placement, in the order of readings, (..., paths * S)."""
        ends = np.array([0, *placement, self.segments])
        chosen = self.ratios[..., _span_numbers(self.segments)[ends[:-1], ends[1:]]]
        return chosen.reshape(*chosen.shape[:-2], -1)


def span_ratios(segment_sensors: SensorLayout, q: Array) -> SpanRatios:
    """Of ideal sensors, from joint angles (..., N) rad; `segment_sensors` has a section for every segment."""
    segments = segment_sensors.sections
    by_segment = extension_ratios(segment_sensors, q).reshape(*q.shape[:-1], segment_sensors.paths, segments)
    up_to = np.concatenate([np.zeros_like(by_segment[..., :1]), by_segment.cumsum(axis=-1)], axis=-1)
    begin, end = _spans(segments)
    return SpanRatios((up_to[..., end] - up_to[..., begin]) / (end - begin), segments)


def disturbed(
    ideal: SpanRatios, errors: StrainErrors, period: float, seeds: int, rng: np.random.Generator
) -> SpanRatios:
    """The ratios (T, ..., paths, M) as `seeds` sets of sensors with errors give them, (T, ..., seeds, paths, M)."""
    *leading, paths, spans = ideal.ratios.shape
    repeated = np.broadcast_to(ideal.ratios[..., None, :, :], (*leading, seeds, paths, spans))
    flat = repeated.reshape(*leading, seeds, paths * spans)
    return SpanRatios(disturb(errors, flat, period, rng).reshape(repeated.shape), ideal.segments)


def _spans(segments: int) -> tuple[NDArray[np.int_], NDArray[np.int_]]:
    """Where every span begins and ends, each (M)."""
    begin, end = np.triu_indices(segments + 1, 1)
    return begin, end


def _span_numbers(segments: int) -> NDArray[np.int_]:
    """Which span begins and ends where, (N + 1, N + 1)."""
    numbers = np.zeros((segments + 1, segments + 1), dtype=int)
    begin, end = _spans(segments)
    numbers[begin, end] = np.arange(len(begin))
    return numbers


@dataclass(frozen=True, eq=False)
class Samples:
    """K samples of a finger, read by several sets of sensors."""

    layout: SensorLayout  # of any sections: finger, sides and response are its matter
    believed: list[Finger]  # the finger as it is believed to be, one after the other
    driving: list[Array]  # (K, N) N m, of each of these
    ratios: SpanRatios  # (K, sets, paths, M)
    q: Array  # (K, N) rad
    gravity: Planar  # (K) m/s^2, in the bending plane

    def estimates(self, placement: Placement, assumptions: Assumptions) -> Iterator[ShapeEstimate]:
        """What is estimated from the sensors of a placement, (K, sets, ...), under each of the beliefs."""
        sections, borders = len(placement) + 1, as_borders(placement, self.layout.finger.segments)
        layout = replace(self.layout, sections=sections, borders=borders)
        readings = layout.response.reading(self.ratios.of(placement))
        gravity = np.broadcast_to(self.gravity[:, None], readings.shape[:-1])
        for finger, driving in zip(self.believed, self.driving, strict=True):
            estimate = estimator_function(
                assumptions.estimator, replace(layout, finger=finger), assumptions.uncertainty
            )
            yield estimate(readings, np.repeat(driving[:, None], readings.shape[1], axis=1), gravity)


def read_held(finger: HeldFinger, assumptions: Assumptions, number: int) -> Samples:
    """The held samples of a finger; those between have passed through its sensors too.

    `number` of the finger among all: each has random numbers of its own.
    """
    ideal = span_ratios(_of_segments(finger.layout), finger.q)
    read = _read(ideal, assumptions, finger.period, number)
    ratios = read._replace(ratios=read.ratios[finger.held])
    believed = assumptions.believed(finger.layout.finger)
    driving = [_driving(each, finger) for each in believed]
    return Samples(finger.layout, believed, driving, ratios, finger.q[finger.held], finger.gravity)


def _driving(believed: Finger, finger: HeldFinger) -> Array:
    """At the held samples, (K, N) N m; what a finger that creeps remembers is how it was bent."""
    return driving_torques(believed, finger.q, finger.pressure, finger.period)[finger.held]


def read_contacts(contacts: Contacts, like: SensorLayout, assumptions: Assumptions, number: int) -> Samples:
    """Single contacts, each read once by new sensors such as those of a layout; `number` as for `read_held`."""
    layout = replace(like, finger=contacts.finger)
    ideal = span_ratios(_of_segments(layout), contacts.q)
    at_once = ideal._replace(ratios=ideal.ratios[None])
    read = _read(at_once, assumptions, 1.0, number)
    ratios = read._replace(ratios=read.ratios[0])
    believed = assumptions.believed(layout.finger)
    driving = [each.pressure_torque(contacts.pressure) for each in believed]
    return Samples(layout, believed, driving, ratios, contacts.q, contacts.gravity)


def _of_segments(layout: SensorLayout) -> SensorLayout:
    return replace(layout, sections=layout.finger.segments, borders=None)


def _read(ideal: SpanRatios, assumptions: Assumptions, period: float, number: int) -> SpanRatios:
    if assumptions.errors is None:
        return ideal._replace(ratios=ideal.ratios[..., None, :, :])
    rng = np.random.default_rng([assumptions.seed, number])
    return disturbed(ideal, assumptions.errors, period, assumptions.sets, rng)
