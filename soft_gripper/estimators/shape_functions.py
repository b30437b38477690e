"""The estimators of this project by name.

One block holds any of these functions; `arcs` and `recursive`, which have more outputs or more memory, have blocks of
their own. Evaluation, contact trials and placement call the functions on recordings.
"""

from typing import Protocol

from soft_gripper.errors import InputError
from soft_gripper.estimators.arc_shapes import ArcShape, ConstantCurvatureShape
from soft_gripper.estimators.contact import ContactShape
from soft_gripper.estimators.estimate import ShapeFunction
from soft_gripper.estimators.gaussian import GaussianShape
from soft_gripper.estimators.recursive import RecursiveShape
from soft_gripper.estimators.spatial_contact import SpatialContactShape
from soft_gripper.estimators.spatial_curvature import SpatialCurvatureShape
from soft_gripper.estimators.spatial_estimator import SpatialFunction
from soft_gripper.estimators.spatial_gaussian import SpatialGaussianShape
from soft_gripper.estimators.spatial_recursive import SpatialRecursiveShape
from soft_gripper.estimators.spline import SplineShape
from soft_gripper.estimators.uncertainty import Uncertainty
from soft_gripper.sensors.measurement import MeasurementModel
from soft_gripper.sensors.sensor_layout import strain_sensors


class MakeShapeFunction(Protocol):
    """Makes an estimator of the nominal sensors and finger, for samples `period` s apart."""

    def __call__(self, layout: MeasurementModel, uncertainty: Uncertainty, period: float = 0.01) -> ShapeFunction: ...


SHAPE_FUNCTIONS: dict[str, MakeShapeFunction] = {
    "arcs": lambda layout, uncertainty, period=0.01: ArcShape(strain_sensors(layout, "estimator arcs")),
    "spline": lambda layout, uncertainty, period=0.01: SplineShape(layout),
    "gaussian": lambda layout, uncertainty, period=0.01: GaussianShape(layout, uncertainty),
    "contact": lambda layout, uncertainty, period=0.01: ContactShape(layout, uncertainty, period),
    "recursive": RecursiveShape,
    "constant_curvature": lambda layout, uncertainty, period=0.01: ConstantCurvatureShape(
        strain_sensors(layout, "estimator constant_curvature")
    ),
}


class MakeSpatialFunction(Protocol):
    """Makes an estimator as MakeShapeFunction does, of a finger that leaves its plane."""

    def __call__(self, layout: MeasurementModel, uncertainty: Uncertainty, period: float = 0.01) -> SpatialFunction: ...


SPATIAL_FUNCTIONS: dict[str, MakeSpatialFunction] = {
    "gaussian": lambda layout, uncertainty, period=0.01: SpatialGaussianShape(layout, uncertainty),
    "contact": lambda layout, uncertainty, period=0.01: SpatialContactShape(layout, uncertainty, period),
    "recursive": SpatialRecursiveShape,
    "constant_curvature": lambda layout, uncertainty, period=0.01: SpatialCurvatureShape(layout, uncertainty),
}


def spatial_function(
    name: str, layout: MeasurementModel, uncertainty: Uncertainty, period: float = 0.01
) -> SpatialFunction:
    """An estimator of the shape in space, of the nominal sensors and of a finger that leaves its plane.

    `period` is that of the samples, s.

    Raises:
        InputError: if the estimator knows the bending plane alone.
    """
    if name not in SPATIAL_FUNCTIONS:
        known = ", ".join(SPATIAL_FUNCTIONS)
        expected = f"knows the bending plane alone: choose {known} for sensors that see a finger in space"
        raise InputError("estimator", "type", name, expected)
    return SPATIAL_FUNCTIONS[name](layout, uncertainty, period)
