"""Fingers at rest with all possible sensors, and the estimates for any placement of these.

The readings of every section that a finger could have, of which each placement selects its own.

What a sensor reads depends on where its section begins and ends, not on the others. So all spans of whole segments are
read, and disturbed, once; placements that share a section share its errors, so that they do not differ by chance.

T samples, N segments, M = N (N + 1) / 2 spans.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from soft_gripper.arrays import Array, Planar
from soft_gripper.errors import InputError
from soft_gripper.estimators.driving_torque import driving_torques
from soft_gripper.estimators.estimate import ShapeEstimate
from soft_gripper.estimators.plane import planar_gravity
from soft_gripper.estimators.uncertainty import EXACT, Uncertainty
from soft_gripper.extras.hardware.recorded_run import RecordedRun, read_signal
from soft_gripper.extras.placement.placements import Placement, as_borders
from soft_gripper.extras.studies.contacts.contacts import Contacts
from soft_gripper.fingers.finger import Finger
from soft_gripper.fingers.kinematics import as_planar
from soft_gripper.fingers.plant_finger import PlantFinger
from soft_gripper.runs.scores.poses import held_rows, held_samples
from soft_gripper.scenario.named_estimators import estimator_function, find_estimator
from soft_gripper.scenario.nominal_model import NominalModel
from soft_gripper.scenario.schema import NominalConfig
from soft_gripper.scenario.sensor_presets import sensor_layout
from soft_gripper.sensors.sensor_layout import SensorLayout, extension_ratios, strain_sensors
from soft_gripper.sensors.strain_errors import StrainErrors, disturb
from soft_gripper.truth.contact import touches

SAMPLES = 2  # of every held step, spread evenly: the finger rests, and only noise differs


@dataclass(frozen=True, eq=False)
class HeldFinger:
    """A finger of a run, T samples, of which K are held ones that count."""

    layout: SensorLayout  # as in the scenario; a placement gives it other sections
    period: float  # s
    q: Array  # (T, N) rad
    held: NDArray[np.int_]  # (K), which of the T samples
    pressure: Array  # (T) Pa
    gravity: Planar  # (K) m/s^2, in the bending plane


def held_fingers(name: str, run: RecordedRun) -> list[HeldFinger]:
    """The fingers of a run that touch something at any held step; all of them if none does.

    `name` is that of the scenario or the file.

    Raises:
        InputError: if a signal was not recorded, or the recording ends before the scenario does.
    """
    lasts, duration = float(run.recording["time"][-1]), run.scenario.duration
    if lasts < duration - 1.5 * run.scenario.sensor.period:
        raise InputError(name, "time", lasts, f"the recording ends before the steps of its scenario, {duration:g} s")
    touched = [finger for finger in run.fingers if _touches_anything(name, run, finger)]
    return [_held_finger(name, run, finger) for finger in touched or run.fingers]


def _touches_anything(name: str, run: RecordedRun, finger: PlantFinger) -> bool:
    force = read_signal(name, run.recording, f"{finger.name}.link_contact_force", finger.finger.segments + 1)
    return bool(touches(held_samples(run.scenario, run.recording, force).mean(axis=1)).any())


def _held_finger(name: str, run: RecordedRun, finger: PlantFinger) -> HeldFinger:
    scenario, recording = run.scenario, run.recording
    q = read_signal(name, recording, f"{finger.name}.sampled_joint_angles", finger.finger.segments)
    pressure = read_signal(name, recording, f"{finger.name}.sampled_pressure")
    X_WB = read_signal(name, recording, f"{finger.name}.X_WB", 3, 4)
    steps = held_rows(scenario, recording)
    chosen = np.linspace(0, steps.shape[1] - 1, min(SAMPLES, steps.shape[1])).astype(int)
    held = steps[:, chosen].ravel()
    gravity = planar_gravity(X_WB[held], np.array(scenario.gravity))
    layout = strain_sensors(sensor_layout(finger.finger, scenario.sensor), name)
    return HeldFinger(layout, scenario.sensor.period, q, held, pressure, gravity)


SETS = 16  # of sensors to draw if they have errors
USUAL_STRAIN = 0.05  # strain at which errors relative to the strain are assumed


@dataclass(frozen=True)
class Assumptions:
    """An estimator, the errors of its sensors, and by how much the nominal stiffness is wrong.

    Raises:
        InputError: if there is no such estimator, or the nominal finger would be impossible.
    """

    estimator: str = "gaussian"
    errors: StrainErrors | None = None  # None: ideal sensors
    nominal_error: float = 0.0  # %, of Young's modulus, up and down
    seed: int = 1  # of what is random

    def __post_init__(self) -> None:
        find_estimator(self.estimator, field="--estimator")
        if not 0 <= self.nominal_error < 100:
            raise InputError(
                "place-sensors", "--nominal-error", self.nominal_error, "give a percentage from 0 to below 100"
            )

    @property
    def sets(self) -> int:
        """Number of sets of sensors to draw; ideal ones are all identical."""
        return 1 if self.errors is None else SETS

    def nominal(self, finger: Finger) -> list[Finger]:
        """The nominal finger, once too stiff and once too soft."""
        signs = (1, -1) if self.nominal_error else (1,)
        changes = [NominalConfig(youngs_modulus=f"{sign * self.nominal_error:+g} %") for sign in signs]
        return [NominalModel(change).finger(finger) for change in changes]

    @cached_property
    def uncertainty(self) -> Uncertainty:
        """The sizes of these errors that the estimator assumes, no less than of an exact model and ideal sensors."""
        least = Uncertainty(bend_per_pressure=EXACT)
        bend = max(least.bend_per_pressure, self.nominal_error / 100)
        reading = least.reading if self.errors is None else max(least.reading, reading_std(self.errors))
        return Uncertainty(reading=reading, bend_per_pressure=bend)


def reading_std(errors: StrainErrors) -> float:
    """Approximate error of the extension ratios: all errors together, at a usual strain, after a minute."""
    absolute = errors.noise, errors.offset, errors.drift, errors.low_frequency_noise
    relative = errors.gain_error, errors.hysteresis, errors.creep
    return math.hypot(*absolute, *(USUAL_STRAIN * share for share in relative))


class SpanRatios(NamedTuple):
    """Extension ratios of all spans."""

    ratios: Array  # (..., paths, M)
    segments: int

    def of(self, placement: Placement) -> Array:
        """Ratios of the sections of a placement, in the order of readings, (..., paths * S)."""
        ends = np.array([0, *placement, self.segments])
        chosen = self.ratios[..., _span_numbers(self.segments)[ends[:-1], ends[1:]]]
        return chosen.reshape(*chosen.shape[:-2], -1)


def span_ratios(segment_sensors: SensorLayout, q: Array) -> SpanRatios:
    """Ratios of ideal sensors, from joint angles (..., N) rad; `segment_sensors` has a section for every segment."""
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
    """The number of the span between two segment ends, (N + 1, N + 1)."""
    numbers = np.zeros((segments + 1, segments + 1), dtype=int)
    begin, end = _spans(segments)
    numbers[begin, end] = np.arange(len(begin))
    return numbers


@dataclass(frozen=True, eq=False)
class Samples:
    """K samples of a finger, read by several sets of sensors."""

    layout: SensorLayout  # of any sections; only finger, sides and response are used
    nominal: list[Finger]  # the nominal finger, one after the other
    driving: list[Array]  # (K, N) N m, of each of these
    ratios: SpanRatios  # (K, sets, paths, M)
    q: Array  # (K, N) rad
    gravity: Planar  # (K) m/s^2, in the bending plane

    def estimates(self, placement: Placement, assumptions: Assumptions) -> Iterator[ShapeEstimate]:
        """Estimates from the sensors of a placement, (K, sets, ...), with each of the nominal models."""
        sections, borders = len(placement) + 1, as_borders(placement, self.layout.finger.segments)
        layout = replace(self.layout, sections=sections, borders=borders)
        readings = layout.response.reading(self.ratios.of(placement))
        gravity = np.broadcast_to(self.gravity[:, None], readings.shape[:-1])
        for finger, driving in zip(self.nominal, self.driving, strict=True):
            estimate = estimator_function(
                assumptions.estimator, replace(layout, finger=finger), assumptions.uncertainty
            )
            yield estimate(readings, np.repeat(driving[:, None], readings.shape[1], axis=1), gravity)


def read_held(finger: HeldFinger, assumptions: Assumptions, number: int) -> Samples:
    """The held samples of a finger; its sensors have also seen those between.

    `number` of the finger among all: each has random numbers of its own.
    """
    ideal = span_ratios(_of_segments(finger.layout), finger.q)
    read = _read(ideal, assumptions, finger.period, number)
    ratios = read._replace(ratios=read.ratios[finger.held])
    nominal = assumptions.nominal(finger.layout.finger)
    driving = [_driving(each, finger) for each in nominal]
    return Samples(finger.layout, nominal, driving, ratios, finger.q[finger.held], finger.gravity)


def _driving(nominal: Finger, finger: HeldFinger) -> Array:
    """At the held samples, (K, N) N m; creep depends on how the finger was bent before."""
    return driving_torques(nominal, finger.q, finger.pressure, finger.period)[finger.held]


def read_contacts(contacts: Contacts, like: SensorLayout, assumptions: Assumptions, number: int) -> Samples:
    """Single contacts, each read once by new sensors such as those of a layout; `number` as for `read_held`."""
    layout = replace(like, finger=contacts.finger)
    ideal = span_ratios(_of_segments(layout), contacts.q)
    at_once = ideal._replace(ratios=ideal.ratios[None])
    read = _read(at_once, assumptions, 1.0, number)
    ratios = read._replace(ratios=read.ratios[0])
    nominal = assumptions.nominal(layout.finger)
    driving = [each.pressure_torque(contacts.pressure) for each in nominal]
    return Samples(layout, nominal, driving, ratios, contacts.q, as_planar(contacts.gravity[:, ::2]))


def _of_segments(layout: SensorLayout) -> SensorLayout:
    return replace(layout, sections=layout.finger.segments, borders=None)


def _read(ideal: SpanRatios, assumptions: Assumptions, period: float, number: int) -> SpanRatios:
    if assumptions.errors is None:
        return ideal._replace(ratios=ideal.ratios[..., None, :, :])
    rng = np.random.default_rng([assumptions.seed, number])
    return disturbed(ideal, assumptions.errors, period, assumptions.sets, rng)
