"""The block of piecewise linear curves gives the values of the curves, and holds Drake's systems alone."""

import numpy as np
import pytest

from soft_gripper.piecewise_linear import PiecewiseLinear, PiecewiseLinearBlock

X = np.array([[-2.0, -0.5, 0.25, 3.0], [0.0, 1.0, 2.0, 3.0], [-3.0, -2.0, -1.0, -0.5]])
Y = np.array([[-7.0, -1.0, 0.5, 0.75], [1.0, 1.0, 5.0, 4.0], [3.0, 2.0, 1.0, 8.0]])


@pytest.mark.parametrize("points", [2, 3, 4])
def test_block_is_its_curves(points):
    curves = PiecewiseLinear(X[:, :points], Y[:, :points])
    block = PiecewiseLinearBlock(curves)
    context = block.CreateDefaultContext()
    for x in [np.zeros(3), *np.random.default_rng(1).uniform(-6, 6, (200, 3))]:
        block.GetInputPort("x").FixValue(context, x)
        np.testing.assert_allclose(block.GetOutputPort("y").Eval(context), curves(x), atol=1e-12)
    assert {type(system).__module__ for system in block.GetSystems()} == {"pydrake.systems.primitives"}
