"""The estimators of this project by name."""

from collections.abc import Callable

from soft_gripper.estimators.arc_shape import ArcShape
from soft_gripper.estimators.contact_shape import ContactShape
from soft_gripper.estimators.gaussian import GaussianShape
from soft_gripper.estimators.spline import SplineShape
from soft_gripper.sensors.sensor_layout import SensorLayout
from soft_gripper.shape.estimate import ShapeFunction
from soft_gripper.shape.uncertainty import Uncertainty

SHAPE_FUNCTIONS: dict[str, Callable[[SensorLayout, Uncertainty], ShapeFunction]] = {
    "arcs": lambda layout, uncertainty: ArcShape(layout),
    "spline": lambda layout, uncertainty: SplineShape(layout),
    "gaussian": GaussianShape,
    "contact": ContactShape,
}
