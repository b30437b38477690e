"""Applies our sensors and estimators to the joint angles of another simulator, for many environments at once.

An exported file has neither. Sensors and estimators are functions of arrays, so that one call serves all environments
and all times: leading axes are free. D joint positions are those of each deformation that the sensors see
(`MeasurementModel.deformations`), N each; R readings, C chambers.
"""

from dataclasses import dataclass

import numpy as np

from soft_gripper.arrays import Array
from soft_gripper.diagrams.station import make_station
from soft_gripper.errors import InputError
from soft_gripper.estimators.estimate import ShapeEstimate, ShapeFunction
from soft_gripper.estimators.named_estimators import estimator_function
from soft_gripper.estimators.plane import to_base
from soft_gripper.estimators.recursive import RecursiveShape
from soft_gripper.extras.export.tree import scoped_name
from soft_gripper.fingers.plant_finger import PlantFinger
from soft_gripper.runs.scores.readings import compensated_gravity
from soft_gripper.scenario.nominal_model import read_nominal_model
from soft_gripper.scenario.schema import Scenario
from soft_gripper.scenario.sensor_presets import sensor_layout, uncertainty
from soft_gripper.sensors.measurement import MeasurementModel


@dataclass(frozen=True)
class SensedFinger:
    """The sensors of a finger, without errors, and the estimator that its scenario names; both have no memory."""

    joints: tuple[str, ...]  # (D,) as the exported MJCF names them
    sensors: MeasurementModel
    nominal: MeasurementModel  # finger and sensors as the estimator assumes them
    function: ShapeFunction
    gravity: Array  # (3,) m/s^2 in the world, as the estimator compensates it
    X_WB: Array  # (3, 4) [R | p], its base where a run begins

    def read(self, q: Array) -> Array:
        """Readings of the sensors, (..., D) rad, or m where joints slide -> (..., R).

        Raises:
            InputError: if there are not D joints.
        """
        _check_shape("joint positions", q, len(self.joints))
        return self.sensors.read(np.asarray(q, dtype=float))

    def estimate(self, readings: Array, pressure: Array, X_WB: Array | None = None) -> ShapeEstimate:
        """Estimates shape and load.

        Args:
            readings: of the sensors, (..., R); NaN where there is none.
            pressure: in the chambers, (..., C) Pa.
            X_WB: pose of the base in the world, (..., 3, 4) [R | p]; None: that in which a run begins.

        Raises:
            InputError: if there are not R readings or not C chambers.
        """
        finger = self.nominal.finger
        names = self.nominal.deformations
        _check_shape("readings", readings, self.nominal.readings)
        _check_shape("pressure", pressure, finger.pressures)
        pose = np.broadcast_to(self.X_WB if X_WB is None else X_WB, (*np.shape(readings)[:-1], 3, 4))
        zeros = np.zeros((*np.shape(pressure)[:-1], finger.segments))
        torques = [
            finger.torque_of_drive(name, np.asarray(pressure)) if name in finger.driven_deformations else zeros
            for name in names
        ]
        gravity = to_base(pose, self.gravity)
        return self.function(np.asarray(readings), np.concatenate(torques, axis=-1), gravity)


def _check_shape(name: str, values: Array, count: int) -> None:
    if np.shape(values)[-1:] != (count,):
        raise InputError("sensed finger", name, np.shape(values), f"the last axis must have {count} entries")


def sensed_fingers(scenario: Scenario) -> dict[str, SensedFinger]:
    """Makes the fingers of a scenario by name, with its sensors, nominal model and estimator.

    Raises:
        InputError: if the scenario cannot be built, or the estimate depends on the past: because a finger creeps
            or the estimator filters or zeroes its sensors; or a finger has tendons.
    """
    return {finger.name: _sensed_finger(finger, scenario) for finger in make_station(scenario).fingers}


def _sensed_finger(finger: PlantFinger, scenario: Scenario) -> SensedFinger:
    nominal = read_nominal_model(scenario.nominal).layout(finger.finger, scenario.sensor)
    declared = uncertainty(scenario.estimator, scenario.sensor, nominal.calibrated)
    function = estimator_function(scenario.estimator.type, nominal, declared)
    if isinstance(function, RecursiveShape):
        expected = "depends on all samples before: choose arcs, spline, gaussian, contact or constant_curvature"
        raise InputError("sensed finger", "estimator.type", scenario.estimator.type, expected)
    if declared.free_pressure > 0:
        expected = "zeroes sensors by the samples before: set it to 0"
        raise InputError("sensed finger", "estimator.uncertainty.free_pressure", declared.free_pressure, expected)
    for part, is_given in (
        ("creep", "creeps, and remembers how it was bent"),
        ("tendons", "has them; give one with chambers"),
    ):
        if entries := getattr(nominal.finger, part):
            raise InputError("sensed finger", part, len(entries), f"finger '{finger.name}' {is_given}")
    gravity = compensated_gravity(scenario)
    joints = [scoped_name(joint) for deformation in nominal.deformations for joint in finger.joints_of(deformation)]
    sensors = sensor_layout(finger.finger, scenario.sensor)
    return SensedFinger(tuple(joints), sensors, nominal, function, gravity, finger.X_WB.GetAsMatrix34())
