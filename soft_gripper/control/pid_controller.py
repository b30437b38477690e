"""PidController: a PID for sampled signals, with limits."""

from dataclasses import dataclass, field
from math import inf, isfinite, isnan, nan
from typing import NamedTuple

import numpy as np

from soft_gripper.array_block import ArrayBlock
from soft_gripper.arrays import Array
from soft_gripper.files.document import check_config
from soft_gripper.quantity import quantity, valid


class PidStep(NamedTuple):
    memory: list[float]  # after it, before back-calculation: I, d, y, u
    unlimited: float  # v


@dataclass
class PidGains:
    """Gains from a measurement in units [y] to an output in units [u]; negative where the output acts in reverse."""

    kp: float = quantity(0.0, "[u]/[y]")
    ki: float = quantity(0.0, "[u]/([y] s)")
    kd: float = quantity(0.0, "[u] s/[y]")  # on the measurement
    derivative_filter: float = quantity(0.05, "s", least=0)  # time constant of the low-pass filter of the derivative
    tracking_time: float = quantity(0.1, "s", above=0)  # time constant of back-calculation at a limit


@dataclass(frozen=True)
class _Output:
    """Timing and initial value of a controller's output."""

    period: float = field(metadata=valid("s", above=0))
    limits: tuple[float, float] = field(metadata=valid(span=True, sizes=(0.0, inf)))


def _is_sizeable(value: float) -> bool:
    """Whether a number, and its square, are finite: an integral of larger ones would take minutes to unwind."""
    return isfinite(value * value)


class PidController(ArrayBlock):
    """PID with output limits, back-calculation, and a filtered derivative on the measurement.

    ::

        set_point (1) ------> +---------------+
        measurement (1) ----> | PidController | ---> output  (1), within the limits
        applied (1) --------> +---------------+

    It works on samples and within limits; Drake's PidController is continuous and has none. With e the set point
    less the measurement y, at every sample of period T:

        d = (derivative_filter d' + kd (y - y')) / (derivative_filter + T)      ' marks the sample before
        v = kp e + I - d
        u = v within the limits
        I <- I + T (ki e + (u - v) / tracking_time)

    If a following block may choose another output, such as a selector, connect its choice to `applied`: it
    replaces u in the last line, so that a controller that is not selected stays ready to take over
    (Astrom & Hagglund, Advanced PID Control, 2006, 5.4: selectors). Else leave `applied` unconnected.

    Give it a measurement that is sampled with the same period: the output follows its inputs at once, so that
    the loop gains no delay, and only the memory is sampled. The start is bumpless: I begins so that the
    first output is `initial_output`. While set point or measurement is not finite, or the square of the result
    overflows, the output is held, and so is the memory; while `applied` is like that, nothing unwinds.
    """

    takes_axes = False  # Python's numbers are faster for one

    def __init__(self, gains: PidGains, period: float, minimum: float, maximum: float, initial_output: float = 0.0):
        """Limits and `initial_output` in units of the output; `period` of the samples in s.

        Raises:
            InputError: if a gain is not a finite number, the period not above 0, or the limits run backwards.
        """
        check_config("gains", gains)
        check_config("controller", _Output(period, (minimum, maximum)))
        super().__init__(period)
        self._period, self._gains, self._limits = period, gains, (minimum, maximum)
        self.take("set_point", 1)
        self.take("measurement", 1)
        self.take("applied", 1, optional=True)
        self.remember(
            *("step", self.step, "set_point", "measurement"),
            begin=np.array([0.0, 0.0, nan, initial_output]),  # I, d, y, u
            keep=self._anti_windup_memory,
            kept=("applied",),
            at_first=True,
        )
        self.put_out("output", lambda step: step.memory[3], "step")

    def step(self, before: Array, set_points: Array, measurements: Array) -> PidStep:
        """Computes a sample's result from the previous memory, (4,), and both inputs, (1,)."""
        memory = before.tolist()
        integral, derivative, last, last_output = memory
        (set_point,), (measurement,) = set_points.tolist(), measurements.tolist()
        error = set_point - measurement
        gains, period = self._gains, self._period
        if isnan(last):  # the first measurement
            integral, last = last_output - gains.kp * error, measurement
        smoothing = gains.derivative_filter + period
        derivative = (gains.derivative_filter * derivative + gains.kd * (measurement - last)) / smoothing
        unlimited = gains.kp * error + integral - derivative
        integral += period * gains.ki * error
        if not _is_sizeable(unlimited + integral):
            return PidStep(memory, nan)
        output = min(max(unlimited, self._limits[0]), self._limits[1])
        return PidStep([integral, derivative, measurement, output], unlimited)

    def _anti_windup_memory(self, step: PidStep, applied: Array | None) -> Array:
        """Memory after a sample, (4,), with the integral corrected by the output that was applied."""
        integral, derivative, measurement, output = step.memory
        applied_output = output if applied is None else float(applied[0])
        unwound = integral + self._period * (applied_output - step.unlimited) / self._gains.tracking_time
        return np.array([unwound if _is_sizeable(unwound) else integral, derivative, measurement, output])
