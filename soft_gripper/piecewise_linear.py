"""Piecewise linear curves through points, straight on beyond their ends, with exact inverses.

An elastic law or a pressure law in a plant is a sum of Saturations, one per piece, so that it runs in C++ at the
plant's rate.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from pydrake.systems.framework import Diagram, DiagramBuilder
from pydrake.systems.primitives import Adder, ConstantVectorSource, MatrixGain, Multiplexer, Saturation

from soft_gripper.arrays import Array
from soft_gripper.errors import InputError


@dataclass(frozen=True, eq=False)
class PiecewiseLinear:
    """One curve through M points, or N curves side by side, each through its own M points.

    `x` and `y` have shape (M,) or (N, M); x increases strictly along the last axis, and so must y for the
    inverse.
    """

    x: Array
    y: Array

    def __post_init__(self) -> None:
        """
        Raises:
            InputError: unless there are two points or more, as many `x` as `y`, and `x` increases.
        """
        x, y = np.asarray(self.x), np.asarray(self.y)
        fits = x.dtype.kind in "fi" and y.dtype.kind in "fi" and x.shape == y.shape and x.ndim in (1, 2)
        if not fits or x.shape[-1] < 2 or not (np.diff(x) > 0).all():
            expected = "give x and y of one shape, with two or more points, and x that increases strictly"
            raise InputError("curve", "points", (self.x, self.y), expected)

    @cached_property
    def slopes(self) -> Array:
        """Slopes of the pieces, (M - 1,) or (N, M - 1)."""
        return np.diff(self.y) / np.diff(self.x)

    def __call__(self, x: Array) -> Array:
        """Values at `x` of any shape; with N curves side by side, its last axis counts them."""
        if self._line is not None:
            x0, y0, slope = self._line
            return y0 + slope * (x - x0)
        start = self._piece(x)
        return self.y[start] + self.slopes[start] * (x - self.x[start])

    def slope(self, x: Array) -> Array:
        """Slopes at `x`, shaped as for the values; at a corner, of the piece before it."""
        return self.slopes[self._piece(x)]

    def _piece(self, x: Array) -> tuple[NDArray[np.int_], ...]:
        """Index of the piece that each `x` lies in."""
        piece = (x[..., None] > self.x[..., 1:-1]).sum(axis=-1)
        return (np.arange(len(self.x)), piece) if self.x.ndim == 2 else (piece,)

    @cached_property
    def _line(self) -> tuple[Array, Array, Array] | None:
        """First x, y and slope of each curve, (N,) or (), if there is only one piece; else None."""
        is_single = self.slopes.shape[-1] == 1
        return (self.x[..., 0], self.y[..., 0], self.slopes[..., 0]) if is_single else None

    def inverse(self) -> "PiecewiseLinear":
        """The curve from y back to x."""
        return PiecewiseLinear(self.y, self.x)


class PiecewiseLinearBlock(Diagram):
    """N curves side by side, so that they run at the plant's rate without Python.

    ::

                     +----------------------+
        x (N) -----> | PiecewiseLinearBlock | -----> y (N)
                     +----------------------+

    A piecewise linear curve is a sum: for every piece, its slope times x, held within the piece. So there is one
    Saturation per piece, a MatrixGain of the slopes, and a constant.
    """

    def __init__(self, curves: PiecewiseLinear):
        """The points of the curves have shape (N, M)."""
        super().__init__()
        count, inner = len(curves.x), curves.x[:, 1:-1]
        endless = np.full((count, 1), np.inf)
        lower, upper = np.hstack([-endless, inner]), np.hstack([inner, endless])
        offset = curves(np.zeros(count)) - (curves.slopes * np.clip(0.0, lower, upper)).sum(axis=1)
        builder = DiagramBuilder()
        pieces = [Saturation(low, high) for low, high in zip(lower.T, upper.T, strict=True)]
        multiplexer = builder.AddNamedSystem("pieces", Multiplexer([count] * len(pieces)))
        weights = np.hstack([np.diag(slope) for slope in curves.slopes.T])
        weighted = builder.AddNamedSystem("slopes", MatrixGain(weights))
        constant = builder.AddNamedSystem("offset", ConstantVectorSource(offset))
        total = builder.AddNamedSystem("sum", Adder(2, count))
        for i, piece in enumerate(pieces):
            builder.AddNamedSystem(f"piece_{i}", piece)
            builder.Connect(piece.get_output_port(), multiplexer.get_input_port(i))
            if i == 0:
                builder.ExportInput(piece.get_input_port(), "x")
            else:
                builder.ConnectInput("x", piece.get_input_port())
        builder.Connect(multiplexer.get_output_port(), weighted.get_input_port())
        builder.Connect(weighted.get_output_port(), total.get_input_port(0))
        builder.Connect(constant.get_output_port(), total.get_input_port(1))
        builder.ExportOutput(total.get_output_port(), "y")
        builder.BuildInto(self)
