"""PiecewiseLinearBlock: curves through points, all of Drake's C++ primitives."""

import numpy as np
from pydrake.systems.framework import Diagram, DiagramBuilder
from pydrake.systems.primitives import Adder, ConstantVectorSource, MatrixGain, Multiplexer, Saturation

from soft_gripper.piecewise_linear import PiecewiseLinear


class PiecewiseLinearBlock(Diagram):
    """N curves side by side, so that they run at the plant's rate without Python.

    ::

                     +----------------------+
        x (N) -----> | PiecewiseLinearBlock | -----> y (N)
                     +----------------------+

    A piecewise linear curve is a sum: for every piece, its slope times x, held within the piece. So there is one
    Saturation a piece, a MatrixGain of the slopes, and a constant.
    """

    def __init__(self, curves: PiecewiseLinear):
        """The points of the curves have shape (N, M)."""
        super().__init__()
        count, inner = len(curves.x), curves.x[:, 1:-1]
        endless = np.full((count, 1), np.inf)
        lower, upper = np.hstack([-endless, inner]), np.hstack([inner, endless])
        offset = curves(np.zeros(count)) - (curves.slopes * np.clip(0.0, lower, upper)).sum(axis=1)
        builder = DiagramBuilder()
        pieces = [Saturation(low, up) for low, up in zip(lower.T, upper.T, strict=True)]
        together = builder.AddNamedSystem("pieces", Multiplexer([count] * len(pieces)))
        weights = np.hstack([np.diag(slope) for slope in curves.slopes.T])
        weighted = builder.AddNamedSystem("slopes", MatrixGain(weights))
        constant = builder.AddNamedSystem("offset", ConstantVectorSource(offset))
        total = builder.AddNamedSystem("sum", Adder(2, count))
        for i, piece in enumerate(pieces):
            builder.AddNamedSystem(f"piece_{i}", piece)
            builder.Connect(piece.get_output_port(), together.get_input_port(i))
            if i == 0:
                builder.ExportInput(piece.get_input_port(), "x")
            else:
                builder.ConnectInput("x", piece.get_input_port())
        builder.Connect(together.get_output_port(), weighted.get_input_port())
        builder.Connect(weighted.get_output_port(), total.get_input_port(0))
        builder.Connect(constant.get_output_port(), total.get_input_port(1))
        builder.ExportOutput(total.get_output_port(), "y")
        builder.BuildInto(self)
