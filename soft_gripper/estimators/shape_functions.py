"""The estimators of this project by name.

One block holds any of these functions (`ShapeEstimator`). Evaluation, contact trials and placement call them on
recordings.
"""

from typing import Protocol

from soft_gripper.errors import InputError
from soft_gripper.estimators.arc_shapes import ArcShape, ConstantCurvatureShape
from soft_gripper.estimators.contact import ContactShape
from soft_gripper.estimators.estimate import ShapeFunction
from soft_gripper.estimators.gaussian import GaussianShape
from soft_gripper.estimators.recursive import RecursiveShape
from soft_gripper.estimators.spatial_curvature import SpatialCurvatureShape
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
    "constant_curvature": lambda layout, uncertainty, period=0.01: (
        ConstantCurvatureShape(strain_sensors(layout, "estimator constant_curvature"))
        if layout.ways == ("bending",)
        else SpatialCurvatureShape(layout, uncertainty)
    ),
}


IN_SPACE = "gaussian", "contact", "recursive", "constant_curvature"


def shape_function(
    name: str, layout: MeasurementModel, uncertainty: Uncertainty, period: float = 0.01
) -> ShapeFunction:
    """An estimator of the nominal sensors and finger; `period` is that of the samples, s.

    Raises:
        InputError: if the sensors see the finger leave its plane, and the estimator knows that alone.
    """
    if layout.ways != ("bending",) and name not in IN_SPACE:
        expected = f"knows the bending plane alone: choose {', '.join(IN_SPACE)} for sensors that see a finger in space"
        raise InputError("estimator", "type", name, expected)
    return SHAPE_FUNCTIONS[name](layout, uncertainty, period)
