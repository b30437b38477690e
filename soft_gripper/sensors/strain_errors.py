"""Errors of strain sensors, as pure functions: extension ratios -> disturbed extension ratios.

Everything takes arrays whose leading axes are free and whose last axis counts the R readings of a finger, so that a
block calls `step` for one sample and `disturb` goes through a whole recording, for many seeds at once.

Rate-independent hysteresis: a Prandtl-Ishlinskii model, the weighted sum of play operators.

A play operator of radius r follows the strain with a backlash of r to either side. With radii that double from one to
the next and one weight w for all, the loop of a cycle is as wide as w (stroke - 2 least radius): a share of the stroke,
whatever the stroke. (M. A. Krasnosel'skii, A. V. Pokrovskii, Systems with Hysteresis, Springer 1989; K. Kuhnen,
Modeling, identification and compensation of complex hysteretic nonlinearities, European Journal of Control 9, 2003,
doi:10.3166/ejc.9.407-418.)

Such a sum is the only one of play operators whose loop is the same share of every stroke.

Another error is a field of `StrainErrors` and its effect in `step`; its memory is a field of `StrainMemory`.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from statistics import NormalDist
from typing import NamedTuple

import numpy as np

from soft_gripper.arrays import Array
from soft_gripper.files.document import check_config
from soft_gripper.quantity import Violation, quantity
from soft_gripper.sensors.error_block import ErrorBlock, pass_delay_line
from soft_gripper.sensors.measurement import MeasurementModel
from soft_gripper.sensors.response_curve import CalibratedResponse, ResponseCurve

PLAYS = 10
RADII = 0.2 / 2.0 ** np.arange(PLAYS)[:, None]  # strain, (PLAYS, 1): strokes of up to 0.8 have a full loop
FULL_SCALE = 0.1  # strain of a sensor stretched from rest at which the hysteresis error is zero
_FULL_SCALE_SUM = float(np.maximum(1 - RADII / FULL_SCALE, 0).sum())  # sum of the operators, over the strain, there
MINUTE = 60.0  # s, after which `drift` is reached
RUN_DRAWS, SAMPLE_DRAWS = 4, 3  # standard normal draws that a sensor needs per run, and in addition per sample
HYSTERESIS_LIMIT = 0.14  # above 1 / _FULL_SCALE_SUM, readings would move backwards at small reversals
SENSOR_FAULTS = ("dead", "offset", "loose", "drifting", "saturated")
_ONSET_TOLERANCE = 1e-9  # s, by which the sum of periods may fall short of an onset


def moved_plays(plays: Array, strain: Array) -> Array:
    """The play operators, (..., PLAYS, R), updated to the strain `strain`, (..., R)."""
    strain = strain[..., None, :]
    return np.clip(plays, strain - RADII, strain + RADII)


def lagging_strain(plays: Array, strain: Array, width: float) -> Array:
    """The strain with hysteresis, (..., R), for a loop width given as a fraction of the stroke."""
    return (1 - width * _FULL_SCALE_SUM) * strain + width * plays.sum(axis=-2)


@dataclass(frozen=True)
class SensorFault:
    kind: str  # one of SENSOR_FAULTS
    reading: int
    time: float  # s, of the onset
    size: float | None  # see SensorFaultConfig


@dataclass(frozen=True)
class StrainErrors:
    """The errors of strain sensors, in the order of their action; none by default.

    Strain is the extension ratio - 1; of sensors that measure another quantity y, 1 + y stands for the extension ratio,
    so that offsets and noise are in the unit of y. Standard deviations are those of independent draws for every sensor.

    Raises:
        InputError: for the first number that is out of range.
    """

    creep: float = quantity(0.0, least=0, most=1)  # delayed fraction of the strain
    creep_time: float = quantity(10.0, "s", above=0)  # time constant of the delayed fraction
    hysteresis: float = quantity(0.0, least=0, most=HYSTERESIS_LIMIT)  # loop width of a cycle, relative to its stroke
    gain_error: float = quantity(0.0, least=0)  # standard deviation, drawn once per run, as a fraction of the strain
    offset: float = quantity(0.0, least=0)  # standard deviation, drawn once per run, extension ratio
    # Standard deviation of the drift after one minute at a constant rate, extension ratio.
    drift: float = quantity(0.0, least=0)
    # Standard deviation of a first-order Gauss-Markov process, extension ratio.
    low_frequency_noise: float = quantity(0.0, least=0)
    correlation_time: float = quantity(10.0, "s", above=0)  # of that process
    noise: float = quantity(0.0, least=0)  # standard deviation, white, of every sample, extension ratio
    # Measuring range, extension ratio.
    saturation: tuple[float, float] = quantity((-math.inf, math.inf), sizes=(0.0, math.inf), span=True)
    quantization: float | None = quantity(None, above=0)  # step of the extension ratio
    delay: int = quantity(0, least=0)  # samples
    dropout: float = quantity(0.0, least=0, most=1)  # probability that a sample is lost and reads NaN
    dead: tuple[int, ...] = ()  # readings that are always NaN
    faults: tuple[SensorFault, ...] = ()  # of sensors that fail during a run

    def __post_init__(self) -> None:
        check_config("sensor.errors", self)

    def violations(self) -> Iterator[Violation]:
        if self.saturation[0] == self.saturation[1]:
            yield "saturation", self.saturation, "must be [least, greatest] extension ratio"


class StrainMemory(NamedTuple):
    gain: Array  # (..., R), constant during a run
    offset: Array  # (..., R) extension ratio, constant during a run
    drift_rate: Array  # (..., R) 1/s, constant during a run
    drift: Array  # (..., R) extension ratio
    low_frequency: Array  # (..., R) extension ratio
    creep: Array  # (..., R), the creep strain
    time: Array  # (..., R) s, since the run began
    read: Array  # (..., R) extension ratio read at the sample before, NaN before the first
    plays: Array  # (..., PLAYS, R), the strains of the play operators
    line: Array  # (..., delay, R) extension ratios in the delay line, oldest first


_SINGLE_ROWS = StrainMemory._fields.index("plays")  # parts of a memory that are a single row


class Draws(NamedTuple):
    """Standard normal draws for a recording."""

    run: Array  # (..., RUN_DRAWS, R)
    samples: Array  # (T, ..., SAMPLE_DRAWS, R)


def begin(errors: StrainErrors, draws: Array) -> StrainMemory:
    """Initial memory of sensors at rest, from standard normal draws (..., RUN_DRAWS, R)."""
    gain, offset, drift, low_frequency = np.moveaxis(draws, -2, 0)
    rest = np.zeros_like(gain)
    return StrainMemory(
        gain=1 + errors.gain_error * gain,
        offset=errors.offset * offset,
        drift_rate=errors.drift / MINUTE * drift,
        drift=rest,
        low_frequency=errors.low_frequency_noise * low_frequency,
        creep=rest,
        time=rest,
        read=rest + np.nan,
        plays=np.repeat(rest[..., None, :], PLAYS, axis=-2),
        line=np.full((*rest.shape[:-1], errors.delay, rest.shape[-1]), np.nan),
    )


def step(
    errors: StrainErrors, memory: StrainMemory, ratio: Array, draws: Array, period: float
) -> tuple[StrainMemory, Array]:
    """One sample of every sensor: the memory after it, and the disturbed extension ratios, (..., R).

    It takes the memory after the previous sample, or at the start of a run, true extension ratios, (..., R), standard
    normal draws, (..., SAMPLE_DRAWS, R), and the period between samples, s.
    """
    white, low_frequency, dropout = np.moveaxis(draws, -2, 0)
    strain = ratio - 1
    crept_strain = strain - errors.creep * (strain - memory.creep)
    plays = moved_plays(memory.plays, crept_strain)
    correlation = math.exp(-period / errors.correlation_time)
    innovation = errors.low_frequency_noise * math.sqrt(1 - correlation**2)
    slow_noise = correlation * memory.low_frequency + innovation * low_frequency
    lagging_ratio = 1 + memory.gain * lagging_strain(plays, crept_strain, errors.hysteresis) + memory.offset
    faulty_ratio = _with_faults(errors, memory.time, lagging_ratio)
    reading = np.clip(faulty_ratio + memory.drift + slow_noise + errors.noise * white, *errors.saturation)
    if errors.quantization is not None:
        reading = errors.quantization * np.round(reading / errors.quantization)
    reading = _with_failures(errors, memory, reading)
    line, delayed = pass_delay_line(memory.line, reading)
    next_memory = memory._replace(
        drift=memory.drift + memory.drift_rate * period,
        low_frequency=slow_noise,
        creep=memory.creep - math.expm1(-period / errors.creep_time) * (strain - memory.creep),
        time=memory.time + period,
        read=reading,
        plays=plays,
        line=line,
    )
    return next_memory, _drop_readings(errors, delayed, dropout)


def disturb(errors: StrainErrors, ratios: Array, period: float, rng_or_draws: np.random.Generator | Draws) -> Array:
    """Disturbs a recording.

    Args:
        errors: of all sensors.
        ratios: true extension ratios, (T, ..., R); for many seeds, repeated along an axis of them.
        period: between the T samples, s.
        rng_or_draws: where the random numbers come from, or these numbers.

    Returns:
        the disturbed extension ratios, (T, ..., R).
    """
    draws = rng_or_draws if isinstance(rng_or_draws, Draws) else draw(rng_or_draws, np.shape(ratios))
    memory, disturbed = begin(errors, draws.run), np.empty(np.shape(ratios))
    for i, ratio in enumerate(ratios):
        memory, disturbed[i] = step(errors, memory, ratio, draws.samples[i], period)
    return disturbed


def draw(rng: np.random.Generator, shape: tuple[int, ...]) -> Draws:
    """The random numbers for a recording of extension ratios of that shape, (T, ..., R)."""
    samples, *seeds, readings = shape
    run = rng.standard_normal((*seeds, RUN_DRAWS, readings))
    return Draws(run, rng.standard_normal((samples, *seeds, SAMPLE_DRAWS, readings)))


def stack_memory(memory: StrainMemory) -> Array:
    """A memory as one array, (..., rows, R)."""
    single_rows = (row[..., None, :] for row in memory[:_SINGLE_ROWS])
    return np.concatenate([*single_rows, memory.plays, memory.line], axis=-2)


def unstack_memory(rows: Array) -> StrainMemory:
    """The inverse of `stack_memory`."""
    plays, line = np.split(rows[..., _SINGLE_ROWS:, :], [PLAYS], axis=-2)
    return StrainMemory._make([*np.moveaxis(rows[..., :_SINGLE_ROWS, :], -2, 0), plays, line])


def _with_faults(errors: StrainErrors, time: Array, ratio: Array) -> Array:
    """Extension ratios with faults that act before the sensor is read out."""
    for fault in errors.faults:
        if fault.kind in ("offset", "loose", "drifting") and fault.size is not None:
            since, strain = time[..., fault.reading] - fault.time, ratio[..., fault.reading] - 1
            effects: dict[str, Array | float] = {"offset": 1.0, "loose": -strain, "drifting": since}
            error, ratio = fault.size * effects[fault.kind], ratio.copy()
            ratio[..., fault.reading] += np.where(since > -_ONSET_TOLERANCE, error, 0.0)
    return ratio


def _with_failures(errors: StrainErrors, memory: StrainMemory, ratio: Array) -> Array:
    """Readings of extension ratios by sensors that may be dead or saturated."""
    for fault in errors.faults:
        if fault.kind in ("dead", "saturated"):
            i, ratio = fault.reading, ratio.copy()
            last = np.where(np.isnan(memory.read[..., i]), ratio[..., i], memory.read[..., i])
            limit = last if fault.size is None else 1 + fault.size
            limited_ratio = np.minimum(ratio[..., i], limit) if np.all(limit > 1) else np.maximum(ratio[..., i], limit)
            failed = limited_ratio if fault.kind == "saturated" else limit
            ratio[..., i] = np.where(memory.time[..., i] - fault.time > -_ONSET_TOLERANCE, failed, ratio[..., i])
    return ratio


def _drop_readings(errors: StrainErrors, ratio: Array, draws: Array) -> Array:
    if errors.dropout > 0:
        threshold = NormalDist().inv_cdf(errors.dropout) if errors.dropout < 1 else math.inf
        ratio = np.where(draws < threshold, np.nan, ratio)
    if errors.dead:
        ratio = ratio.copy()
        ratio[..., list(errors.dead)] = np.nan
    return ratio


@dataclass(frozen=True)
class _ReadingErrors:
    """Applies errors of the extension ratio to readings."""

    errors: StrainErrors
    response: ResponseCurve | CalibratedResponse
    period: float
    draws = (RUN_DRAWS, SAMPLE_DRAWS)

    def begin(self, draws: Array) -> Array:
        return stack_memory(begin(self.errors, draws))

    def step(self, memory: Array, ideal: Array, draws: Array) -> tuple[Array, Array]:
        ratio = self.response.ratio(ideal)
        before = unstack_memory(memory)
        next_memory, disturbed = step(self.errors, before, ratio, draws, self.period)
        return stack_memory(next_memory), self.response.reading(disturbed)


class ReadingErrorBlock(ErrorBlock):
    """Disturbs the readings of the sensors of one finger; see `ErrorBlock`.

    ::

        ideal_strain (R) ---------> +-------------------+
                                    | ReadingErrorBlock | ---> strain (R) readings
        standard_normal (7 R) ----> +-------------------+

    Of sensors that measure another quantity, the ports are called after that.
    """

    def __init__(self, layout: MeasurementModel, errors: StrainErrors, period: float):
        """Samples the sensors every `period` s."""
        model = _ReadingErrors(errors, layout.response, period)
        ideal = f"ideal_{layout.quantity}"
        super().__init__(model, layout.readings, period, ideal, layout.quantity, unit=layout.unit, **layout.axes)
