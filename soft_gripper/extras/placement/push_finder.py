"""Readings of a finger that is pushed once -> the most probable push: its force, its place along and across the finger.

Minimizes, over the unknowns v of the push and the shape q(v) in balance with it,

    (y - h(q))' N^-1 (y - h(q)) + (v - v_0)' U^-1 (v - v_0) ,   N = V + H A H' ,

with the variances V of the readings, the deviations A of the joints and the weak prior U, by Gauss and Newton's method:
shape and push move together, a step of each in every pass. It begins at several places along the finger, and trusts
the readings little at first, which leads past minima that are not the least; the least that is found counts.

Leading axes are free; R readings, D joints, C pressures.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from soft_gripper.arrays import Array
from soft_gripper.estimators.mechanics import SpatialMechanics
from soft_gripper.estimators.uncertainty import Uncertainty
from soft_gripper.extras.placement.pushed_finger import Push, PushedFinger
from soft_gripper.extras.placement.spatial_scores import push_prior
from soft_gripper.sensors.measurement import MeasurementModel

_BEGIN = (0.3, 0.5, 0.7, 0.9)  # shares of the length
_BLURS = np.append(np.geomspace(1e4, 1, 15), np.ones(15))  # of the variances of the readings, in every pass
_MOST = np.array([0.5, 0.5, 0.5, 0.1, 0.5, 0.1])  # of a step: N, and shares of length, half width and drive


class _State(NamedTuple):
    """State of the search."""

    v: Array  # (..., 6)
    q: Array  # (..., D)


class _Read(NamedTuple):
    """Quantities that are known."""

    measured: Array  # (..., R)
    variance: Array  # (..., R)
    driving: Array  # (..., D) N m


@dataclass(frozen=True, eq=False)
class PushFinder:
    """Finds a push on a nominal finger with nominal sensors."""

    layout: MeasurementModel
    statics: PushedFinger
    uncertainty: Uncertainty

    def __call__(self, readings: Array, pressures: Array) -> Array:
        """The unknowns of the push, (..., 6) as in `pushed_finger.UNKNOWNS`.

        Args:
            readings: of the sensors, (..., R).
            pressures: in the chambers, (..., C) Pa.
        """
        measured, driving = self.layout.measured(readings), self.statics.driving(pressures)
        variance = self.uncertainty.any_reading**2 + (self.uncertainty.gain * measured) ** 2
        read = _Read(measured, variance, np.broadcast_to(driving, (*measured.shape[:-1], driving.shape[-1])))
        found = [self._found_from(share, read) for share in _BEGIN]
        best = np.argmin([self._cost(read, state) for state in found], axis=0)
        return np.take_along_axis(np.stack([state.v for state in found]), best[None, ..., None], axis=0)[0]

    def _found_from(self, share: float, read: _Read) -> _State:
        v = np.broadcast_to(self._middle, (*read.measured.shape[:-1], len(self._middle))).copy()
        v[..., 3] = share * self.statics.finger.length
        state = _State(v, self.statics.at_rest(read.driving, _push(v)))
        for blur in _BLURS:
            state = self._moved(state, read, blur)
        return state

    def _moved(self, state: _State, read: _Read, blur: float) -> _State:
        """A pass of Gauss and Newton's method."""
        v, q = state
        missing, slopes = self.statics.response(q, (1 + v[..., 5:]) * read.driving, _push(v))
        H = self.layout.slopes(q)
        by_push = H @ slopes * self._std
        left = read.measured - self.layout.predict(q) - (H @ missing[..., None])[..., 0]
        weighed = np.swapaxes(np.linalg.solve(self._noise(H, blur * read.variance), by_push), -1, -2)
        gradient = (weighed @ left[..., None])[..., 0] - (v - self._middle) / self._std
        step = np.linalg.solve(np.eye(len(self._std)) + weighed @ by_push, gradient[..., None])[..., 0] * self._std
        after = v + step / np.maximum(1, (np.abs(step) / self._most).max(axis=-1, keepdims=True))
        after[..., 3] = np.clip(after[..., 3], 0, self.statics.finger.length)
        return _State(after, q + missing + (slopes @ (after - v)[..., None])[..., 0])

    def _cost(self, read: _Read, state: _State) -> Array:
        left = read.measured - self.layout.predict(state.q)
        noise = self._noise(self.layout.slopes(state.q), read.variance)
        of_readings = (left * np.linalg.solve(noise, left[..., None])[..., 0]).sum(axis=-1)
        return np.asarray(of_readings + (((state.v - self._middle) / self._std) ** 2).sum(axis=-1))

    def _noise(self, H: Array, variance: Array) -> Array:
        return np.asarray(H @ self._deviations @ np.swapaxes(H, -1, -2) + variance[..., None] * np.eye(H.shape[-2]))

    @cached_property
    def _deviations(self) -> Array:
        return SpatialMechanics(self.layout, self.uncertainty).deviations

    @cached_property
    def _std(self) -> Array:
        return push_prior(self.statics.finger, self.uncertainty)

    @cached_property
    def _middle(self) -> Array:
        return np.array([0.0, 0.0, 0.0, self.statics.finger.length / 2, 0.0, 0.0])

    @cached_property
    def _most(self) -> Array:
        return _MOST * [1, 1, 1, self.statics.finger.length, self.statics.half_width, 1]


def _push(v: Array) -> Push:
    return Push(v[..., :3], v[..., 3], v[..., 4])
