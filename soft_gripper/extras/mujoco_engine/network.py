"""A station for E environments at once: its blocks, wired as in its diagram, around plants in MuJoCo.

Values of ports are computed when read, and cached until their inputs change. Blocks of the drive are updated with every
step of the plant, others with every sample; all updates of one time see the values before it, as in Drake.
"""

from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from functools import cache, cached_property
from types import MappingProxyType
from typing import Any, Protocol, TypeAlias

import numpy as np
from numpy.typing import NDArray
from pydrake.common import RandomDistribution
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import BodyIndex, ModelInstanceIndex
from pydrake.systems.framework import Diagram, DiagramBuilder, LeafSystem, System
from pydrake.systems.primitives import MatrixGain, RandomSource

from soft_gripper.array_block import ArrayBlock
from soft_gripper.arrays import Array
from soft_gripper.control.task import TaskMachine
from soft_gripper.diagrams.signal_logs import SignalLogs
from soft_gripper.diagrams.simulation import seed_random_sources
from soft_gripper.diagrams.wires import Level, leaf_systems
from soft_gripper.extras.mujoco_engine.blocks import (
    GRAPHS,
    Block,
    Contexts,
    Functions,
    Graphs,
    PerDiagram,
    Rows,
    Streams,
    contents,
    context_steps,
    gains,
)
from soft_gripper.extras.mujoco_engine.equal_blocks import is_equal
from soft_gripper.scenario.schema import Scenario
from soft_gripper.sensors.base_pose import BasePoseSensor
from soft_gripper.steps import Step, Steps, row_by_row
from soft_gripper.truth.contact import TrueContact

Key: TypeAlias = LeafSystem | str  # of a block; of an input of the whole diagram, its name
Output = tuple[Key, int]


class Plants(Protocol):
    """The plants of E environments, with the ports of Drake's plant; see `plants.Plants`."""

    active: NDArray[np.int_]  # environments that still run

    @property
    def state(self) -> Array:
        """States at the last `look`, (E, nq + nv)."""

    def look(self) -> None:
        """Copies the present states."""

    def drive(self, model: ModelInstanceIndex, torques: Array, desired: Array | None) -> None:
        """Applies the torques of the actuators of a model, (E, nu), and the desired states of an arm, (E, 2 nu)."""

    def schedule(self) -> None:
        """Schedules a step of Drake's plant, driven as now."""

    def step(self, keeps: bool = False) -> None:
        """Makes all scheduled steps; contacts are unknown unless it `keeps` them."""

    def begin_step(self) -> None:
        """Steps until all values that follow from the states are known."""

    def finish_step(self) -> None:
        """Steps to the end of a step of Drake's plant."""

    def model_ports(self, model: ModelInstanceIndex) -> Mapping[str, Callable[[], Array]]:
        """Functions that compute a model's output ports, by port name without the model's."""

    def pose(self, body: BodyIndex) -> Array:
        """The pose of a body in the world, (E, 3, 4) [R | p]."""

    def patches(self) -> tuple[Array, NDArray[np.int_]]:
        """Contacts of all fingers as rows of `patch_table`, and where those of each environment begin, (E + 1,)."""


_VALID_FOR_STEP, _VALID_FOR_SAMPLE, _KEPT_FOR_SAMPLE = range(3)  # validity of values


class Wired(Protocol):
    """A built diagram with one plant, whose blocks run for many environments."""

    @property
    def diagram(self) -> Diagram:
        """Diagram with all blocks."""

    @property
    def plant(self) -> MultibodyPlant:
        """Plant, at the root of the diagram."""

    @property
    def scenario(self) -> Scenario:
        """Scenario from which it was built."""

    @property
    def task(self) -> TaskMachine | None:
        """Task of the station, or None."""


