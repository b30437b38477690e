"""GripTorque: the torque that an object between the fingers exerts on them."""

from collections.abc import Mapping

from pydrake.systems.framework import BasicVector, Context, LeafSystem

from soft_gripper.signals import describe


class GripTorque(LeafSystem):
    """The mean torque that opens the fingers of a gripper at their base joints; a swing of the palm across cancels out.

    ::

        {finger}.external_torque (N) N m ---> GripTorque ---> torque  (1) N m
    """

    def __init__(self, joints: Mapping[str, int]):
        """`joints` are the numbers of joints of the fingers, by their names."""
        super().__init__()
        self._torques = [self.DeclareVectorInputPort(f"{name}.external_torque", n) for name, n in joints.items()]
        port = self.DeclareVectorOutputPort("torque", 1, self._calc_torque, {self.all_input_ports_ticket()})
        describe(port, "N m")

    def _calc_torque(self, context: Context, output: BasicVector) -> None:
        torques = [port.Eval(context)[0] for port in self._torques]
        output.SetAtIndex(0, -sum(torques) / len(torques))
