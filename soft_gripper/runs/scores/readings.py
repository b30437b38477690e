"""A recorded finger with other sensors: estimates with any estimator and number of sections, from ONE simulation.

The readings are recomputed from the recorded joint angles, by the same functions that the blocks call.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from soft_gripper.arrays import Array
from soft_gripper.diagrams.recording import Recording
from soft_gripper.diagrams.station_parts import Station
from soft_gripper.estimators.driving_torque import recorded_driving
from soft_gripper.estimators.estimate import ShapeEstimate, ShapeFunction, estimates_at
from soft_gripper.estimators.free_motion import base_acceleration
from soft_gripper.estimators.named_estimators import estimator_function
from soft_gripper.estimators.plane import in_base
from soft_gripper.estimators.recorded_inputs import recorded_inputs
from soft_gripper.estimators.uncertainty import Uncertainty
from soft_gripper.fingers.plant_finger import PlantFinger
from soft_gripper.load.force_estimator import SAMPLES, Motion, TorqueBalance, windows
from soft_gripper.scenario.nominal_model import read_nominal_model
from soft_gripper.scenario.sensor_presets import sensor_layout, uncertainty
from soft_gripper.sensors.measurement import MeasurementModel


@dataclass(frozen=True)
class ReadAgain:
    """Measurements of a recorded finger, T samples, and the nominal sensors and finger."""

    layout: MeasurementModel
    uncertainty: Uncertainty
    readings: Array  # (T, R)
    pressure: Array  # (T) Pa
    gravity: Array  # (T, 3) m/s^2 in B; 0 if not compensated
    pull: Array  # (T, 3) gravity less the acceleration of the base, likewise
    period: float  # s, sampling period

    def shape(self, estimator: str = "arcs", samples: NDArray[np.int_] | None = None) -> ShapeEstimate:
        """The estimate of a built-in estimator from the readings, at some samples (M), or at all T."""
        function, driving = self._function(estimator), self._driving(estimator)
        rows, number = np.unique(self._rows if samples is None else self._rows[samples], return_inverse=True)
        known = recorded_inputs(function, self.readings[1:], driving, self.gravity[1:], self.pull[1:])
        return estimates_at(function, rows, *known).at(number)

    def driving(self, estimator: str = "arcs") -> Array:
        """The driving torque of the finger, with creep computed from an estimator's shapes, N m, (T, N)."""
        return self._driving(estimator)[self._rows]

    @property
    def _rows(self) -> NDArray[np.int_]:
        """Shifts samples by one: the first is recorded twice, since a log at a time still shows the sample before."""
        return np.maximum(np.arange(len(self.readings)) - 1, 0)

    def _driving(self, estimator: str) -> Array:
        function, samples = self._function(estimator), (self.readings[1:], self.pressure[1:], self.gravity[1:])
        return recorded_driving(function, self.layout.finger, *samples, self.period, self.pull[1:])

    def _function(self, estimator: str) -> ShapeFunction:
        return estimator_function(estimator, self.layout, self.uncertainty, self.period)


def read_again(
    station: Station,
    recording: Recording,
    finger: PlantFinger,
    sections: int,
    borders: tuple[float, ...] | None = None,
) -> ReadAgain:
    """The readings of sensors with other sections.

    Args:
        station, recording, finger: the recorded finger.
        sections: number of sections per side.
        borders: section boundaries, as shares of the length; None: those of the scenario, or equal sections.
    """
    scenario, q = station.scenario, recording[f"{finger.name}.sampled_joint_angles"].values
    simulated = with_sections(sensor_layout(finger.finger, scenario.sensor), sections, borders)
    nominal = read_nominal_model(scenario.nominal).layout(finger.finger, scenario.sensor)
    readings = simulated.read(q)
    pressure, X_WB = (recording[f"{finger.name}.{name}"].values for name in ("sampled_pressure", "X_WB"))
    gravity = in_base(X_WB, _gravity(station))
    layout, uncertain = with_sections(nominal, sections, borders), uncertainty(scenario.estimator, scenario.sensor)
    acceleration = base_acceleration(X_WB, finger.finger.length, scenario.sensor.period)
    pull = in_base(X_WB, _gravity(station) - acceleration)
    return ReadAgain(layout, uncertain, readings, pressure, gravity, pull, scenario.sensor.period)


def with_sections(
    layout: MeasurementModel, sections: int, borders: tuple[float, ...] | None = None
) -> MeasurementModel:
    """The sensors with so many sections: with these borders, or unchanged if the number agrees, or equally long."""
    as_is = sections == layout.sections and borders is None
    return layout if as_is else replace(layout, sections=sections, borders=borders)


def external_torque_again(
    station: Station, recording: Recording, finger: PlantFinger, again: ReadAgain, estimator: str = "arcs"
) -> Array:
    """The external torque for these readings at every sample, N m, (T, N); NaN until there are five."""
    shape, X_WB = again.shape(estimator), recording[f"{finger.name}.X_WB"].values
    if shape.external_torque is not None:
        return shape.external_torque
    q = shape.q
    motion = Motion(*map(windows, (q, again.driving(estimator), X_WB)))
    balance = TorqueBalance(again.layout.finger)
    torque = balance.external_torque(motion, _gravity(station), station.scenario.sensor.period).torque
    # The first sample is recorded twice: a log at a time still shows the sample before.
    return np.concatenate([np.full((SAMPLES, q.shape[-1]), np.nan), torque[1:]])


def _gravity(station: Station) -> Array:
    """Gravity as compensated in the external torque, in the world, (3,) m/s^2."""
    return np.array(station.scenario.gravity) * station.scenario.estimator.compensate_gravity