class Network:
    """Blocks of diagrams of one structure that the plant, logs or `read` need."""

    def __init__(
        self,
        wired: Sequence[Wired],
        plants: Plants,
        logs: SignalLogs | None = None,
        outputs: Collection[str] = (),
        graphs: Graphs = MappingProxyType({}),
    ):
        """
        Args:
            wired: diagram of each environment; several may share one, and equal blocks run together.
            plants: of all environments.
            logs: of the first diagram; None: nothing is logged.
            outputs: of the diagram, for `read`.
            graphs: steps of further kinds of blocks, see `GRAPHS`.
        """
        self._graphs = {**GRAPHS, **graphs}
        self._first, self.plants, self.count, self._wired = wired[0], plants, len(wired), wired
        diagram = self._first.diagram
        self._root = Level(diagram.connection_map())
        self._levels = _levels(diagram)
        self._diagrams = _diagrams(wired)
        self._exported_inputs = dict(_exported_inputs(diagram))
        self._feeds: dict[Key, list[Output | None]] = {}
        self._blocks: dict[Key, Block] = {}
        self._validity: dict[Output, int] = {}
        self._values: tuple[dict[Output, Array], ...] = ({}, {}, {})
        self._time, self._draws = 0.0, self._draw([member.scenario.sensor.seed for member in wired])
        self._ports = self._plant_ports()
        self._driven = list(self._drives())
        port_count = 0 if logs is None else logs.num_input_ports()
        self._logged = [self._source(logs, i, self._root) for i in range(port_count)]
        self._outputs = {name: self._exported(name) for name in outputs}
        drives = [feed for _, *feeds in self._driven for feed in feeds]
        for output in (*self._logged, *self._outputs.values(), *drives):
            if output is not None:
                self._reach(output)
        task = next((leaf for leaf in self._blocks if isinstance(leaf, TaskMachine)), None)
        self._phase = None if task is None else (task, int(task.GetOutputPort("phase").get_index()))
        self._ends = np.array([len(member.task.phases) for member in wired if member.task is not None])
        self._step_blocks = [leaf for leaf, block in self._blocks.items() if self._is_by_step(block)]
        with_state = [leaf for leaf, block in self._blocks.items() if block.period is not None]
        self._sample_blocks = [leaf for leaf in with_state if leaf not in self._step_blocks]
        self._changing_blocks = [leaf for leaf in self._blocks if self._is_changing(leaf)]
        drives = [member for _, *feeds in self._driven for member in feeds]
        drives += [member for leaf in self._step_blocks for member in self._feeds[leaf]]
        self._is_foreseen = not any(member is not None and self._is_unforeseen(member) for member in drives)
        self._following = cache(self._find_following)

    # Wiring.

    def _source(self, system: Any, port_index: int, level: Level) -> Output | None:
        """Source of an input: a leaf output, or an input of the diagram."""
        feed = level.feed(system.get_input_port(port_index))
        if feed is None:
            name = self._exported_inputs.get((system, port_index))
            return None if name is None else (name, 0)
        if isinstance(feed.system, Diagram):
            port, _ = feed.level.leaf_output(feed.output)
            return port.get_system(), int(port.get_index())
        return feed.system, int(feed.output_index)

    def _exported(self, name: str) -> Output:
        """The leaf output behind an output of the diagram."""
        diagram = self._first.diagram
        system, number = diagram.get_output_port_locator(diagram.GetOutputPort(name).get_index())
        port, _ = self._root.leaf_output(system.get_output_port(number))
        return port.get_system(), int(port.get_index())

    def _reach(self, output: Output) -> None:
        """Makes the block of an output, and the blocks that it reads."""
        pending_blocks = [output[0]]
        while pending_blocks:
            leaf = pending_blocks.pop()
            if leaf in self._blocks or isinstance(leaf, MultibodyPlant | TrueContact):
                continue
            if isinstance(leaf, str):
                size = self._first.diagram.GetInputPort(leaf).size()
                self._feeds[leaf], self._blocks[leaf] = [], Streams(np.zeros((1, self.count, size)))
                continue
            inputs = range(leaf.num_input_ports())
            self._feeds[leaf] = [self._source(leaf, i, self._levels[leaf]) for i in inputs]
            groups = self._group_equal(leaf)
            if len(groups) > 1 and isinstance(leaf, MatrixGain):
                self._blocks[leaf] = Functions(leaf, gains(groups), self.count)
            elif len(groups) > 1:
                self._blocks[leaf] = PerDiagram(
                    [(self._make_block(leaf, *group), group[1]) for group in groups.items()]
                )
            else:
                self._blocks[leaf] = self._make_block(leaf, leaf, np.arange(self.count))
            pending_blocks += [feed[0] for feed in self._feeds[leaf] if feed is not None]

    def _is_shared(self, leaf: Key) -> bool:
        """Whether a block has equal outputs in all environments, since they depend on time alone."""
        if isinstance(leaf, str | MultibodyPlant | TrueContact | RandomSource | TaskMachine):
            return False
        feeds = (self._source(leaf, i, self._levels[leaf]) for i in range(leaf.num_input_ports()))
        return all(source is not None and self._is_shared(source[0]) for source in feeds)

    @cached_property
    def _step_times(self) -> Array:
        """Times of all steps of the plant, s, (T, 1)."""
        return np.arange(0.0, self._first.scenario.duration, self._first.plant.time_step())[:, None]

    def _group_equal(self, leaf: LeafSystem) -> dict[LeafSystem, Rows]:
        """Groups equal counterparts of a block in all diagrams: one block of each group, and its environments."""
        if isinstance(leaf, RandomSource | TaskMachine):  # have values for every environment
            return {leaf: np.arange(self.count)}
        leaf_index, make_steps = list(self._levels).index(leaf), self._graph_of(leaf)
        groups: list[tuple[LeafSystem, Any, list[int]]] = []
        for leaves, rows in self._diagrams:
            counterpart = leaves[leaf_index]
            steps = None if make_steps is None else make_steps(counterpart)
            behavior = contents(counterpart, self._step_times) if steps is None else (steps, steps.outputs)
            equal_rows = next((members for _, key, members in groups if is_equal(behavior, key)), None)
            if equal_rows is None:
                groups.append((counterpart, behavior, list(rows)))
            else:
                equal_rows += rows
        return {block: np.array(rows) for block, _, rows in groups}

    def _graph_of(self, leaf: LeafSystem) -> Callable[[Any], Steps] | None:
        """Function that makes the steps of a block; None: it is evaluated environment by environment."""
        return next((self._graphs[kind] for kind in type(leaf).__mro__ if kind in self._graphs), None)

    def _make_block(self, leaf: LeafSystem, counterpart: LeafSystem, rows: Rows) -> Block:
        """Makes the counterpart of a block of the first diagram for some environments."""
        if isinstance(leaf, RandomSource):
            return Streams(self._draws[leaf.get_name()])
        make_steps, count = self._graph_of(leaf), len(rows)
        has_state = leaf.num_discrete_state_groups() or leaf.num_abstract_states()
        if make_steps is None and has_state:
            return Contexts(counterpart, 1 if self._is_shared(leaf) else count)
        steps = context_steps(counterpart) if make_steps is None else make_steps(counterpart)
        if self._is_shared(leaf) and not any(step.memory for step in steps.values()):
            count = 1
        if isinstance(leaf, ArrayBlock) and not leaf.takes_axes:
            graphs = [steps] * count
            if isinstance(leaf, TaskMachine):  # each environment has its own phases
                graphs = [station.task.steps for station in self._wired if station.task is not None]
            return Functions(counterpart, row_by_row(graphs), count)
        steps = steps.stacked(count)
        if isinstance(leaf, BasePoseSensor):
            steps["pose"] = Step(lambda: self.plants.pose(leaf.body)[rows].reshape(count, -1))
        return Functions(counterpart, steps, count)

    def _plant_ports(self) -> dict[int, Callable[[], Array]]:
        """Functions that compute the plant's output ports, by port number."""
        plant, plants = self._first.plant, self.plants
        ports: dict[int, Callable[[], Array]] = {int(plant.get_state_output_port().get_index()): lambda: plants.state}
        for model in map(ModelInstanceIndex, range(plant.num_model_instances())):
            model_ports = plants.model_ports(model)
            for name, port in (
                ("state", plant.get_state_output_port(model)),
                ("generalized_contact_forces", plant.get_generalized_contact_forces_output_port(model)),
                ("net_actuation", plant.get_net_actuation_output_port(model)),
            ):
                ports[int(port.get_index())] = model_ports[name]
        return ports

    def _drives(self) -> Iterator[tuple[ModelInstanceIndex, Output, Output | None]]:
        """Yields models with actuators, and the outputs that feed their torques and desired states."""
        plant = self._first.plant
        for model in map(ModelInstanceIndex, range(plant.num_model_instances())):
            if plant.num_actuated_dofs(model):
                ports = plant.get_actuation_input_port(model), plant.get_desired_state_input_port(model)
                torque, desired = (self._source(plant, int(port.get_index()), self._root) for port in ports)
                if torque is not None:
                    yield model, torque, desired

    # Values.

    def _value(self, output: Output) -> Array:
        leaf, number = output
        if isinstance(leaf, MultibodyPlant):
            return self._ports[number]()
        values = self._values[self._valid_for(output)]
        if output not in values:
            values[output] = self._blocks[leaf].output(number, self._reader(leaf), self._time)
        return values[output]

    def _reader(self, leaf: Key) -> Callable[[int], Array | None]:
        def read(number: int) -> Array | None:
            feed = self._feeds[leaf][number]
            return None if feed is None else self._value(feed)

        return read

    def _valid_for(self, output: Output) -> int:
        if output not in self._validity:
            self._validity[output] = self._find_validity(*output)
        return self._validity[output]

    def _find_validity(self, leaf: Key, number: int) -> int:
        block = self._blocks[leaf]
        if isinstance(leaf, str):
            return _VALID_FOR_SAMPLE
        if self._is_by_step(block) or self._takes_time(leaf, number):
            return _VALID_FOR_STEP
        feeds = [feed for i, feed in enumerate(self._feeds[leaf]) if feed and leaf.HasDirectFeedthrough(i, number)]
        changes = any(isinstance(feed[0], MultibodyPlant) or self._valid_for(feed) == _VALID_FOR_STEP for feed in feeds)
        if changes and self._graph_of(leaf) is None and not self._is_shared(leaf):
            return _KEPT_FOR_SAMPLE  # it costs a call per environment
        return _VALID_FOR_STEP if changes else _VALID_FOR_SAMPLE

    def _takes_time(self, leaf: LeafSystem, number: int) -> bool:
        """Whether an output is known to depend on time alone; unknown for other stateless systems."""
        block, is_told = self._blocks[leaf], isinstance(leaf, ArrayBlock) or not self._feeds[leaf]
        return is_told and isinstance(block, Functions) and block.takes_time(number)

    def _is_by_step(self, block: Block) -> bool:
        step = self._first.plant.time_step()
        is_sampled = step == self._first.scenario.sensor.period  # each step is a sample
        return isinstance(block, Functions) and block.period == step and not is_sampled

    def _is_changing(self, leaf: Key) -> bool:
        """Whether an input or output of a block changes with every step of the plant."""
        if isinstance(leaf, str):
            return False
        outputs = ((leaf, number) for number in range(leaf.num_output_ports()))
        feeds = (source for source in self._feeds[leaf] if source is not None)
        ports = (*feeds, *outputs)
        return any(isinstance(port[0], MultibodyPlant) or self._valid_for(port) == _VALID_FOR_STEP for port in ports)

    def _is_unforeseen(self, output: Output) -> bool:
        """Whether a value changes between samples with the plants' states, and is not held for a sample."""
        leaf, number = output
        if isinstance(leaf, MultibodyPlant):
            return True
        if isinstance(leaf, str) or self._valid_for(output) != _VALID_FOR_STEP:
            return False
        feeds = [feed for i, feed in enumerate(self._feeds[leaf]) if feed and leaf.HasDirectFeedthrough(i, number)]
        return any(map(self._is_unforeseen, feeds))

    def _find_following(self, key: Key) -> tuple[Collection[Output], Collection[Key]]:
        """Outputs that depend directly on an input, itself included, and the blocks that read them."""
        outputs, readers, pending_outputs = dict[Output, None](), dict[Key, None](), list[Output]([(key, 0)])
        feeds_by_input = {(leaf, i): feed for leaf, feeds in self._feeds.items() for i, feed in enumerate(feeds)}
        while pending_outputs:
            output = pending_outputs.pop()
            if output in outputs:
                continue
            outputs[output] = None
            for leaf, number in [feed for feed, source in feeds_by_input.items() if source == output]:
                assert not isinstance(leaf, str)
                readers[leaf] = None
                ports = range(leaf.num_output_ports())
                pending_outputs += [(leaf, port) for port in ports if leaf.HasDirectFeedthrough(number, port)]
        return outputs, readers

    # Time.

    def begin(self, rows: Rows | None = None, seeds: Sequence[int] = ()) -> None:
        """Sets initial states: of some environments, with new seeds; None: of all, with their own."""
        if rows is None:
            rows = np.arange(self.count)
        else:
            self._redraw(rows, seeds)
        for block in self._blocks.values():
            block.clear(rows)
        self.plants.look()
        kept_values = dict(self._values[_KEPT_FOR_SAMPLE])
        other_rows = np.setdiff1d(np.arange(self.count), rows)
        self._changed()
        for leaf, block in self._blocks.items():
            block.begin(self._reader(leaf), rows)
        self._commit(list(self._blocks))
        for output, value in kept_values.items() if len(other_rows) else ():
            self._value(output)[other_rows] = value[other_rows]

    def give(self, name: str, value: Array) -> None:
        """Sets an input of the diagram, or the output of a source in it, (E, size)."""
        key: Key = name if name in self._blocks else self._first.diagram.GetSubsystemByName(name)
        self._blocks[key] = Streams(value[None])
        outputs, readers = self._following(key)
        for output in outputs:
            self._values[self._valid_for(output)].pop(output, None)
        self._forget(readers)

    def read(self, name: str) -> Array:
        """An output of the diagram, (E, size)."""
        self._look()
        return self._value(self._outputs[name])

    def drive_plants(self, time: float) -> None:
        """Reads the states of the plants at a time, s, drives them, and prepares updates of the drive."""
        self._look()
        self._drive(time)

    def step(self, times: Sequence[float], keeps: bool = False) -> None:
        """Steps the plants between samples, from these times, s; all at once if their drives are foreseen."""
        for group in [times] if self._is_foreseen else [[time] for time in times]:
            self._look()
            for time in group:
                self._drive(time)
                self.plants.schedule()
                self._commit(self._step_blocks)
            self.plants.step(keeps)

    def _look(self) -> None:
        """Reads the states of the plants, and discards values of the states before."""
        self.plants.look()
        self._stepped()

    def _drive(self, time: float) -> None:
        self._time = time
        for model, torque, desired in self._driven:
            self.plants.drive(model, self._value(torque), None if desired is None else self._value(desired))
        self._advance(self._step_blocks)

    def logged(self) -> Iterator[tuple[int, Array]]:
        """Yields logged values, (E, size) or (1, size), with the number of the log's input."""
        for number, output in enumerate(self._logged):
            assert output is not None
            yield number, self._value(output)

    def sample(self) -> None:
        """Takes the samples and makes the updates of a time, after the first step of the plants from it."""
        for block in self._blocks.values():
            if isinstance(block, Streams):
                block.draw()
        self._advance(self._sample_blocks)
        self._commit([*self._sample_blocks, *self._step_blocks])

    @property
    def phases(self) -> Array | None:
        """The number of the phase of each task, (E,); None: there are no tasks."""
        return None if self._phase is None else self._value(self._phase)[:, 0]

    @property
    def is_over(self) -> NDArray[np.bool_]:
        """The environments whose task is over, (E,)."""
        phases = self.phases
        return np.zeros(self.count, bool) if phases is None else phases == self._ends

    def _advance(self, leaves: Sequence[Key]) -> None:
        for leaf in leaves:
            self._blocks[leaf].advance(self._reader(leaf), self._time, self.plants.active)

    def _commit(self, leaves: Sequence[Key]) -> None:
        for leaf in leaves:
            self._blocks[leaf].commit()
        if leaves is self._step_blocks:
            self._stepped()
        else:
            self._changed()

    def _stepped(self) -> None:
        """Discards values that were valid for a step of the plant."""
        self._values[_VALID_FOR_STEP].clear()
        self._forget(self._changing_blocks)

    def _changed(self) -> None:
        """Discards all values."""
        for values in self._values:
            values.clear()
        self._forget(self._blocks)

    def _forget(self, leaves: Iterable[Key]) -> None:
        """Lets blocks discard the values they have computed."""
        for leaf in leaves:
            self._blocks[leaf].forget()

    def _draw(self, seeds: Sequence[int]) -> dict[str, Array]:
        """Draws of every random source in environments with these seeds, (T, E, size), by its name."""
        return _streams(self._first.diagram, self._first.scenario, seeds)

    def _redraw(self, rows: Rows, seeds: Sequence[int]) -> None:
        draws = self._draw(seeds)
        for leaf, block in self._blocks.items():
            if isinstance(block, Streams) and isinstance(leaf, RandomSource):
                block.give(draws[leaf.get_name()], rows)


