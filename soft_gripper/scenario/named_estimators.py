"""Estimators by name, those of this project and a user's own: as blocks of a diagram, and as functions of arrays.

An estimator is a system with an output `estimated_joint_angles` (N) rad, see `FingerShape`. It may take the outputs of
the sensor, `pressure`, `X_WB`, and what drives the nominal finger, `driving_torque` (N) N m. It is made
from the nominal sensors and finger, gravity in the world, m/s^2 (zero without
`estimator.compensate_gravity`), and the period:

    def make(layout: MeasurementModel, gravity: Array, period: float) -> System

One that makes a ShapeEstimator, around a function of arrays, can be used on all samples of a recording at once as well.
"""

from collections.abc import Callable

import numpy as np
from pydrake.systems.framework import System

from soft_gripper.arrays import Array
from soft_gripper.errors import InputError
from soft_gripper.estimators.estimate import ShapeFunction
from soft_gripper.estimators.shape_estimator import ShapeEstimator
from soft_gripper.estimators.shape_functions import SHAPE_FUNCTIONS, shape_function
from soft_gripper.estimators.uncertainty import Uncertainty
from soft_gripper.scenario.own_functions import find_named, make_block
from soft_gripper.sensors.measurement import MeasurementModel

MakeEstimator = Callable[[MeasurementModel, Array, float], System]
OPTION = "--estimator"


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
        return ShapeEstimator(shape_function(kind, layout, uncertainty, period), layout, gravity)

    return make


def estimator_function(
    name: str, layout: MeasurementModel, uncertainty: Uncertainty, period: float = 0.01
) -> ShapeFunction:
    """The estimator of a name as a function, of the nominal sensors and finger, for samples `period` s apart.

    Raises:
        InputError: if there is none, it does not know a finger that leaves its plane, or makes no ShapeEstimator.
    """
    if name in SHAPE_FUNCTIONS:
        return shape_function(name, layout, uncertainty, period)
    no_gravity = np.zeros(3)  # the function receives gravity for each sample
    block = make_block(OPTION, name, find_estimator(name, field=OPTION), layout, no_gravity, period)
    if not isinstance(block, ShapeEstimator):
        expected = f"made a {type(block).__name__}; return a ShapeEstimator, which takes many samples at once"
        raise InputError("estimator", OPTION, name, expected)
    return block.function
