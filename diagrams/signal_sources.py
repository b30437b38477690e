"""The ports from which the signals of a run follow.

An ArrayBlock computes its outputs at all samples of a recording from its inputs at all samples, and so does a
MatrixGain of the root diagram. So a port of such a block needs no log if its inputs can be traced back to logged ports.
"""

import logging
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np
from pydrake.multibody.plant import MultibodyPlant
from pydrake.systems.framework import DiagramBuilder, InputPort, LeafSystem, OutputPort, System
from pydrake.systems.primitives import MatrixGain

from soft_gripper.array_block import ArrayBlock
from soft_gripper.arrays import Array
from soft_gripper.diagrams.wires import Level
from soft_gripper.estimators.finger_shape import ANGLES
from soft_gripper.steps import TIME

_LOGGER = logging.getLogger(__name__)


class LoggedPort(NamedTuple):
    """A logged port, by its index in `SignalSources.ports`.

    Logs hold on to it after the diagram is built; a reference to the port itself would keep the diagram alive.
    """

    number: int


@dataclass(eq=False)
class DerivedBlock:
    """Outputs of a block that are computed from the same outputs of other blocks."""

    block: ArrayBlock
    leaves: dict[str, "SignalSource"]  # by port name of the block
    outputs: list[str] = field(default_factory=list)  # names of the requested outputs


class DerivedOutput(NamedTuple):
    """One output of a `DerivedBlock`."""

    derived: DerivedBlock
    name: str


@dataclass(frozen=True, eq=False)
class DerivedProduct:
    """Output of a MatrixGain, computed from its input."""

    gain: Array
    source: "SignalSource"


SignalSource = LoggedPort | DerivedOutput | DerivedProduct


class SignalSources:
    """Finds the ports from which signals of a diagram can be computed, sampled every `period` s.

    Use it before the diagram is built.

    `ports` are those that may need a log, or inputs that they feed.
    """

    def __init__(self, builder: DiagramBuilder, period: float):
        self.ports: list[OutputPort | InputPort] = []
        self._numbers: dict[tuple[System, int], int] = {}  # of `ports`, by the system and index of the output
        self._root = Level.root(builder)
        self._period = period
        self._blocks: dict[tuple[System, frozenset[str]], DerivedBlock] = {}
        self._outputs: dict[tuple[System, str], DerivedOutput | None] = {}
        self._products: dict[System, DerivedProduct] = {}  # by the MatrixGain

    def find(self, port: OutputPort) -> SignalSource:
        """The source of a port of the builder's systems."""
        return self._trace(port, self._root) or self._log_port(port)

    def _log_port(self, port: OutputPort) -> LoggedPort:
        return self._log_output(port.get_system(), port.get_index(), port)

    def _log_output(self, system: System, index: int, port: OutputPort | InputPort) -> LoggedPort:
        key = system, index
        if key not in self._numbers:
            self._numbers[key] = len(self.ports)
            self.ports.append(port)
        return LoggedPort(self._numbers[key])

    def _trace(self, port: OutputPort, level: Level) -> SignalSource | None:
        """Source of a port at any level; None if it depends on an output that the root diagram does not export."""
        port, level = level.leaf_output(port)
        system = port.get_system()
        if isinstance(system, ArrayBlock) and system.follows(port.get_name(), self._period):
            output = self._follow(system, port.get_name(), level)
            if output is not None:
                return output
        if isinstance(system, MatrixGain) and level.diagram is None:
            product = self._multiply(system, level)
            if product is not None:
                return product
        root_port = level.root_port(port)
        return None if root_port is None else self._log_port(root_port)

    def _follow(self, system: ArrayBlock, name: str, level: Level) -> DerivedOutput | None:
        """Output of a block if all its sources can be traced, else None; None also within a loop of the search."""
        key = system, name
        if key not in self._outputs:
            self._outputs[key] = None
            leaves = {leaf: self._leaf(system, leaf, level) for leaf in system.leaves(name)}
            leaf_sources = {leaf: source for leaf, source in leaves.items() if source is not None}
            if len(leaf_sources) == len(leaves):
                block = self._blocks.setdefault((system, frozenset(leaf_sources)), DerivedBlock(system, leaf_sources))
                block.outputs.append(name)
                self._outputs[key] = DerivedOutput(block, name)
        return self._outputs[key]

    def _multiply(self, system: MatrixGain, level: Level) -> DerivedProduct | None:
        """Output of a gain of the root diagram if its input can be traced, else None."""
        if system not in self._products:
            source = self._leaf(system, "u0", level)
            if source is None:
                return None
            self._products[system] = DerivedProduct(system.D(), source)
        return self._products[system]

    def _leaf(self, system: LeafSystem, name: str, level: Level) -> SignalSource | None:
        if system.HasInputPort(name):
            feed = level.feed(system.GetInputPort(name))
            if feed is not None and isinstance(feed.system, MultibodyPlant) and feed.level.diagram is None:
                return self._log_output(feed.system, feed.output_index, feed.input)
            return None if feed is None else self._trace(feed.output, feed.level)
        return self._log_port(system.GetOutputPort(name))  # the block logs it, at any level


