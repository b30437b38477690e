"""Two ways to close on an object and lift it, from estimates alone: one learned, one tuned by hand."""

from dataclasses import astuple, dataclass, fields
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
STEP = 0.1  # s, from one action to the next
LIFT = 0.08  # m, to which the gripper is lifted
LATEST_LIFT = 3.0  # s, at which it lifts, whatever has been grasped
_PRESSURE_RANGE = np.array([-20e3, 130e3])  # Pa, of SoftGrasp-v0 at -1 and at 1
_OPENING_RANGE = np.array([0.0, 0.1])  # m, of the hand-tuned grasp
_ACTION_RANGE = np.array([-1.0, 1.0])


class Policy(Protocol):
    """Acts in one episode of SoftGrasp-v0."""

    def act(self, observation: NDArray[np.float32]) -> NDArray[np.float32]:
        """The action (2): of the grip and of the lift."""


@dataclass(frozen=True)
class GentleParameters:
    """The learned parameters."""

    approach: float = 40e3  # Pa/s, at which the pressure rises until the object is touched
    touch: float = 0.012  # N m, grip torque that counts as touch
    squeeze: float = 12e3  # Pa/s, at most, at which it rises from there
    target: float = 0.06  # N m, grip torque that is held
    gain: float = 5e5  # Pa/(N m s), from the missing torque to the rate of the pressure
    ready: float = 0.9  # fraction of the target at which the lift begins
    lift: float = 0.08  # m/s, at which the gripper is lifted

    @classmethod
    def scaled(cls, factors: Array) -> "GentleParameters":
        """The first guess, each parameter multiplied by e to the power of a factor, (7)."""
        return cls(*(float(value * np.exp(x)) for value, x in zip(astuple(cls()), factors, strict=True)))


NUMBER = len(fields(GentleParameters))


class GentleGrasp:
    """Raises the pressure until the object is touched, slowly on to a grip torque, and lifts.

    Of the observations of SoftGrasp-v0 it uses the grip torque, the mean torque at the bases of the fingers.
    """

    def __init__(self, parameters: GentleParameters):
        self._parameters = parameters
        self._time, self._pressure, self._height = 0.0, 0.0, 0.0
        self._touched = self._lifts = False

    def act(self, observation: NDArray[np.float32]) -> NDArray[np.float32]:
        parameters = self._parameters
        torque = grip_torque(observation)
        self._touched |= torque > parameters.touch
        rate = parameters.approach
        if self._touched:
            rate = float(
                np.clip(parameters.gain * (parameters.target - torque), -parameters.squeeze, parameters.squeeze)
            )
        self._pressure = float(np.clip(self._pressure + STEP * rate, *_PRESSURE_RANGE))
        self._lifts |= torque > parameters.ready * parameters.target or self._time > LATEST_LIFT
        if self._lifts:
            self._height = min(self._height + STEP * parameters.lift, LIFT)
        self._time += STEP
        return _action(self._pressure, _PRESSURE_RANGE, self._height)


def grip_torque(observation: NDArray[np.float32]) -> float:
    """Mean torque that opens the fingers at their bases, N m, as observed in SoftGrasp-v0."""
    return -0.1 * float(observation[4:6].mean())


class HandTuned:
    """Closes and lifts as the shipped task for delicate objects does, whose control limits the force of the grip.

    Observations are the opening and the grip torque. The gripper is commanded to close fully; when the fingers
    are at rest, with a grip, it lifts.
    """

    CLOSED = 0.01  # m, set point
    TORQUE_THRESHOLD = 0.02  # N m, of a grip
    REST_BAND, REST_TIME = 4e-3, 0.2  # m and s, opening of fingers at rest
    SPEED = 0.08  # m/s

    def __init__(self) -> None:
        self._time, self._height, self._rest_opening, self._rest_begin = 0.0, 0.0, np.nan, 0.0
        self._lifts = False

    def act(self, observation: NDArray[np.float32]) -> NDArray[np.float32]:
        opening, torque = 0.1 * observation
        if not abs(opening - self._rest_opening) <= self.REST_BAND:
            self._rest_opening, self._rest_begin = float(opening), self._time
        at_rest = self._time - self._rest_begin >= self.REST_TIME
        self._lifts |= (at_rest and torque > self.TORQUE_THRESHOLD) or self._time > LATEST_LIFT
        if self._lifts:
            self._height = min(self._height + STEP * self.SPEED, LIFT)
        self._time += STEP
        return _action(self.CLOSED, _OPENING_RANGE, self._height)


def _action(grip: float, grips: Array, height: float) -> NDArray[np.float32]:
    lift = np.interp(height, [0.0, LIFT], _ACTION_RANGE)
    return np.array([np.interp(grip, grips, _ACTION_RANGE), lift], np.float32)
