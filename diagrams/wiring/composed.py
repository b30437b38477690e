"""Fuses the blocks of a part of a finger into one block, and runs those of equal fingers at once.

A block in Python costs more by its ports, caches and events than by its arithmetic, and a small numpy operation costs
as much for two fingers as for one. So, where nobody reads the blocks of a diagram, a `FusedBlock` replaces them, and a
`BatchedBlock` those of several equal fingers. Both call the functions of the blocks (ArrayBlock), and have the ports
of the diagram. At last the parts that stay in a private run are fused into one (`private_run.fuse_loop`).
Parts with a user block stay as they are: it may do more than its functions say, and is named if it fails.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial
from typing import Any, NamedTuple

import numpy as np
from pydrake.systems.framework import Diagram, DiagramBuilder, InputPort, OutputPort, PortDataType, System

from soft_gripper.array_block import ArrayBlock
from soft_gripper.arrays import Array
from soft_gripper.diagrams.wires import Level
from soft_gripper.diagrams.wiring.named_wires import Ports, inputs, vector_outputs
from soft_gripper.signals import signal_of
from soft_gripper.steps import TIME, Output, Step, Steps, same

_SHARED_TIME = "time of all"
_OPEN = "open"  # source of inputs that nothing feeds


class FusedBlock(ArrayBlock):
    """Several blocks as one, with those of their steps from which its outputs follow; it leaves the blocks unused."""

    def __init__(
        self,
        blocks: Sequence[ArrayBlock],
        taken: Mapping[str, InputPort],
        fed: Mapping[tuple[System, str], str],
        ports: Mapping[str, OutputPort],
    ):
        """
        Args:
            blocks: made of functions of vectors, and sampled together.
            taken: inputs of the blocks, vectors or not, that its own inputs replace, by the names of these.
            fed: name of the source of each input of the blocks: an input, or an output of a block, see `wire`.
            ports: the outputs of the blocks, or of diagrams that export them, by the names that they get.
        """
        super().__init__(next((block.period for block in blocks if block.period is not None), None))
        for name, port in taken.items():
            if port.get_data_type() == PortDataType.kVectorValued:
                self.take(name, port.size())
            else:
                self.take_value(name, port.Allocate())
        outputs = {name: _output(Level({}).leaf_output(port)[0], fed) for name, port in ports.items()}
        steps = {name: step for block in blocks for name, step in _steps(block, fed)}
        _pass_rows_on(steps)
        _add_all(self, Steps(_needed_steps(steps, outputs), outputs))
        for name, port in ports.items():
            function, sources = outputs[name]
            self.put_out(name, function, *sources, **_port_labels(port))

    @classmethod
    def from_diagram(cls, diagram: Diagram) -> "FusedBlock":
        """The blocks of a diagram, with its inputs and outputs."""
        return cls(diagram.GetSystems(), inputs(diagram), _input_sources(diagram), vector_outputs(diagram))


class BatchedBlock(ArrayBlock):
    """One block for several equal fingers, whose steps have a leading axis of fingers.

    ::

        {finger}.{input} ---> BatchedBlock ---> {finger}.{output}

    A recording is computed finger by finger, but for steps that are loops over its samples.
    """

    def __init__(self, block: ArrayBlock, fingers: Sequence[str]):
        """`block` is the block of one finger."""
        super().__init__(block.period)
        self._finger_block, self._fingers = block, fingers
        finger_count = len(fingers)
        for name in inputs(block):
            port_names = [f"{finger}.{name}" for finger in fingers]
            for port in port_names:
                self.take(port, block.GetInputPort(name).size())
            self.derive(name, _stacked, *port_names)
        self.add(_SHARED_TIME, Step(lambda time: np.broadcast_to(time, (finger_count, 1)), (TIME,)), kept=False)
        steps = block.steps.stacked(finger_count)
        finger_steps = {name: step.renamed(_shared_name) for name, step in steps.items() if step.function is not None}
        _add_all(self, Steps(finger_steps, block.outputs))
        for name, (function, sources) in block.outputs.items():
            port = block.GetOutputPort(name)
            stacked_name = f"{name} of all"
            self.derive(stacked_name, _reshaped(function, (finger_count, port.size())), *sources)
            for i, finger in enumerate(fingers):
                self.put_out(f"{finger}.{name}", partial(_row, i), stacked_name, **_port_labels(port))

    def follows(self, output: str, period: float) -> bool:
        return self._finger_block.follows(_split_port(output)[1], period)

    def leaves(self, output: str) -> list[str]:
        finger, name = _split_port(output)
        fingers = self._fingers if self._loops(name) else [finger]
        return [f"{finger}.{leaf}" for finger in fingers for leaf in self._finger_block.leaves(name)]

    def output_over_time(self, output: str, step_values: dict[str, Any]) -> Array:
        """Computes an output as ArrayBlock does; each finger has its own steps."""
        finger, output_name = _split_port(output)
        loops = self._loops(output_name)
        names = self._fingers if loops else [finger]
        fingers = {name: step_values.setdefault(name, _FingerSteps(step_values, name)) for name in names}
        for loop in loops:
            if loop not in fingers[finger]:
                self._run_loop(loop, [*fingers.values()])
        return self._finger_block.output_over_time(output_name, fingers[finger])

    def _loops(self, output: str) -> list[str]:
        """Steps of an output that are loops over a recording, each after its sources."""
        steps = self._finger_block.steps
        return [name for name, step in _needed_steps(steps, {output: steps.outputs[output]}).items() if step.loops]

    def _run_loop(self, name: str, fingers: Sequence[dict[str, Any]]) -> None:
        """Computes a step over a recording of all fingers."""
        recorded = self._finger_block.steps.recorded
        rows = ([recorded.value(source, steps) for steps in fingers] for source in recorded[name].sources)
        function = recorded[name].function
        assert function is not None
        values = function(*(np.stack(row, axis=1) for row in rows))
        for i, steps in enumerate(fingers):
            steps[name] = _column(i, values)


class _FingerSteps(dict[str, Any]):
    """The steps of one finger at all samples; leaves are taken from those of all fingers."""

    def __init__(self, steps: Mapping[str, Any], finger: str):
        super().__init__({TIME: steps[TIME]})
        self._steps = steps
        self._finger = finger

    def __missing__(self, leaf: str) -> Any:
        self[leaf] = self._steps[f"{self._finger}.{leaf}"]
        return self[leaf]


def _add_all(block: ArrayBlock, steps: Steps) -> None:
    """Adds steps, which follow from each other and from the inputs of a block, to the block.

    Steps with one reader are not cached.
    """
    for name, step in steps.items():
        block.add(name, step, kept=steps.readers[name] > 1)


def _pass_rows_on(steps: dict[str, Step]) -> None:
    """Replaces steps that stack all rows of another one, as between the blocks of the same fingers, by that itself."""
    for name, step in steps.items():
        if step.function is _stacked:
            rows = [steps.get(source, step) for source in step.sources]
            (stack, *other_stacks) = {row.sources for row in rows}
            if not other_stacks and [_row_number(row) for row in rows] == [*range(len(rows))]:
                steps[name] = Step(same, stack, None, same, stack)


def _row_number(step: Step) -> int | None:
    """The row that a step takes of another one; None: it does something else."""
    return step.function.args[0] if isinstance(step.function, partial) and step.function.func is _row else None


def _needed_steps(steps: Mapping[str, Step], outputs: Mapping[str, Output]) -> dict[str, Step]:
    """The steps from which outputs follow, each after its sources."""
    needed_steps: dict[str, Step] = {}
    pending_names = [name for _, sources in outputs.values() for name in sources]
    while pending_names:
        for step in _add_in_order(pending_names.pop(), steps, needed_steps):
            pending_names += step.sources_over_time
            if step.memory is not None:
                pending_names += step.memory.sources
                pending_names += () if step.memory.begin_of is None else (step.memory.begin_of[1],)
    return needed_steps


def _add_in_order(name: str, steps: Mapping[str, Step], needed_steps: dict[str, Step]) -> Iterator[Step]:
    """Adds a step to the needed ones, after its sources; yields the added steps."""
    if name in steps and name not in needed_steps:
        for source in steps[name].sources:
            yield from _add_in_order(source, steps, needed_steps)
        needed_steps[name] = steps[name]
        yield steps[name]


def _input_sources(diagram: Diagram) -> dict[tuple[System, str], str]:
    """Names of the sources of the blocks' inputs: inputs of the diagram, or outputs of other blocks."""
    fed = {}
    for name, port in inputs(diagram).items():
        for block, number in diagram.GetInputPortLocators(port.get_index()):
            fed[block, block.get_input_port(number).get_name()] = name
    for (block, number), (source, index) in diagram.connection_map().items():
        fed[block, block.get_input_port(number).get_name()] = wire(source.get_output_port(index))
    return fed


