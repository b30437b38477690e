"""Sensors and estimators by name: built-in ones, and user-defined ones as "module:function".

A kind of sensor is a class that models the measurements on a finger, made from the finger and the number of sections:

    class Curvature(MeasurementModel): ...

A strain sensor of your own is a system with an input `joint_angles` (N) rad and an output `strain`, the readings;
any other outputs are logged. It may also take `pressure` and `X_WB`. It is made by a function of the sensors on
the finger and their sampling period, s:

    def make(layout: SensorLayout, period: float) -> System

An estimator is a system with an output `estimated_joint_angles` (N) rad, see `FingerShape`. It may take the outputs of
the sensor, `pressure`, `X_WB`, and what drives the nominal finger, `driving_torque` (N) N m. It is made
from the nominal sensors and finger, gravity in the world, m/s^2 (zero without
`estimator.compensate_gravity`), and the period:

    def make(layout: MeasurementModel, gravity: Array, period: float) -> System

`module:function` is imported from Python's path and the current folder, not from the folder of the scenario: an
untrusted scenario cannot bring its own code.
"""

from collections.abc import Callable
from typing import Any

from pydrake.systems.framework import System

from soft_gripper.arrays import Array
from soft_gripper.errors import InputError
from soft_gripper.estimators.recursive import RecursiveEstimator, RecursiveShape
from soft_gripper.estimators.shape_estimator import ShapeEstimator
from soft_gripper.estimators.shape_functions import SHAPE_FUNCTIONS, spatial_function
from soft_gripper.estimators.spatial_estimator import SpatialEstimator
from soft_gripper.estimators.spatial_recursive import SpatialRecursiveEstimator, SpatialRecursiveShape
from soft_gripper.estimators.uncertainty import Uncertainty
from soft_gripper.scenario.own_functions import find_named, made
from soft_gripper.sensors.measurement import MeasurementModel

MakeEstimator = Callable[[MeasurementModel, Array, float], System]

_IN_USE = "_soft_gripper_in_use"  # attribute of a block that is part of a diagram


def find_estimator(name: str, uncertainty: Uncertainty | None = None, field: str = "estimator.type") -> MakeEstimator:
    """The estimator of a name.

    Args:
        name: a built-in one, or "module:function".
        uncertainty: for built-in estimators that weight their inputs; None: the defaults.
        field: the field of the scenario that names it.

    Raises:
        InputError: if there is none.
    """
    own = {kind: _of_function(kind, uncertainty or Uncertainty()) for kind in SHAPE_FUNCTIONS}
    found: MakeEstimator = find_named(field, name, own)
    return found


def _of_function(kind: str, uncertainty: Uncertainty) -> MakeEstimator:
    """A block around an estimator that is a function of arrays."""

    def make(layout: MeasurementModel, gravity: Array, period: float) -> System:
        if layout.ways != ("bending",):
            spatial = spatial_function(kind, layout, uncertainty, period)
            if isinstance(spatial, SpatialRecursiveShape):
                return SpatialRecursiveEstimator(spatial, gravity)
            return SpatialEstimator(spatial, layout, gravity)
        function = SHAPE_FUNCTIONS[kind](layout, uncertainty, period)
        if isinstance(function, RecursiveShape):
            return RecursiveEstimator(function, gravity)
        return ShapeEstimator(function, layout, gravity)

    return make


def make_block(field: str, name: str, make: Callable[..., System], *arguments: Any) -> System:
    """The block that a function makes from its arguments.

    Args:
        field: the scenario field or option that names the function.
        name: a built-in block, or a user's "module:function", see `name_of`.
        make: the function.
        arguments: its arguments.

    Raises:
        InputError: if it fails, does not return a system, or returns a block that it returned before.
    """
    block = made(field, name, make, *arguments)
    if not isinstance(block, System):
        raise InputError("scenario", field, name, f"returned {type(block).__name__}; return a Drake System")
    if hasattr(block, _IN_USE):
        raise InputError("scenario", field, name, "returned the same block twice; make a new one for each finger")
    setattr(block, _IN_USE, True)
    return block


def name_of(make: Callable[..., System] | None, type_name: str) -> str:
    """The name of a block in tables, recordings and messages: a user's function, or the type in the scenario."""
    return type_name if make is None else f"{make.__module__}:{getattr(make, '__qualname__', repr(make))}"
