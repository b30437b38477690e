"""GripForce: the force with which a gripper holds an object."""

import math
from collections.abc import Iterable

from pydrake.systems.framework import BasicVector, Context, LeafSystem

from soft_gripper.signals import describe


class GripForce(LeafSystem):
    """The mean estimated contact force of the fingers of a gripper, which holds with it from all sides.

    ::

        {finger}.contact_force (1) N ---> GripForce ---> force  (1) N

    A force that is not known, NaN, makes the mean NaN.
    """

    def __init__(self, fingers: Iterable[str]):
        """`fingers` are their names."""
        super().__init__()
        self._forces = [self.DeclareVectorInputPort(f"{name}.contact_force", 1) for name in fingers]
        port = self.DeclareVectorOutputPort("force", 1, self._calc_force, {self.all_input_ports_ticket()})
        describe(port, "N")

    def _calc_force(self, context: Context, output: BasicVector) -> None:
        forces = [float(port.Eval(context)[0]) for port in self._forces]
        output.SetAtIndex(0, math.fsum(forces) / len(forces))