def _levels(diagram: Diagram) -> dict[LeafSystem, Level]:
    """Leaf systems of a diagram, and their levels."""
    root = Level(diagram.connection_map())
    return {leaf: level for subsystem in diagram.GetSystems() for leaf, level in leaf_systems(subsystem, root)}


def _diagrams(wired: Sequence[Wired]) -> list[tuple[list[LeafSystem], list[int]]]:
    """The leaf systems of each diagram, in the order of their counterparts, and its environments."""
    rows: dict[Diagram, list[int]] = {}
    for row, station in enumerate(wired):
        rows.setdefault(station.diagram, []).append(row)
    return [([*_levels(diagram)], diagram_rows) for diagram, diagram_rows in rows.items()]


def _exported_inputs(diagram: Diagram) -> Iterator[tuple[tuple[System, int], str]]:
    """Yields inputs of blocks that are inputs of the whole diagram, and the names of these."""
    for port in map(diagram.get_input_port, range(diagram.num_input_ports())):
        for system, number in diagram.GetInputPortLocators(port.get_index()):
            yield (system, int(number)), port.get_name()


def _streams(diagram: Diagram, scenario: Scenario, seeds: Sequence[int]) -> dict[str, Array]:
    """Draws of the random sources of a diagram, (T, E, size), by name, in runs with each seed.

    A source draws number after number, so one with T times as many outputs draws T samples at once.
    """
    builder, samples = DiagramBuilder(), round(scenario.duration / scenario.sensor.period) + 3
    sources = {
        system.get_name(): builder.AddNamedSystem(system.get_name(), _repeated_source(system, samples))
        for system in diagram.GetSystems()
        if isinstance(system, RandomSource)
    }
    if not sources:
        return {}
    source_diagram = builder.Build()
    context, draws = source_diagram.CreateDefaultContext(), {name: list[Array]() for name in sources}
    for seed in seeds:
        seed_random_sources(source_diagram, context, seed)
        for name, source in sources.items():
            values = source.get_output_port().Eval(source.GetMyContextFromRoot(context))
            draws[name].append(values.reshape(samples, -1))
    return {name: np.stack(system, axis=1) for name, system in draws.items()}


def _repeated_source(source: RandomSource, samples: int) -> RandomSource:
    return RandomSource(RandomDistribution.kGaussian, samples * source.get_output_port().size(), 1.0)
