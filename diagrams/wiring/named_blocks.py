"""Sensors and estimators by name: those of this project, and a user's own as "module:function".

A kind of sensor is a class of what the sensors on a finger measure, made from the finger and the number of sections:

    class Curvature(MeasurementModel): ...

A strain sensor of your own is a system with an input `joint_angles` (N) rad and an output `strain`, the readings;
whatever else it puts out is logged. It may also take `pressure` and `X_WB`. It is made by a function of the sensors on
the finger and the period of their samples, s:

    def make(layout: SensorLayout, period: float) -> System

An estimator is a system with an output `estimated_joint_angles` (N) rad, see `FingerShape`. It may take the outputs of
the sensor, `pressure`, `X_WB`, and what drives the nominal finger, `driving_torque` (N) N m. It is made
from the nominal sensors and finger, gravity in the world, m/s^2 (zero without
`estimator.compensate_gravity`), and the period:

    def make(layout: MeasurementModel, gravity: Array, period: float) -> System

`module:function` is imported from Python's path and the current folder, not from the folder of the scenario: a
scenario from a stranger cannot bring code of its own.
"""

from collections.abc import Callable
from typing import Any

from pydrake.systems.framework import System

from soft_gripper.arrays import Array
from soft_gripper.errors import InputError
from soft_gripper.estimators.recursive import RecursiveEstimator, RecursiveShape
from soft_gripper.estimators.shape_estimator import ShapeEstimator
from soft_gripper.estimators.shape_functions import SHAPE_FUNCTIONS
from soft_gripper.estimators.uncertainty import Uncertainty
from soft_gripper.scenario.own_functions import find_named, made
from soft_gripper.sensors.measurement import MeasurementModel

MakeEstimator = Callable[[MeasurementModel, Array, float], System]

_IN_USE = "_soft_gripper_in_use"  # attribute of a block that is part of a diagram


def find_estimator(name: str, uncertainty: Uncertainty | None = None, field: str = "estimator.type") -> MakeEstimator:
    """The estimator of a name.

    Args:
        name: of one of this project, or "module:function".
        uncertainty: for those of this project that weigh what they know; None: the defaults.
        field: of a scenario, that names it.

    Raises:
        InputError: if there is none.
    """
    own = {kind: _of_function(kind, uncertainty or Uncertainty()) for kind in SHAPE_FUNCTIONS}
    found: MakeEstimator = find_named(field, name, own)
    return found


def _of_function(kind: str, uncertainty: Uncertainty) -> MakeEstimator:
    """A block around an estimator that is a function of arrays."""

    def make(layout: MeasurementModel, gravity: Array, period: float) -> System:
        function = SHAPE_FUNCTIONS[kind](layout, uncertainty, period)
        if isinstance(function, RecursiveShape):
            return RecursiveEstimator(function, gravity)
        return ShapeEstimator(function, layout, gravity)

    return make


def make_block(field: str, name: str, make: Callable[..., System], *arguments: Any) -> System:
    """The block that a function makes of its arguments.

    Args:
        field: of a scenario, or option, that names the function.
        name: of a block of this project, or a user's "module:function", see `name_of`.
        make: the function.
        arguments: of it.

    Raises:
        InputError: if it fails, or makes no system, or a block that it has made before.
    """
    block = made(field, name, make, *arguments)
    if not isinstance(block, System):
        raise InputError("scenario", field, name, f"made a {type(block).__name__}; a Drake System is needed")
    if hasattr(block, _IN_USE):
        raise InputError("scenario", field, name, "returned the same block twice; make a new one for every finger")
    setattr(block, _IN_USE, True)
    return block


def name_of(make: Callable[..., System] | None, type_name: str) -> str:
    """What a block is called in tables, recordings and messages: a user's function, or the type of a scenario."""
    return type_name if make is None else f"{make.__module__}:{getattr(make, '__qualname__', repr(make))}"
