"""Ranges of what a bench may measure: a number outside of them is no measurement, and its message is malformed."""

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

_MOST_BENT = 1.0  # rad at every joint: a usual finger would be wound up twice
_MOST_TENSION = 1e4  # N, of a winch without a limit
_MOST_OPENING = 1.0  # m
_FARTHEST_BASE = 1e3  # m, of the base from the origin of the world
_NOT_TURNED = 0.05  # largest entry of R R^T - 1
_POSE = 12  # numbers


def plausible_ranges(bench: Bench, config: BenchConfig) -> Ranges:
    """The ranges of a bench, from its description or, where that gives none, from the scenario's sensors and drive."""
    limits = config.pressure_range
    pressure = _pressures(bench.scenario) if limits is None else tuple(config.relative(np.array(limits)))
    tension = _given(config.tension_range) or _tensions(bench.scenario)
    ranges: dict[str, _Range] = {SET_POINT: (-_MOST_OPENING, _MOST_OPENING)}
    for name, layout in bench.layouts.items():
        ranges[bench.quantities[name]] = _given(config.reading_range) or _readings(layout)
        ranges |= {
            f"{name}.pressure": pressure,
            f"{name}.tension": tension,
            f"{name}.X_WB": (-_FARTHEST_BASE, _FARTHEST_BASE),
        }
        ranges |= {
            f"{name}.measured_{kind}": (np.array([-most, 0.0]), np.array([most, layout.finger.length]))
            for kind, most in MOST.items()
        }
    return {name: ranges[name] for name in bench.inputs}


def _given(limits: list[float] | None) -> _Range | None:
    return None if limits is None else (limits[0], limits[1])


def _pressures(scenario: Scenario) -> _Range:
    """Measured ones may be absolute, and overshoot."""
    supply = scenario.pressure
    return -1.2 * ATMOSPHERE, 2 * supply.maximum - supply.minimum + ATMOSPHERE


def _tensions(scenario: Scenario) -> _Range:
    most = _MOST_TENSION if scenario.tendons.maximum is None else 2 * scenario.tendons.maximum
    return -most, most


def _readings(layout: MeasurementModel) -> _Range:
    """Largest readings of sensors, each as large as that of the sensor that reads most."""
    most = np.full(layout.readings, (np.abs(layout.jacobian).sum(axis=-1) * _MOST_BENT).max())
    ends = np.array([layout.response.reading(1 + sign * most) for sign in (-1.0, 0.0, 1.0)])
    return ends.min(axis=0), ends.max(axis=0)


def check_plausible(values: Mapping[str, Array], ranges: Ranges, unread: set[str]) -> None:
    """Checks numbers by input of a bench; those `unread` may be NaN: their sensors were not read.

    Raises:
        MalformedError: if one is outside its range, or no rotation.
    """
    for name, value in values.items():
        least, most = ranges[name]
        outside = ~((value >= least) & (value <= most))
        if name in unread:
            outside &= ~np.isnan(value)
        if outside.any():
            i = int(outside.argmax())
            low, high = (float(np.broadcast_to(limit, value.shape)[i]) for limit in (least, most))
            expected = f"which is not within {low:g} to {high:g}"
            raise MalformedError(f"has {value[i]:g} as entry {i} of {name}, {expected}")
        if name.endswith(".X_WB") and len(value) == _POSE:
            turned = value.reshape(3, 4)[:, :3]
            if np.abs(turned @ turned.T - np.eye(3)).max() > _NOT_TURNED or np.linalg.det(turned) < 0:
                raise MalformedError(f"has no rotation in {name}")


_JUDGING_BEGIN = 1.0  # s, after which the pressures are judged


class FirstPressures:
    """The pressures of the first readings, which are questioned if they seem to be measured against vacuum."""

    def __init__(self, period: float, config: BenchConfig):
        self._left = max(1, round(_JUDGING_BEGIN / period)) if config.pressure_ambient is None else 0
        self._unit, self._factor = config.pressure_unit, config.pressure_factor
        self._seen: list[dict[str, Array]] = []

    def note(self, measured: Mapping[str, Array]) -> Iterator[str]:
        """Takes what was measured, by input of a bench; gives lines once enough is known."""
        if self._left == 0:
            return
        self._left -= 1
        self._seen.append({name: value for name, value in measured.items() if name.endswith(".pressure")})
        if self._left == 0:
            for name in self._seen[0]:
                yield from self._questions(name, np.array([each[name] for each in self._seen]).T)
            self._seen.clear()

    def _questions(self, name: str, pressures: Array) -> Iterator[str]:
        for i, pressure in enumerate(pressures):
            rests = float(np.median(pressure))
            if seems_absolute(rests, pressure):
                how = "if so, give `pressure_ambient`, what it has in open air; if not, `pressure_ambient: 0`"
                found = f"{name}[{i}] = {rests / self._factor:.4g} {self._unit} at the beginning"
                yield f"note: {found}: is it measured against vacuum? {how}"
