"""Faults of a finger and of its sensors, as hypotheses about the readings.

A new fault needs an entry in `FAULTS` and `Hypotheses._entries`, its prior, and its effect in `health_filter`.

The readings y deviate from those of the nominal free finger, y_0, by the load, by an error g of the bend per pressure,
by lasting errors b of the sensors and by noise; with the bends lambda of the load, the sensitivity B, the torque u of
the pressure, the compliance C of the joints and their sums A over sections,

    r = y - y_0 = B l + b + noise ,   l = lambda + g A C u .

A fault adds a parameter f to this (a drift two), whose effect on the readings is known:

    dead        reading i is a constant               y_i = f
    slipped     its offset jumps, or its strand       r_i += f ,   or   r_i += f (y_0 + B l)_i , f < 0
                is loose and follows a part
    drifting    its offset is a ramp                  r_i += f + f' t
    saturated   it is a constant where y_i would be beyond f, and unchanged elsewhere
    leak        a fraction of the pressure is lost    r   -= f B A C u
    cut         the finger is softer from a           r   += f B A (the joint angles from there on)
                place to the tip
    held        the load is not one contact: any lambda, see `health`

Given l, all are linear in f, so that a Gaussian f is integrated out in closed form.

R readings, S values, K hypotheses, of which the first is health.
"""

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from soft_gripper.arrays import Array
from soft_gripper.quantity import quantity
from soft_gripper.sensors.measurement import MeasurementModel

HEALTHY = "healthy"
OF_SENSORS = ("dead", "slipped", "drifting", "saturated")
OF_FINGER = ("leak", "cut", "held")
FAULTS = (HEALTHY, *OF_SENSORS, *OF_FINGER)  # the kinds, in the order of the probabilities


@dataclass(frozen=True)
class UsualFaults:
    """Prior of the parameters of faults: means and standard deviations.

    Sizes of the sensors' faults are fractions of the full scale: the largest reading of the free finger at the usual
    load pressure.
    """

    probability: float = quantity(1e-9, above=0, below=1)  # of any fault
    offset: float = quantity(0.3, above=0)  # of a slipped sensor
    drift: float = quantity(0.05, "1/s", above=0)
    loose: tuple[float, float] = (-0.55, 0.16)  # of the gain of a loose strand
    leak: tuple[float, float] = (0.4, 0.14)  # of the pressure
    cut: tuple[float, float] = (1.2, 0.4)  # of the compliance


@dataclass(frozen=True)
class Hypotheses:
    """Hypotheses about one finger; the state of a hypothesis is (lambda, b, f, f', g), of S + R + 3 entries."""

    layout: MeasurementModel
    usual: UsualFaults = field(default_factory=UsualFaults)
    load_pressure: float = 1.5e5  # Pa

    @cached_property
    def _entries(self) -> list[tuple[str, int, int]]:
        """Kind, reading and joint of each hypothesis; -1 for none."""
        sensor_kinds = ("dead", "offset", "loose", "drifting", "saturated")
        sensors = [(kind, i, -1) for i in range(self.layout.readings) for kind in sensor_kinds]
        leak = [("leak", -1, -1)] if self.layout.finger.pressures else []
        segments = self.layout.finger.segments
        cuts = [
            ("cut", -1, int(joint)) for joint in np.unique(self._half_sections * segments // (2 * self.layout.sections))
        ]
        return [(HEALTHY, -1, -1), *sensors, *leak, *cuts, ("held", -1, -1)]

    @property
    def _half_sections(self) -> NDArray[np.int_]:
        return np.arange(2 * self.layout.sections)

    def indices_of(self, name: str) -> NDArray[np.int_]:
        """Indices of the hypotheses of one kind."""
        return np.array([i for i, (kind, *_) in enumerate(self._entries) if kind == name], dtype=int)

    @cached_property
    def kind(self) -> NDArray[np.int_]:
        """Indices of the kinds in FAULTS, (K,)."""
        names = {"offset": "slipped", "loose": "slipped"}
        return np.array([FAULTS.index(names.get(kind, kind)) for kind, *_ in self._entries])

    @cached_property
    def reading(self) -> NDArray[np.int_]:
        """Index of the reading that a hypothesis concerns, (K,); -1: none."""
        return np.array([reading for _, reading, _ in self._entries])

    @cached_property
    def joint(self) -> NDArray[np.int_]:
        """Index of the first softer joint of each hypothesis, (K,); -1: none."""
        return np.array([joint for *_, joint in self._entries])

    @cached_property
    def log_prior(self) -> Array:
        """Prior log odds against `healthy`, (K,); all kinds are equally probable."""
        counts = np.bincount(self.kind, minlength=len(FAULTS))
        kinds = np.count_nonzero(counts) - 1
        prior = self.usual.probability / kinds / counts[self.kind]
        return np.where(self.kind == 0, 0.0, np.log(prior))

    @cached_property
    def sign(self) -> Array:
        """Required sign of f, (K,); 0: any."""
        sign = np.zeros(len(self.kind))
        for name in ("loose", "leak", "cut"):
            sign[self.indices_of(name)] = np.sign(getattr(self.usual, name)[0])
        return sign

    @cached_property
    def full_scale(self) -> float:
        """The largest measured quantity of the free finger at the usual load pressure."""
        finger = self.layout.finger
        torque = self.load_pressure * finger.pressure_gain
        return float(np.abs(self.layout.predict(finger.angle(torque))).max())

    @cached_property
    def onset_prior(self) -> tuple[Array, Array]:
        """Mean and standard deviation of f and f' at their onset, (K, 2) each."""
        sizes = self.usual
        scale = self.full_scale
        mean, std = np.zeros((len(self.kind), 2)), np.zeros((len(self.kind), 2))
        for name in ("dead", "saturated"):
            std[self.indices_of(name), 0] = scale
        std[self.indices_of("offset"), 0] = sizes.offset * scale
        std[self.indices_of("drifting"), 1] = sizes.drift * scale
        for name in ("loose", "leak", "cut"):
            mean[self.indices_of(name), 0], std[self.indices_of(name), 0] = getattr(sizes, name)
        return mean, std

    @cached_property
    def load_response(self) -> Array:
        """Matrix B from the bends of the load to the readings, (R, S)."""
        sensitivity = self.layout.sensitivity
        value_map = sensitivity[..., None] * np.eye(sensitivity.shape[-1])
        return value_map.reshape(self.layout.readings, -1)