def _steps(block: ArrayBlock, fed: Mapping[tuple[System, str], str]) -> Iterator[tuple[str, Step]]:
    """The steps of a block among others, with one for each of its outputs that feeds another block."""
    yield _OPEN, Step(lambda: None, over_time=None)
    name_of = partial(_name_of, block, fed)
    for name, step in block.steps.items():
        if step.function is not None:
            yield name_of(name), step.renamed(name_of)
    for name, (function, sources) in block.outputs.items():
        port = block.GetOutputPort(name)
        if wire(port) in fed.values():
            size = port.size()
            steps = tuple(map(name_of, sources))
            is_row = isinstance(function, partial) and function.func is _row  # which is flat
            flat_function = function if is_row else _flattened(function, size)
            yield wire(port), Step(flat_function, steps, None, _reshaped(function, (-1, size)), steps)


def _output(port: OutputPort, fed: Mapping[tuple[System, str], str]) -> Output:
    """The function and the steps of an output of a block."""
    if wire(port) in fed.values():
        return same, [wire(port)]
    function, sources = port.get_system().outputs[port.get_name()]
    return function, [_name_of(port.get_system(), fed, source) for source in sources]


def _name_of(block: ArrayBlock, fed: Mapping[tuple[System, str], str], name: str) -> str:
    """Unique name of a step among several blocks; all share the time."""
    if name == TIME:
        return name
    return fed.get((block, name), _OPEN) if block.HasInputPort(name) else f"{block.get_name()}/{name}"


