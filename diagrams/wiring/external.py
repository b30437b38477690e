"""External commands of a station, applied: input ports that replace the commands of a scenario."""

from typing import NamedTuple

from pydrake.systems.framework import DiagramBuilder, InputPort, OutputPort
from pydrake.systems.primitives import PassThrough

from soft_gripper.diagrams.wiring.drive import Commands
from soft_gripper.signals import describe


class External(NamedTuple):
    """The inputs of commands and the resulting signals, by name."""

    inputs: dict[str, InputPort]
    signals: dict[str, OutputPort]


def add_external_drive(builder: DiagramBuilder, commands: Commands) -> External:
    """Adds `{finger}.{kind}_command` for each command, such as `left_finger.pressure_command`, (C) Pa."""
    external = External({}, {})
    for finger, command in commands.inputs.items():
        added = add_input(builder, f"{finger}.{commands.kind}_command", command)
        external.inputs.update(added.inputs)
        external.signals.update({name: commands.described(finger, port) for name, port in added.signals.items()})
    return external


def add_input(builder: DiagramBuilder, name: str, target: InputPort, unit: str | None = None) -> External:
    """Adds an input of that name, in a unit, which commands `target`."""
    pass_through = builder.AddNamedSystem(name, PassThrough(target.size()))
    builder.Connect(pass_through.get_output_port(), target)
    signal = pass_through.get_output_port()
    return External({name: pass_through.get_input_port()}, {name: signal if unit is None else describe(signal, unit)})
