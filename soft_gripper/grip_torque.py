"""GripTorque: what two fingers feel of a thing between them."""

from collections.abc import Sequence

from pydrake.systems.framework import BasicVector, Context, LeafSystem


class GripTorque(LeafSystem):
    """The mean torque that opens two fingers at their base joints; a swing of the palm cancels out in it.

    first_external_torque (N) N m ---> +------------+
                                       | GripTorque | ---> torque  (1) N m
    second_external_torque (N) N m --> +------------+
    """

    def __init__(self, joints: Sequence[int]):
        """`joints` are the numbers of joints of both fingers."""
        super().__init__()
        names = ("first_external_torque", "second_external_torque")
        self._torques = [self.DeclareVectorInputPort(name, count) for name, count in zip(names, joints, strict=True)]
        self.DeclareVectorOutputPort("torque", 1, self._calc_torque, {self.all_input_ports_ticket()})

    def _calc_torque(self, context: Context, output: BasicVector) -> None:
        first, second = (port.Eval(context)[0] for port in self._torques)
        output.SetFromVector([-(first + second) / 2])
