"""Shape and force during an hour of grasping, as estimated under each policy of zeroing.

In: simulated grasps. Out: rows by policy and minute. Another policy is an entry of POLICIES.

The plant does not depend on its sensors, and its grasps begin and end at rest: some are simulated, and repeated in
random order. The sensors are simulated over the whole hour, sample by sample: their drift, hysteresis and noise are not
repeated. Estimates are compared with the truth while objects are held, in the SPAN before each of MINUTES.

E sets of sensors, M moments, T samples of the hour.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import partial
from typing import Annotated, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from soft_gripper.arrays import Array
from soft_gripper.estimators.contact import ContactShape
from soft_gripper.estimators.estimate import ShapeEstimate
from soft_gripper.estimators.free_motion import AT_REST
from soft_gripper.estimators.recursive import RecursiveShape
from soft_gripper.estimators.uncertainty import Uncertainty
from soft_gripper.estimators.zeroing import recorded_zeros
from soft_gripper.fingers.kinematics import forward_kinematics, in_space
from soft_gripper.sensors.sensor_layout import SensorLayout
from soft_gripper.sensors.strain_errors import MINUTE
from studies.contacts.contacts import read_finger
from studies.contacts.estimates import disturbed_readings
from studies.drift.grasps import GRASP, PERIOD, Grasps, join_grasps, simulated_grasp
from studies.estimator_setup import EstimatorSetup
from studies.robustness.rows import position_errors

MINUTES = (5, 10, 20, 30, 40, 50, 60)  # ends of the scored spans
SPAN = 5  # min, length of a scored span
SECTIONS, SENSORS, GRASPS = 4, 12, 8  # per side; sets of sensors, and simulated grasps, of a set of the study
FREE_PRESSURE = 2e3  # Pa, below which the gripper is open
_MOMENT = 5.0  # s after a grasp begins
_MIN_FORCE = 0.05  # N


class Hour(NamedTuple):
    """Inputs of the estimators, and the truth."""

    layout: SensorLayout
    uncertainty: Uncertainty
    readings: Array  # (T, E, R)
    driving: Array  # (T, E, N) N m
    gravity: Array  # (T, E, 3) m/s^2 in B
    truth: Grasps


class PolicyEstimates(NamedTuple):
    """Estimates under a policy at some samples."""

    shape: ShapeEstimate  # (M, E)
    interval: Array  # (M, E, 3) N, of the transverse force
    force: Array  # (M, E) N, transverse
    force_std: Array  # (M, E) N


def simulate_hour(grasps: list[Grasps], seed: int, minutes: int = MINUTES[-1], sensors: int = SENSORS) -> Hour:
    """Repeats grasps in random order and reads them by realistic sensors; the nominal finger is exact and declared."""
    rng, setup = np.random.default_rng(seed), EstimatorSetup(SECTIONS, noise=1.0)
    truth = join_grasps(grasps, rng.integers(len(grasps), size=round(minutes * MINUTE / GRASP)))
    layout, errors = SensorLayout(read_finger(), SECTIONS), setup.errors
    assert errors is not None
    shape = len(truth.q), sensors
    ratios = np.broadcast_to((1 + layout.predict(truth.q))[:, None], (*shape, layout.readings))
    readings = disturbed_readings(layout, ratios, errors, PERIOD, rng)
    driving = np.broadcast_to(layout.finger.pressure_torque(truth.pressure)[:, None], (*shape, layout.finger.segments))
    gravity = np.broadcast_to(truth.gravity[:, None], (*shape, 3))
    return Hour(layout, setup.uncertainty, readings, driving, gravity, truth)


def estimate_by_contact(hour: Hour, rows: NDArray[np.int_], free_pressure: float = 0.0) -> PolicyEstimates:
    """`contact`, whose sensors are zeroed before the hour, and below a pressure, Pa, at which the gripper is open."""
    function = ContactShape(hour.layout, replace(hour.uncertainty, free_pressure=free_pressure), PERIOD)
    readings, std = recorded_zeros(function, hour.readings, hour.driving, hour.gravity)
    inputs: tuple[Any, ...] = readings[rows], hour.driving[rows], hour.gravity[rows], AT_REST, *(s[rows] for s in std)
    return _policy_estimates(function(*inputs), function.posterior(*inputs).transverse_force_interval)


def estimate_by_recursion(hour: Hour, rows: NDArray[np.int_]) -> PolicyEstimates:
    """`recursive`, which estimates the offsets whenever it sees that the finger is free."""
    function, row_set = RecursiveShape(hour.layout, hour.uncertainty, PERIOD), set(rows.tolist())
    state = function.begin(hour.readings.shape[1:2])
    estimates = list[PolicyEstimates]()
    for i, sample in enumerate(zip(hour.readings, hour.driving, hour.gravity, strict=True)):
        state = function.step(state, *sample)
        if i in row_set:
            interval = function.posterior(state, hour.driving[i]).transverse_force_interval
            estimates.append(_policy_estimates(function.estimate(state, hour.driving[i]), interval))
    shapes, *forces = zip(*estimates, strict=True)
    q, covariance = (np.array([getattr(shape, name) for shape in shapes]) for name in ("q", "covariance"))
    return PolicyEstimates(ShapeEstimate(q, covariance), *(np.array(values) for values in forces))


def _policy_estimates(shape: ShapeEstimate, interval: Array) -> PolicyEstimates:
    contact = shape.contact
    assert contact is not None
    assert contact.transverse_force is not None
    assert contact.transverse_force_std is not None
    return PolicyEstimates(shape, interval, contact.transverse_force, contact.transverse_force_std)


POLICIES: dict[str, Callable[[Hour, NDArray[np.int_]], PolicyEstimates]] = {
    "never": estimate_by_contact,
    "in free motion": partial(estimate_by_contact, free_pressure=FREE_PRESSURE),
    "recursive": estimate_by_recursion,
}


@dataclass(frozen=True)
class PolicyRow:
    """Errors of one policy in the SPAN before `minute`, or their means over parts, weighted by samples."""

    policy: str
    minute: int
    pose_mm: Annotated[float, ".2f"]  # mean error of the joints
    tip_mm: Annotated[float, ".2f"]  # mean
    tip_percent: Annotated[float, ".2f"]  # mean, of the length
    shape_covered_percent: Annotated[float, ".1f"]  # of the places in their 95 % bands
    force_error_n: Annotated[float, ".3f"]  # median distance of the median from the true transverse force
    force_width_n: Annotated[float, ".3f"]  # median width of the 95 % interval
    force_covered_percent: Annotated[float, ".1f"]  # of the intervals that are stated
    force_rms_z: Annotated[float, ".2f"]  # root mean square error over the standard deviation
    force_stated_percent: Annotated[float, ".1f"]
    samples: int


@dataclass(frozen=True)
class _Part:
    part: int  # of the study


@dataclass(frozen=True)
class DriftRow(PolicyRow, _Part):
    """Errors of one policy for one set of grasps and sensors; `part` is the first column."""


def drift_rows(part: int, seed: int) -> list[DriftRow]:
    """The rows of one part of the study: the same grasps and sensors under every policy."""
    hour = simulate_hour([simulated_grasp(seed + part, i) for i in range(GRASPS)], seed + part)
    rows = held_rows(hour.truth, MINUTES)
    return [
        row for name, estimate in POLICIES.items() for row in policy_rows(part, name, hour, rows, estimate(hour, rows))
    ]


def held_rows(truth: Grasps, minutes: tuple[int, ...]) -> NDArray[np.int_]:
    """Indices of samples with a held object, one a grasp, in the SPAN before each of `minutes`."""
    rows = np.arange(round(_MOMENT / PERIOD), len(truth.q), round(GRASP / PERIOD))
    rows = rows[np.isin(_span_ends(rows), minutes)]
    return rows[truth.force[rows] > _MIN_FORCE]


def _span_ends(rows: NDArray[np.int_]) -> NDArray[np.int_]:
    """The end of the SPAN of each sample, min."""
    return SPAN * ((rows * PERIOD // (SPAN * MINUTE)).astype(int) + 1)


def policy_rows(
    part: int, policy: str, hour: Hour, rows: NDArray[np.int_], estimates: PolicyEstimates
) -> Iterator[DriftRow]:
    """A row for each minute with samples, `rows` of the hour, in this order."""
    finger, ends = hour.layout.finger, _span_ends(rows)
    points = in_space(forward_kinematics(hour.truth.q[rows], finger.segment_length).points)[:, None]
    for minute in np.unique(ends).tolist():
        minute_rows = np.flatnonzero(ends == minute)
        errors = position_errors(finger, estimates.shape.at(minute_rows), points[minute_rows])
        low, middle, high = np.moveaxis(estimates.interval[minute_rows], -1, 0)
        force, is_stated = hour.truth.force[rows[minute_rows]][:, None], np.isfinite(low)
        covers = (low <= force) & (force <= high)
        z = (estimates.force[minute_rows] - force) / estimates.force_std[minute_rows]
        tip = float(errors.tip.mean())
        yield DriftRow(
            part=part,
            policy=policy,
            minute=minute,
            pose_mm=1e3 * float(errors.pose.mean()),
            tip_mm=1e3 * tip,
            tip_percent=100 * tip / finger.length,
            shape_covered_percent=100 * float(errors.covered.mean()),
            force_error_n=float(np.median(np.abs(middle - force)[is_stated])),
            force_width_n=float(np.median((high - low)[is_stated])),
            force_covered_percent=100 * float(covers[is_stated].mean()),
            force_rms_z=float(np.sqrt(np.nanmean(z[is_stated] ** 2))),
            force_stated_percent=100 * float(is_stated.mean()),
            samples=int(is_stated.size),
        )
