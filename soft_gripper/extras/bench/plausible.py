"""Plausible ranges of measurements: a message with a number outside is malformed."""

from collections.abc import Iterator, Mapping

import numpy as np

from soft_gripper.arrays import Array
from soft_gripper.extras.bench.bench import SET_POINT, Bench
from soft_gripper.extras.bench.messages import MalformedError
from soft_gripper.extras.hardware.ambient import seems_absolute
from soft_gripper.extras.hardware.bench_schema import BenchConfig
from soft_gripper.extras.hardware.measured import MOST
from soft_gripper.scenario.schema import ATMOSPHERE, Scenario
from soft_gripper.sensors.measurement import MeasurementModel

_Range = tuple[Array | float, Array | float]  # least and most
Ranges = Mapping[str, _Range]  # by input of a bench

_MAX_BEND = 1.0  # rad at every joint: a usual finger would be wound up twice
_MAX_TENSION = 1e4  # N, of a winch without a limit
_MAX_OPENING = 1.0  # m
_MAX_BASE_DISTANCE = 1e3  # m, of the base from the origin of the world
_ROTATION_TOLERANCE = 0.05  # largest entry of R R^T - 1
_POSE_SIZE = 12  # numbers


def plausible_ranges(bench: Bench, config: BenchConfig) -> Ranges:
    """Ranges of a bench, from its description, or else from the scenario's sensors and drive."""
    limits = config.pressure_range
    pressure = _pressures(bench.scenario) if limits is None else tuple(config.relative(np.array(limits)))
    maximum = bench.scenario.tendons.maximum
    max_tension = _MAX_TENSION if maximum is None else 2 * maximum
    tension = _explicit_range(config.tension_range) or (-max_tension, max_tension)
    ranges: dict[str, _Range] = {SET_POINT: (-_MAX_OPENING, _MAX_OPENING)}
    for name, layout in bench.layouts.items():
        ranges[bench.quantities[name]] = _explicit_range(config.reading_range) or _readings(layout)
        ranges |= {
            f"{name}.pressure": pressure,
            f"{name}.tension": tension,
            f"{name}.X_WB": (-_MAX_BASE_DISTANCE, _MAX_BASE_DISTANCE),
        }
        ranges |= {
            f"{name}.measured_{kind}": (np.array([-limit, 0.0]), np.array([limit, layout.finger.length]))
            for kind, limit in MOST.items()
        }
    return {name: ranges[name] for name in bench.inputs}


def _explicit_range(limits: list[float] | None) -> _Range | None:
    return None if limits is None else (limits[0], limits[1])


def _pressures(scenario: Scenario) -> _Range:
    """Range of measured pressures, Pa, which may be absolute, and overshoot."""
    supply = scenario.pressure
    return -1.2 * ATMOSPHERE, 2 * supply.maximum - supply.minimum + ATMOSPHERE


def _readings(layout: MeasurementModel) -> _Range:
    """Range of the readings of sensors: for all, the range of the sensor with the largest reading."""
    limit = np.full(layout.readings, (np.abs(layout.jacobian).sum(axis=-1) * _MAX_BEND).max())
    ends = np.array([layout.response.reading(1 + sign * limit) for sign in (-1.0, 0.0, 1.0)])
    return ends.min(axis=0), ends.max(axis=0)


def check_plausible(values: Mapping[str, Array], ranges: Ranges, measured_names: set[str]) -> None:
    """Checks numbers by input of a bench; those `measured_names` may be NaN: their sensors were not read.

    Raises:
        MalformedError: if one is outside its range, or not a rotation.
    """
    for name, value in values.items():
        lowest, highest = ranges[name]
        is_outside = ~((value >= lowest) & (value <= highest))
        if name in measured_names:
            is_outside &= ~np.isnan(value)
        if is_outside.any():
            i = int(is_outside.argmax())
            low, high = (float(np.broadcast_to(limit, value.shape)[i]) for limit in (lowest, highest))
            expected = f"which is not within {low:g} to {high:g}"
            raise MalformedError(f"has {value[i]:g} as entry {i} of {name}, {expected}")
        if name.endswith(".X_WB") and len(value) == _POSE_SIZE:
            R = value.reshape(3, 4)[:, :3]
            if np.abs(R @ R.T - np.eye(3)).max() > _ROTATION_TOLERANCE or np.linalg.det(R) < 0:
                raise MalformedError(f"has no rotation in {name}")


_JUDGING_BEGIN = 1.0  # s, until the pressures are judged


class FirstPressures:
    """Questions the pressures of the first readings if they seem to be measured against vacuum."""

    def __init__(self, period: float, config: BenchConfig):
        self._remaining = max(1, round(_JUDGING_BEGIN / period)) if config.pressure_ambient is None else 0
        self._unit, self._factor = config.pressure_unit, config.pressure_factor
        self._first_readings: list[dict[str, Array]] = []

    def note(self, values: Mapping[str, Array]) -> Iterator[str]:
        """Takes measurements by input of a bench; yields lines after enough measurements."""
        if self._remaining == 0:
            return
        self._remaining -= 1
        self._first_readings.append({name: value for name, value in values.items() if name.endswith(".pressure")})
        if self._remaining == 0:
            for name in self._first_readings[0]:
                yield from self._questions(name, np.array([values[name] for values in self._first_readings]).T)
            self._first_readings.clear()

    def _questions(self, name: str, pressures: Array) -> Iterator[str]:
        for i, pressure in enumerate(pressures):
            resting_pressure = float(np.median(pressure))
            if seems_absolute(resting_pressure, pressure):
                remedy = "if so, give `pressure_ambient`, its reading in open air; if not, `pressure_ambient: 0`"
                observation = f"{name}[{i}] = {resting_pressure / self._factor:.4g} {self._unit} at the beginning"
                yield f"note: {observation}: is it measured against vacuum? {remedy}"
