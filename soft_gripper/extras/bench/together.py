"""Equal fingers computed together: one block for all of them, whose functions take a leading axis of fingers.

A small numpy operation costs as much for two fingers as for one, so that two together cost little more than one.
"""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from pydrake.systems.framework import Context, Diagram, DiagramBuilder

from soft_gripper.array_block import ArrayBlock, Constant, Function, Memory, Sample
from soft_gripper.arrays import Array
from soft_gripper.diagrams.wiring.named_wires import Ports, inputs, vector_outputs
from soft_gripper.signals import Signal, signal_of


class Stacked(ArrayBlock):
    """Equal blocks as one, whose ports have those of each in turn.

    ::

        {input} (F x size) ---> +---------+ ---> {output} (F x size)
                                | Stacked |
                                +---------+
    """

    def __init__(self, blocks: Sequence[ArrayBlock]):
        """The `blocks` are equal, see `can_stack`, and in no diagram that is used."""
        first, self._number = blocks[0], len(blocks)
        super().__init__(first.period)
        for name, step in first.steps.items():
            if isinstance(step, Constant):
                self.constant(name, np.array([block.steps[name].value for block in blocks]))  # type: ignore[attr-defined]
            elif isinstance(step, Function):
                self.derive(name, step.of, *step.sources)
            elif isinstance(step, Sample):
                options = {"at_initialization": step.at_initialization, "at_first": step.at_first}
                self.sample(name, step.source, self._each(step.begin).ravel(), **options)
                self._read[name] = self._folded(self._read[name])
            elif isinstance(step, Memory):
                begin, begin_of = self._each(step.begin), step.begin_of
                self.remember(
                    name, step.of, *step.sources, begin=begin, keep=step.keep, kept=step.kept, begin_of=begin_of
                )
            else:
                self.take(name, self._number * first.GetInputPort(name).size())
                self._read[name] = self._folded(self._read[name])
        for name, (function, sources) in first.outputs.items():
            size = self._number * first.GetOutputPort(name).size()
            self.put_out(name, function, *sources, entry=range(size))

    def _each(self, begin: Array) -> Array:
        return np.broadcast_to(begin, (self._number, *begin.shape))

    def _folded(self, read: Any) -> Any:
        """A finger in each row."""
        number = self._number

        def folded(context: Context) -> Array:
            return np.reshape(read(context), (number, -1))

        return folded


class Joined(ArrayBlock):
    """Several vectors as one; unlike Drake's Multiplexer, it is not computed anew whenever time goes on."""

    def __init__(self, number: int, size: int):
        super().__init__()
        names = [str(i) for i in range(number)]
        for name in names:
            self.take(name, size)
        self.put_out("all", lambda *each: np.concatenate(each, axis=-1), *names, entry=range(number * size))


class Apart(ArrayBlock):
    """The parts of a vector, of equal size; likewise."""

    def __init__(self, number: int, signal: Signal, size: int):
        super().__init__()
        self.take("all", number * size)
        for i in range(number):
            part = slice(i * size, (i + 1) * size)
            self.put_out(str(i), _part(part), "all", unit=signal.unit, meanings=signal.meanings, **signal.axes)


def _part(part: slice) -> Callable[[Array], Array]:
    return lambda all_: all_[..., part]


def can_stack(diagrams: Sequence[Diagram]) -> bool:
    """Whether diagrams have equal blocks, all of which take a leading axis."""
    systems = [diagram.GetSystems() for diagram in diagrams]
    return len(diagrams) > 1 and len({len(each) for each in systems}) == 1 and all(map(_are_alike, *systems))


def _are_alike(*blocks: Any) -> bool:
    first = blocks[0]
    return (
        all(
            isinstance(block, ArrayBlock) and type(block) is type(first) and block.made_of == first.made_of
            for block in blocks
        )
        and first.takes_axes
        and not any(step.__class__.__name__ == "Value" for step in first.steps.values())
    )


def add_together(builder: DiagramBuilder, diagrams: Sequence[Diagram], fed: Sequence[Ports]) -> list[Ports]:
    """Adds one block in the place of each of several diagrams' blocks; `fed` has what feeds the inputs of each.

    Returns:
        the outputs of each, by name.
    """
    first = diagrams[0]
    stacked = {}
    for blocks in zip(*(diagram.GetSystems() for diagram in diagrams), strict=True):
        stacked[blocks[0]] = builder.AddNamedSystem(f"{blocks[0].get_name()}s", Stacked(blocks))
    for (to, number), (of, output) in first.connection_map().items():
        source = stacked[of].GetOutputPort(of.get_output_port(output).get_name())
        builder.Connect(source, stacked[to].GetInputPort(to.get_input_port(number).get_name()))
    for name, port in inputs(first).items():
        joined = builder.AddNamedSystem(f"{name} of all", Joined(len(diagrams), port.size()))
        for lane, known in enumerate(fed):
            builder.Connect(known[name], joined.get_input_port(lane))
        for system, number in first.GetInputPortLocators(port.get_index()):
            own = stacked[system].GetInputPort(system.get_input_port(number).get_name())
            builder.Connect(joined.get_output_port(), own)
    return _apart(builder, diagrams, stacked)


def _apart(builder: DiagramBuilder, diagrams: Sequence[Diagram], stacked: dict[Any, Stacked]) -> list[Ports]:
    found: list[Ports] = [{} for _ in diagrams]
    for name, port in vector_outputs(diagrams[0]).items():
        system, number = diagrams[0].get_output_port_locator(port.get_index())
        inner = system.get_output_port(number)
        apart = builder.AddNamedSystem(f"{name} of each", Apart(len(diagrams), signal_of(inner), port.size()))
        builder.Connect(stacked[system].GetOutputPort(inner.get_name()), apart.get_input_port())
        for lane, known in enumerate(found):
            known[name] = apart.get_output_port(lane)
    return found
