"""A recorded finger estimated again: by any estimator, from its readings or from those of other sensors.

Other readings are recomputed from the recorded joint angles, by the same functions that the blocks call.
"""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from soft_gripper.arrays import Array
from soft_gripper.diagrams.recording import Recording
from soft_gripper.diagrams.station_parts import Station
from soft_gripper.estimators.driving_torque import driving_port, recorded_driving, recorded_inputs
from soft_gripper.estimators.estimate import ShapeEstimate, ShapeFunction, estimates_at, samples_at
from soft_gripper.estimators.free_motion import base_acceleration
from soft_gripper.estimators.named_estimators import estimator_function
from soft_gripper.estimators.plane import to_base
from soft_gripper.estimators.uncertainty import Uncertainty
from soft_gripper.fingers.plant_finger import PlantFinger
from soft_gripper.load.force_estimator import SAMPLES, Motion, TorqueBalance, windows
from soft_gripper.scenario.nominal_model import read_nominal_model
from soft_gripper.scenario.schema import Scenario
from soft_gripper.scenario.sensor_presets import sensor_layout, uncertainty
from soft_gripper.sensors.measurement import MeasurementModel


@dataclass(frozen=True)
class ReadAgain:
    """Measurements of a recorded finger, N samples, and the nominal sensors and finger."""

    layout: MeasurementModel
    uncertainty: Uncertainty
    readings: Array  # (N, R)
    pressure: Array  # (N) Pa, or (N, C) in C chambers
    X_WB: Array  # (N, 3, 4) pose of the base, [R | p]
    gravity_world: Array  # (3,) m/s^2 in the world; 0 if not compensated
    period: float  # s, sampling period
    numbers: NDArray[np.int_]  # (T,) of the sample at each time of the recording
    torque: Array | None = None  # (N, D) N m, driving torque as recorded; None: that next to the estimator

    @property
    def gravity(self) -> Array:
        """Gravity in B, (N, 3) m/s^2."""
        return to_base(self.X_WB, self.gravity_world)

    def shape(self, estimator: str = "arcs", rows: NDArray[np.int_] | None = None) -> ShapeEstimate:
        """Shape by a built-in estimator in some rows of the recording, (M,), or in all T."""
        samples, inverse = np.unique(self.numbers if rows is None else self.numbers[rows], return_inverse=True)
        return self.estimate(estimator, samples).at(inverse)

    def estimate(self, estimator: str, samples: NDArray[np.int_] | None = None) -> ShapeEstimate:
        """The estimate of a built-in estimator at some samples, by increasing numbers, or at all N."""
        function = self.function(estimator)
        rows = np.arange(len(self.readings)) if samples is None else samples
        return estimates_at(function, rows, *self._inputs(function))

    def arguments(self, function: ShapeFunction, rows: NDArray[np.int_]) -> tuple[Any, ...]:
        """Arguments of an estimator without memory at times of the recording, (M), by their numbers."""
        return samples_at(self.numbers[rows], *self._inputs(function))

    def driving(self, estimator: str = "arcs") -> Array:
        """The driving torque of the finger, with creep computed from an estimator's shapes, N m, (N, D)."""
        return self._driving(self.function(estimator))

    def function(self, estimator: str) -> ShapeFunction:
        """A built-in estimator of this finger."""
        return estimator_function(estimator, self.layout, self.uncertainty, self.period)

    def _inputs(self, function: ShapeFunction) -> tuple[Any, ...]:
        return recorded_inputs(function, self.readings, self._driving(function), self.gravity, self._pull)

    def _driving(self, function: ShapeFunction) -> Array:
        if self.torque is not None:
            return self.torque
        samples = self.readings, self.pressure, self.gravity
        return recorded_driving(function, self.layout.finger, *samples, self.period, self._pull)

    @property
    def _pull(self) -> Array:
        """Gravity less the acceleration of the base, in B, (N, 3) m/s^2."""
        acceleration = base_acceleration(self.X_WB, self.layout.finger.length, self.period)
        return to_base(self.X_WB, self.gravity_world - acceleration)


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
    simulated = with_sections(sensor_layout(finger.finger, station.scenario.sensor), sections, borders)
    readings = simulated.read(recording.samples(f"{finger.name}.sampled_joint_angles"))
    same_layout = _measured(station, recording, finger, readings)
    return replace(same_layout, layout=with_sections(same_layout.layout, sections, borders))


def read_recorded(station: Station, recording: Recording, finger: PlantFinger) -> ReadAgain | None:
    """The readings and the driving torque as recorded.

    None if sensors of the user's own give no readings as the scenario's sensors would.
    """
    layout = read_nominal_model(station.scenario.nominal).layout(finger.finger, station.scenario.sensor)
    name, joints = f"{finger.name}.{layout.quantity}", finger.finger.segments
    if name not in recording or recording[name].size != layout.readings * len(recording.sample_numbers):
        return None
    readings = recording.samples(name).reshape(-1, layout.readings)
    ports = [f"{finger.name}.{driving_port(deformation)}" for deformation in layout.deformations]
    zeros = np.zeros((len(readings), joints))
    torques = [recording.samples(port) if port in recording else zeros for port in ports]
    return replace(_measured(station, recording, finger, readings), torque=np.concatenate(torques, axis=-1))


def _measured(station: Station, recording: Recording, finger: PlantFinger, readings: Array) -> ReadAgain:
    scenario, pressure = station.scenario, f"{finger.name}.sampled_pressure"
    layout = read_nominal_model(scenario.nominal).layout(finger.finger, scenario.sensor)
    return ReadAgain(
        layout,
        uncertainty(scenario.estimator, scenario.sensor, layout.calibrated),
        readings,
        recording.samples(pressure) if pressure in recording else np.zeros((len(readings), 0)),
        recording.samples(f"{finger.name}.X_WB"),
        compensated_gravity(scenario),
        scenario.sensor.period,
        recording.sample_numbers,
    )


def with_sections(
    layout: MeasurementModel, sections: int, borders: tuple[float, ...] | None = None
) -> MeasurementModel:
    """The sensors with so many sections: with these borders, or unchanged if the number agrees, or equally long."""
    as_is = sections == layout.sections and borders is None
    return layout if as_is else replace(layout, sections=sections, borders=borders)


def external_torque_again(
    station: Station, recording: Recording, finger: PlantFinger, readings: ReadAgain, estimator: str = "arcs"
) -> Array:
    """The external torque for these readings at every time of the recording, N m, (T, N); NaN until there are five."""
    shape, X_WB = readings.estimate(estimator), recording.samples(f"{finger.name}.X_WB")
    torque = shape.external_torque
    if torque is None:
        balance = TorqueBalance(readings.layout.finger)
        motion = Motion(*map(windows, balance.samples(shape.q, readings.driving(estimator), X_WB)))
        known = balance.external_torque(motion, compensated_gravity(station.scenario), readings.period).torque
        torque = np.concatenate([np.full((SAMPLES - 1, shape.q.shape[-1]), np.nan), known])
    return torque[recording.sample_numbers]


def compensated_gravity(scenario: Scenario) -> Array:
    """Gravity as estimators compensate it, in the world, (3,) m/s^2."""
    return np.array(scenario.gravity) * scenario.estimator.compensate_gravity
