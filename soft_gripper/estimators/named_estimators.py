"""Estimators by name, those of this project and a user's own: as functions of arrays, and as blocks of a diagram.

An estimator is a system with an output `estimated_joint_angles` (N) rad, see `FingerShape`. It may take the outputs of
the sensor, `pressure`, `X_WB`, and what drives the nominal finger, `driving_torque` (N) N m. It is made
from the nominal sensors and finger, gravity in the world, m/s^2 (zero without
`estimator.compensate_gravity`), and the period:

    def make(layout: MeasurementModel, gravity: Array, period: float) -> System

One that makes a ShapeEstimator, around a function of arrays, can be used on all samples of a recording at once as well:
evaluation and contact trials do. All estimators of this project are such functions.
"""

from collections.abc import Callable
from typing import Any

import numpy as np
from pydrake.systems.framework import System

from soft_gripper.arrays import Array
from soft_gripper.errors import InputError
from soft_gripper.estimators.arc_pose_estimator import ArcPoseEstimator
from soft_gripper.estimators.arc_shapes import ArcShape, ConstantCurvatureShape
from soft_gripper.estimators.contact import ContactShape
from soft_gripper.estimators.estimate import ShapeFunction
from soft_gripper.estimators.gaussian import GaussianShape
from soft_gripper.estimators.recursive import RecursiveShape
from soft_gripper.estimators.shape_estimator import ShapeEstimator
from soft_gripper.estimators.spatial_curvature import SpatialCurvatureShape
from soft_gripper.estimators.spline import SplineShape
from soft_gripper.estimators.uncertainty import Uncertainty
from soft_gripper.registry import Registry, make_block
from soft_gripper.sensors.measurement import MeasurementModel
from soft_gripper.sensors.sensor_layout import strain_sensors

MakeEstimator = Callable[[MeasurementModel, Array, float], System]
OPTION = "--estimator"
# Makers of functions of the nominal sensors and finger, the uncertainty, and the period of the samples, 0.01 s if left
# out. A user's own is a MakeEstimator.
SHAPE_FUNCTIONS = Registry[Callable[..., ShapeFunction]](
    "estimator.type",
    {
        "arcs": lambda layout, uncertainty, period=0.01: ArcShape(strain_sensors(layout, "estimator arcs")),
        "spline": lambda layout, uncertainty, period=0.01: SplineShape(layout),
        "gaussian": lambda layout, uncertainty, period=0.01: GaussianShape(layout, uncertainty, period),
        "contact": lambda layout, uncertainty, period=0.01: ContactShape(layout, uncertainty, period),
        "recursive": RecursiveShape,
        "constant_curvature": lambda layout, uncertainty, period=0.01: (
            ConstantCurvatureShape(strain_sensors(layout, "estimator constant_curvature"))
            if layout.deformations == ("bending",)
            else SpatialCurvatureShape(layout, uncertainty, period)
        ),
    },
)
IN_SPACE = "gaussian", "contact", "recursive", "constant_curvature"


def find_estimator(name: str, uncertainty: Uncertainty | None = None, field: str = "estimator.type") -> MakeEstimator:
    """Finds an estimator by its name.

    Args:
        name: a built-in one, or "module:function".
        uncertainty: for built-in estimators that weight their inputs; None: the defaults.
        field: the field of the scenario that names it.

    Raises:
        InputError: if there is none.
    """
    estimator: Any = SHAPE_FUNCTIONS.find(name, field)
    if name not in SHAPE_FUNCTIONS:
        return estimator

    def make(layout: MeasurementModel, gravity: Array, period: float) -> System:
        function = estimator_function(name, layout, uncertainty or Uncertainty(), period)
        if isinstance(function, ArcShape):
            return ArcPoseEstimator(layout, gravity)
        return ShapeEstimator(function, layout, gravity)

    return make


def estimator_function(
    name: str, layout: MeasurementModel, uncertainty: Uncertainty, period: float = 0.01
) -> ShapeFunction:
    """The estimator of a name as a function, of the nominal sensors and finger, for samples `period` s apart.

    Raises:
        InputError: if there is none, it does not know a finger that leaves its plane, or makes no ShapeEstimator.
    """
    if name not in SHAPE_FUNCTIONS:
        no_gravity = np.zeros(3)  # the function receives gravity for each sample
        block = make_block(OPTION, name, find_estimator(name, field=OPTION), layout, no_gravity, period)
        if not isinstance(block, ShapeEstimator):
            expected = f"made a {type(block).__name__}; return a ShapeEstimator, which takes many samples at once"
            raise InputError("estimator", OPTION, name, expected)
        return block.function
    if layout.deformations != ("bending",) and name not in IN_SPACE:
        expected = f"knows the bending plane alone: choose {', '.join(IN_SPACE)} for sensors that see a finger in space"
        raise InputError("estimator", "type", name, expected)
    return SHAPE_FUNCTIONS[name](layout, uncertainty, period)
