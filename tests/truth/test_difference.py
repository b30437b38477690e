"""Difference: the estimate less the truth."""

import numpy as np

from soft_gripper.signals import signal_of
from soft_gripper.truth.poses import Difference


def test_the_estimate_less_the_truth():
    block = Difference(2, "N m", joint=range(2))
    context = block.CreateDefaultContext()
    block.GetInputPort("estimate").FixValue(context, [3.0, 1.0])
    block.GetInputPort("truth").FixValue(context, [1.0, 4.0])
    np.testing.assert_array_equal(block.get_output_port().Eval(context), [2.0, -3.0])
    assert signal_of(block.get_output_port()).unit == "N m"
