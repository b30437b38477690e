"""Shape and force during an hour of grasping, as estimated under each policy of zeroing.

The plant does not depend on its sensors, and its grasps begin and end at rest: some are simulated, and repeated in
random order. The sensors are simulated over the whole hour, sample by sample: their drift, hysteresis and noise are not
repeated. Estimates are compared with the truth while objects are held, in the SPAN before each of MINUTES.

E sets of sensors, M moments, T samples of the hour.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import Annotated, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from soft_gripper.arrays import Array
from soft_gripper.estimators.contact import ContactShape
from soft_gripper.estimators.estimate import ShapeEstimate
from soft_gripper.estimators.free_motion import AT_REST
from soft_gripper.estimators.recursive import RecursiveShape
from soft_gripper.estimators.uncertainty import EXACT, Uncertainty, uncertainty_of
from soft_gripper.estimators.zeroing import recorded_zeros
from soft_gripper.fingers.kinematics import forward_kinematics, in_space
from soft_gripper.sensors.sensor_layout import SensorLayout
from soft_gripper.sensors.strain_errors import MINUTE, disturb
from studies.contacts.contacts import read_finger
from studies.contacts.estimates import REALISTIC, preset_errors
from studies.drift.grasps import GRASP, PERIOD, Grasps, repeated, simulated_grasp
from studies.robustness.rows import errors_of

MINUTES, SPAN = (5, 10, 20, 30, 40, 50, 60), 5  # ends of the spans that are scored, and how long these are, min
SECTIONS, SENSORS, GRASPS = 4, 12, 8  # per side; sets of sensors, and simulated grasps, of a set of the study
FREE_PRESSURE = 2e3  # Pa, below which the gripper is open
_MOMENT = 5.0  # s after a grasp begins
_LEAST_FORCE = 0.05  # N


class Hour(NamedTuple):
    """Inputs of the estimators, and the truth."""

    layout: SensorLayout
    uncertainty: Uncertainty
    readings: Array  # (T, E, R)
    driving: Array  # (T, E, N) N m
    gravity: Array  # (T, E, 3) m/s^2 in B
    truth: Grasps


class Stated(NamedTuple):
    """Statements of a policy at some samples."""

    shape: ShapeEstimate  # (M, E)
    interval: Array  # (M, E, 3) N


def hour_of(grasps: list[Grasps], seed: int, minutes: int = MINUTES[-1], sensors: int = SENSORS) -> Hour:
    """These grasps in random order, and read by realistic sensors; the nominal finger is exact, and declared to be."""
    rng = np.random.default_rng(seed)
    truth = repeated(grasps, rng.integers(len(grasps), size=round(minutes * MINUTE / GRASP)))
    layout, errors = SensorLayout(read_finger(), SECTIONS), preset_errors(REALISTIC)
    assert errors is not None
    ratios = np.broadcast_to((1 + layout.predict(truth.q))[:, None], (len(truth.q), sensors, layout.readings))
    readings = layout.response.reading(disturb(errors, ratios, PERIOD, rng))
    shape = len(truth.q), sensors
    driving = np.broadcast_to(layout.finger.pressure_torque(truth.pressure)[:, None], (*shape, layout.finger.segments))
    gravity = np.broadcast_to(truth.gravity[:, None], (*shape, 3))
    return Hour(layout, replace(uncertainty_of(errors), bend_per_pressure=EXACT), readings, driving, gravity, truth)


def never(hour: Hour, rows: NDArray[np.int_]) -> Stated:
    """`contact`, whose sensors are zeroed before the hour alone."""
    return _by_contact(hour, rows, hour.uncertainty)


def in_free_motion(hour: Hour, rows: NDArray[np.int_]) -> Stated:
    """`contact`, whose sensors are zeroed while the gripper is open."""
    return _by_contact(hour, rows, replace(hour.uncertainty, free_pressure=FREE_PRESSURE))


def _by_contact(hour: Hour, rows: NDArray[np.int_], uncertainty: Uncertainty) -> Stated:
    function = ContactShape(hour.layout, uncertainty, PERIOD)
    readings, std = recorded_zeros(function, hour.readings, hour.driving, hour.gravity)
    given: tuple[Any, ...] = readings[rows], hour.driving[rows], hour.gravity[rows], AT_REST, *(s[rows] for s in std)
    return Stated(function(*given), function.posterior(*given).force_interval)


def by_recursion(hour: Hour, rows: NDArray[np.int_]) -> Stated:
    """`recursive`, which estimates the offsets whenever it sees that the finger is free."""
    function, wanted = RecursiveShape(hour.layout, hour.uncertainty, PERIOD), set(rows.tolist())
    known, found = function.begin(hour.readings.shape[1:2]), []
    for i, sample in enumerate(zip(hour.readings, hour.driving, hour.gravity, strict=True)):
        known = function.step(known, *sample)
        if i in wanted:
            interval = function.posterior(known, hour.driving[i]).force_interval
            found.append((function.estimate(known, hour.driving[i]), interval))
    shapes, intervals = zip(*found, strict=True)
    q, covariance = (np.array([getattr(shape, name) for shape in shapes]) for name in ("q", "covariance"))
    return Stated(ShapeEstimate(q, covariance), np.array(intervals))


POLICIES: dict[str, Callable[[Hour, NDArray[np.int_]], Stated]] = {
    "never": never,
    "in free motion": in_free_motion,
    "recursive": by_recursion,
}


@dataclass(frozen=True)
class PolicyRow:
    """One policy in the SPAN before `minute`; of several parts the mean, weighted by their samples."""

    policy: str
    minute: int
    pose_mm: Annotated[float, ".2f"]  # mean error of the joints
    tip_mm: Annotated[float, ".2f"]  # mean
    tip_percent: Annotated[float, ".2f"]  # mean, of the length
    shape_covered_percent: Annotated[float, ".1f"]  # of the places in their 95 % bands
    force_error_n: Annotated[float, ".3f"]  # median distance of the median from the true force
    force_width_n: Annotated[float, ".3f"]  # median width of the 95 % interval
    force_covered_percent: Annotated[float, ".1f"]  # of the intervals that are stated
    force_stated_percent: Annotated[float, ".1f"]
    samples: int


@dataclass(frozen=True)
class _Part:
    part: int  # of the study


@dataclass(frozen=True)
class DriftRow(PolicyRow, _Part):
    """One set of grasps and sensors; `part` is the first column."""


def drift_rows(part: int, seed: int) -> list[DriftRow]:
    """The rows of one part of the study: the same grasps and sensors under every policy."""
    hour = hour_of([simulated_grasp(seed + part, i) for i in range(GRASPS)], seed + part)
    rows = held_rows(hour.truth, MINUTES)
    return [row for name, policy in POLICIES.items() for row in rows_of(part, name, hour, rows, policy(hour, rows))]


def held_rows(truth: Grasps, minutes: tuple[int, ...]) -> NDArray[np.int_]:
    """Samples at which something is held, one a grasp, in the SPAN before each of `minutes`, by increasing numbers."""
    rows = np.arange(round(_MOMENT / PERIOD), len(truth.q), round(GRASP / PERIOD))
    rows = rows[np.isin(_minute(rows), minutes)]
    return rows[truth.force[rows] > _LEAST_FORCE]


def _minute(rows: NDArray[np.int_]) -> NDArray[np.int_]:
    """The end of the SPAN of each sample."""
    return SPAN * ((rows * PERIOD // (SPAN * MINUTE)).astype(int) + 1)


def rows_of(part: int, policy: str, hour: Hour, rows: NDArray[np.int_], stated: Stated) -> Iterator[DriftRow]:
    """A row for each minute in which there are samples, `rows` of the hour, in this order."""
    finger = hour.layout.finger
    points = in_space(forward_kinematics(hour.truth.q[rows], finger.segment_length).points)[:, None]
    for minute in np.unique(_minute(rows)).tolist():
        chosen = np.flatnonzero(_minute(rows) == minute)
        errors = errors_of(finger, stated.shape.at(chosen), points[chosen])
        low, middle, high = np.moveaxis(stated.interval[chosen], -1, 0)
        force, known = hour.truth.force[rows[chosen]][:, None], np.isfinite(low)
        within = (low <= force) & (force <= high)
        tip = float(errors.tip.mean())
        yield DriftRow(
            part=part,
            policy=policy,
            minute=minute,
            pose_mm=1e3 * float(errors.pose.mean()),
            tip_mm=1e3 * tip,
            tip_percent=100 * tip / finger.length,
            shape_covered_percent=100 * float(errors.covered.mean()),
            force_error_n=float(np.median(np.abs(middle - force)[known])),
            force_width_n=float(np.median((high - low)[known])),
            force_covered_percent=100 * float(within[known].mean()),
            force_stated_percent=100 * float(known.mean()),
            samples=int(known.size),
        )
