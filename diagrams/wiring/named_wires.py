"""Blocks wired by the names of their ports."""

from collections.abc import Collection, Mapping

from pydrake.systems.framework import Diagram, DiagramBuilder, InputPort, OutputPort, PortDataType, System

from soft_gripper.errors import InputError
from soft_gripper.signals import export_outputs

Ports = dict[str, OutputPort]


def vector_outputs(system: System) -> Ports:
    """The vector output ports of a system, by name."""
    ports = (system.get_output_port(i) for i in range(system.num_output_ports()))
    return {port.get_name(): port for port in ports if port.get_data_type() == PortDataType.kVectorValued}


def inputs(system: System) -> dict[str, InputPort]:
    """The input ports of a system, by name."""
    return {port.get_name(): port for port in map(system.get_input_port, range(system.num_input_ports()))}


def connect_by_name(
    builder: DiagramBuilder, ports: Mapping[str, InputPort], signals: Mapping[str, OutputPort], what: str
) -> None:
    """Connects each input to the signal with its name; `what` names the part for error messages.

    Raises:
        InputError: if there is no such signal, or its size differs.
    """
    for name, port in ports.items():
        if name not in signals:
            article = "an" if what[0] in "aeiou" else "a"
            raise InputError(what, "input port", name, f"{article} {what} may take: {', '.join(signals)}")
        if signals[name].size() != port.size():
            expected = f"the signal with that name has {signals[name].size()} entries"
            raise InputError(what, f"input port '{name}'", port.size(), expected)
        builder.Connect(signals[name], port)


def add_stage(builder: DiagramBuilder, name: str, block: System, source: OutputPort) -> OutputPort:
    """Adds a block with one input, which takes a port; returns its output."""
    builder.Connect(source, builder.AddNamedSystem(name, block).get_input_port())
    return block.get_output_port()


class NamedWires:
    """Wires the blocks of a diagram: an input takes the output with its name from the first block that has it.

    Inputs that no earlier block feeds become inputs of the diagram; all vector outputs become its outputs.
    """

    def __init__(self) -> None:
        self._builder = DiagramBuilder()
        self.outputs = Ports()
        self._exported: set[str] = set()
        self._later: list[tuple[str, InputPort]] = []

    def add(
        self, name: str, block: System, renamed: Mapping[str, str] | None = None, later: Collection[str] = ()
    ) -> None:
        """Adds a block and wires its inputs.

        `renamed` gives ports of the block other names in the diagram; inputs named in `later` take the output of a
        block that is added later.
        """
        self._builder.AddNamedSystem(name, block)
        names = renamed or {}
        for port_name, port in inputs(block).items():
            if port_name in later:
                self._later.append((port_name, port))
            else:
                self._feed(names.get(port_name, port_name), port)
        for port_name, output in vector_outputs(block).items():
            self.outputs.setdefault(names.get(port_name, port_name), output)

    def _feed(self, name: str, port: InputPort) -> None:
        if name in self.outputs:
            self._builder.Connect(self.outputs[name], port)
        elif name in self._exported:
            self._builder.ConnectInput(name, port)
        else:
            self._builder.ExportInput(port, name)
            self._exported.add(name)

    def build_into(self, diagram: Diagram) -> None:
        """Turns the blocks into `diagram`."""
        for name, later in self._later:
            self._builder.Connect(self.outputs[name], later)
        for name, port in self.outputs.items():
            self._builder.ExportOutput(port, name)
        self._builder.BuildInto(diagram)
        export_outputs(diagram, self.outputs)