class Samples:
    """Signals at all samples of a run, (T, size) each, by name; those of blocks are computed when they are read.

    A warning is logged if an estimator left joint angles NaN, as it does without readings, when they, or other signals
    of the estimate that are NaN, are first read.
    """

    def __init__(self, sources: Mapping[str, SignalSource], time: Array, logged: Mapping[int, Any]):
        """
        Args:
            sources: the sources of the signals.
            time: times of the samples, s, (T,).
            logged: contents of the logs, (T, size) each or lists of T, by port number.
        """
        self.time, self._sources, self._logged = time, sources, logged
        self._steps: dict[DerivedBlock, _BlockSteps] = {}  # of blocks, some of whose outputs are not computed yet
        self._output_values: dict[DerivedBlock, dict[str, Array]] = {}  # outputs of blocks, by name
        self._products: dict[DerivedProduct, Array] = {}
        # Names and sources of joint angles that have not been read, by estimate.
        self._unread = {_estimate_of(s): (name, s) for name, s in sources.items() if name.endswith(f".{ANGLES}")}

    def __getitem__(self, name: str) -> Array:
        return self.values_of(self._sources[name])

    def is_logged(self, name: str) -> bool:
        """Whether a signal is read from a log, without computation."""
        return isinstance(self._sources[name], LoggedPort)

    def values_of(self, source: SignalSource) -> Any:
        """The values of a source at all samples."""
        values = self._values_of(source)
        estimate = _estimate_of(source)
        if estimate in self._unread:
            name, angles = self._unread[estimate]
            if source == angles or not np.isfinite(values).all():
                del self._unread[estimate]
                self._note_missing(name, self._values_of(angles))
        return values

    def _note_missing(self, name: str, values: Array) -> None:
        is_missing = ~np.isfinite(values).all(axis=1)
        if is_missing.any():
            first = float(self.time[is_missing][0])
            fraction = f"{is_missing.sum()} of {len(is_missing)}"
            _LOGGER.warning("%s: NaN in %s samples, first at t = %g s", name, fraction, first)

    def _values_of(self, source: SignalSource) -> Any:
        """Reads or computes the values of a source; keeps the steps of a block until its last output is computed."""
        if isinstance(source, LoggedPort):
            return self._logged[source.number]
        if isinstance(source, DerivedProduct):
            if source not in self._products:
                self._products[source] = self.values_of(source.source) @ source.gain.T
            return self._products[source]
        values = self._output_values.setdefault(source.derived, {})
        if source.name not in values:
            steps = self._steps.setdefault(source.derived, _BlockSteps(self, source.derived.leaves))
            values[source.name] = source.derived.block.output_over_time(source.name, steps)
            if len(values) == len(source.derived.outputs):
                del self._steps[source.derived]
        return values[source.name]


def _estimate_of(source: SignalSource) -> Any:
    """Key of the estimate that an output belongs to: block and finger; any other source is its own key."""
    return (source.derived.block, source.name.rpartition(".")[0]) if isinstance(source, DerivedOutput) else source


class _BlockSteps(dict[str, Any]):
    """The steps of a block that have been computed at all samples; leaves are read when a step takes them."""

    def __init__(self, samples: Samples, leaves: Mapping[str, SignalSource]):
        super().__init__({TIME: samples.time[:, None]})
        self._samples, self._leaves = samples, leaves

    def __missing__(self, leaf: str) -> Any:
        self[leaf] = self._samples.values_of(self._leaves[leaf])
        return self[leaf]