def _shared_name(name: str) -> str:
    """Name of a step among those of several fingers, which have one time."""
    return _SHARED_TIME if name == TIME else name


def wire(port: OutputPort) -> str:
    """Step of an output that feeds another block."""
    return f"{port.get_system().get_name()}.{port.get_name()}"


def _port_labels(port: OutputPort) -> dict[str, Any]:
    signal = signal_of(port)
    return {"unit": signal.unit, "meanings": signal.meanings, **signal.axes}


def _row(i: int, values: Array) -> Array:
    return values[i]


def _column(i: int, values: Any) -> Any:
    """Column of an array, or of a tuple of these."""
    return type(values)(*(part[:, i] for part in values)) if isinstance(values, tuple) else values[:, i]


def _stacked(*values: Array) -> Array:
    return np.array(values)


def _reshaped(function: Callable[..., Any], shape: tuple[int, ...]) -> Callable[..., Array]:
    return lambda *steps: np.asarray(function(*steps)).reshape(shape)


def _flattened(function: Callable[..., Any], size: int) -> Callable[..., Array]:
    """A function with its values flattened to vectors, of one finger or of each."""

    def flat(*steps: Any) -> Array:
        rows = np.asarray(function(*steps)).reshape(-1, size)
        return rows[0] if len(rows) == 1 else rows

    return flat


def _split_port(port: str) -> tuple[str, str]:
    """Finger and name of a port of several fingers."""
    finger, _, name = port.partition(".")
    return finger, name


class PartPorts(NamedTuple):
    """The ports of a part of one finger, by name."""

    inputs: Mapping[str, InputPort]
    outputs: Ports


def add_part(builder: DiagramBuilder, name: str, part: System) -> PartPorts:
    """Adds a part of a finger to a diagram."""
    builder.AddNamedSystem(name, part)
    return PartPorts(inputs(part), vector_outputs(part))


def add_parts(
    builder: DiagramBuilder, kind: str, parts: Mapping[str, Diagram], keys: Mapping[str, Any] | None = None
) -> dict[str, PartPorts]:
    """Adds parts of fingers, `{finger}.{kind}`.

    Args:
        builder: of any diagram.
        kind: of the parts.
        parts: by finger, in no diagram yet.
        keys: by finger: each part becomes one block, shared by fingers with equal keys; None: parts stay diagrams of
            blocks.
    """
    if keys is None:
        return {name: add_part(builder, f"{name}.{kind}", part) for name, part in parts.items()}
    part_ports: dict[str, PartPorts] = {}
    for names in _group_by_key(keys):
        if len(names) == 1 or not all(block.takes_axes for block in parts[names[0]].GetSystems()):
            part_ports |= {
                name: add_part(builder, f"{name}.{kind}", FusedBlock.from_diagram(parts[name])) for name in names
            }
        else:
            block = builder.AddNamedSystem(
                f"{'+'.join(names)}.{kind}", BatchedBlock(FusedBlock.from_diagram(parts[names[0]]), names)
            )
            part_ports |= {
                name: PartPorts(_finger_ports(name, inputs(block)), _finger_ports(name, vector_outputs(block)))
                for name in names
            }
    return {name: part_ports[name] for name in parts}


def _group_by_key(keys: Mapping[str, Any]) -> list[list[str]]:
    """Groups names with equal keys."""
    groups: list[list[str]] = []
    for name, key in keys.items():
        group = next((group for group in groups if keys[group[0]] == key), None)
        if group is None:
            groups.append([name])
        else:
            group.append(name)
    return groups


def _finger_ports(finger: str, ports: Mapping[str, Any]) -> dict[str, Any]:
    """The ports of one finger, without its name."""
    return {
        name: port
        for (owner, name), port in ((_split_port(port_name), port) for port_name, port in ports.items())
        if owner == finger
    }
