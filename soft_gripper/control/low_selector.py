"""LowSelector: of two controllers, the one that asks for less is selected."""

from pydrake.systems.framework import BasicVector, Context, LeafSystem


class LowSelector(LeafSystem):
    """Override control: puts out the smaller of two inputs.

    ::

        first (1) ----> +-------------+
                        | LowSelector | ---> selected  (1)
        second (1) ---> +-------------+
    """

    def __init__(self) -> None:
        super().__init__()
        self._ports = [self.DeclareVectorInputPort(name, 1) for name in ("first", "second")]
        self.DeclareVectorOutputPort("selected", 1, self._select, {self.all_input_ports_ticket()})

    def _select(self, context: Context, output: BasicVector) -> None:
        output.SetFromVector([min(port.Eval(context)[0] for port in self._ports)])
