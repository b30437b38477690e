"""Fingers at rest with all sensors that they could have, and what an estimator makes of a placement of these."""

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from soft_gripper.arrays import Array, Planar
from soft_gripper.estimators.shape_functions import SHAPE_FUNCTIONS
from soft_gripper.evaluation.contacts.dataset import Contacts
from soft_gripper.evaluation.placement.assumptions import Assumptions
from soft_gripper.evaluation.placement.held_finger import HeldFinger
from soft_gripper.evaluation.placement.placements import Placement, as_borders
from soft_gripper.evaluation.placement.section_ratios import SpanRatios, disturbed, span_ratios
from soft_gripper.fingers.finger import Finger
from soft_gripper.sensors.sensor_layout import SensorLayout
from soft_gripper.shape.driving_torque import driving_torques
from soft_gripper.shape.estimate import ShapeEstimate


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
            estimate = SHAPE_FUNCTIONS[assumptions.estimator](replace(layout, finger=finger), assumptions.uncertainty)
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
