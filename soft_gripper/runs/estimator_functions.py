"""Estimators as functions of arrays, by name: built-in ones, and user-defined ones.

A user's estimator is named as in a scenario, "module:function", which makes the same block: a ShapeEstimator around a
function that takes all samples of a recording at once.
"""

import numpy as np

from soft_gripper.diagrams.wiring.named_blocks import find_estimator, make_block
from soft_gripper.errors import InputError
from soft_gripper.estimators.estimate import ShapeFunction
from soft_gripper.estimators.shape_estimator import ShapeEstimator
from soft_gripper.estimators.shape_functions import SHAPE_FUNCTIONS
from soft_gripper.estimators.uncertainty import Uncertainty
from soft_gripper.sensors.measurement import MeasurementModel

OPTION = "--estimator"


def estimator_function(
    name: str, layout: MeasurementModel, uncertainty: Uncertainty, period: float = 0.01
) -> ShapeFunction:
    """The estimator of a name, of the nominal sensors and finger, for samples `period` s apart.

    Raises:
        InputError: if there is none, or it does not make a ShapeEstimator.
    """
    if name in SHAPE_FUNCTIONS:
        return SHAPE_FUNCTIONS[name](layout, uncertainty, period)
    no_gravity = np.zeros(3)  # the function receives gravity for each sample
    block = make_block(OPTION, name, find_estimator(name, field=OPTION), layout, no_gravity, period)
    if not isinstance(block, ShapeEstimator):
        expected = f"made a {type(block).__name__}; return a ShapeEstimator, which takes many samples at once"
        raise InputError("estimator", OPTION, name, expected)
    return block.function
