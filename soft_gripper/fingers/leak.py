"""Leak: chambers that lose a share of their pressure from a time on."""

from pydrake.systems.framework import BasicVector, Context, LeafSystem

from soft_gripper.arrays import Array
from soft_gripper.cached import weakly
from soft_gripper.run_begin import since_begin


class Leak(LeafSystem):
    """Pressure that is left behind a leak.

    ::

        pressure (C) Pa ---> Leak ---> pressure_left (C) Pa
    """

    def __init__(self, shares: Array, time: float):
        """Loses the `shares`, (C), from `time` s after the beginning of a run on."""
        super().__init__()
        self._since_begin = since_begin(self)
        self._left, self._time = 1 - shares, time
        port = self.DeclareVectorInputPort("pressure", len(shares))
        tickets = {port.ticket(), self.time_ticket(), self.xd_ticket()}
        self.DeclareVectorOutputPort("pressure_left", len(shares), weakly(self._calc), tickets)

    def _calc(self, context: Context, output: BasicVector) -> None:
        output.SetFromVector(self.left(self.GetInputPort("pressure").Eval(context), self._since_begin(context)))

    def left(self, pressure: Array, time: float) -> Array:
        """Pressures behind the leak, (..., C) Pa, `time` s after the beginning of a run."""
        return pressure * self._left if time >= self._time else pressure
