"""Recording: every named signal of a run over time, as labelled arrays with units.

An ArrayBlock computes its outputs at all samples of a recording from its inputs at all samples. So a port of such a
block needs no log if its inputs can be traced back to logged ports.
"""

import logging
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache, cached_property
from importlib.metadata import version
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from pydrake.common.value import AbstractValue
from pydrake.multibody.plant import MultibodyPlant
from pydrake.systems.framework import (
    Context,
    Diagram,
    DiagramBuilder,
    EventStatus,
    InputPort,
    LeafSystem,
    OutputPort,
    PortDataType,
    System,
)
from pydrake.systems.primitives import Multiplexer, VectorLogSink

from soft_gripper.array_block import ArrayBlock
from soft_gripper.arrays import Array
from soft_gripper.cached import Cached
from soft_gripper.control.task import Phase
from soft_gripper.diagrams.contact_forces import ContactForces, contact_forces
from soft_gripper.diagrams.wires import Level
from soft_gripper.errors import InputError
from soft_gripper.estimators.finger_shape import ANGLES
from soft_gripper.files.notes import Note, as_text
from soft_gripper.files.output import atomic_file
from soft_gripper.registry import registered
from soft_gripper.scenario.scenario_file import dump_scenario
from soft_gripper.scenario.schema import Scenario
from soft_gripper.signals import Signal, signal_of
from soft_gripper.steps import TIME

if TYPE_CHECKING:  # imported when a signal is read or plotted
    import xarray as xr
    from matplotlib.figure import Figure


_LOGGER = logging.getLogger(__name__)


class Logged(NamedTuple):
    """A logged port, by its index in `SignalSources.ports`.

    Logs hold on to it after the diagram is built; a reference to the port itself would keep the diagram alive.
    """

    number: int


@dataclass(eq=False)
class Derived:
    """Outputs of a block that are computed from the same outputs of other blocks."""

    block: ArrayBlock
    leaves: dict[str, "Source"]  # by port name of the block
    outputs: list[str] = field(default_factory=list)  # names of the requested outputs


class Output(NamedTuple):
    """One output of such a block."""

    of: Derived
    name: str


Source = Logged | Output


class SignalSources:
    """Finds the ports from which signals of a diagram can be computed, sampled every `period` s.

    Use it before the diagram is built.

    `ports` are those that may need a log, or inputs that they feed.
    """

    def __init__(self, builder: DiagramBuilder, period: float):
        self.ports: list[OutputPort | InputPort] = []
        self._numbers: dict[tuple[System, int], int] = {}  # of `ports`, by the system and index of the output
        self._root, self._period = Level.root(builder), period
        self._blocks: dict[tuple[System, frozenset[str]], Derived] = {}
        self._outputs: dict[tuple[System, str], Output | None] = {}

    def find(self, port: OutputPort) -> Source:
        """The source of a port of the builder's systems."""
        return self._trace(port, self._root) or self._logged(port)

    def _logged(self, port: OutputPort) -> Logged:
        return self._log(port.get_system(), port.get_index(), port)

    def _log(self, system: System, index: int, port: OutputPort | InputPort) -> Logged:
        key = system, index
        if key not in self._numbers:
            self._numbers[key] = len(self.ports)
            self.ports.append(port)
        return Logged(self._numbers[key])

    def _trace(self, port: OutputPort, level: Level) -> Source | None:
        """Source of a port at any level; None if it depends on an output that the root diagram does not export."""
        port, level = level.leaf_output(port)
        system = port.get_system()
        if isinstance(system, ArrayBlock) and system.follows(port.get_name(), self._period):
            output = self._follow(system, port.get_name(), level)
            if output is not None:
                return output
        shown = level.exported(port)
        return None if shown is None else self._logged(shown)

    def _follow(self, system: ArrayBlock, name: str, level: Level) -> Output | None:
        """An output of a block, if all its sources are known; None also during the search itself, in a loop."""
        key = system, name
        if key not in self._outputs:
            self._outputs[key] = None
            leaves = {leaf: self._leaf(system, leaf, level) for leaf in system.leaves(name)}
            found = {leaf: source for leaf, source in leaves.items() if source is not None}
            if len(found) == len(leaves):
                block = self._blocks.setdefault((system, frozenset(found)), Derived(system, found))
                block.outputs.append(name)
                self._outputs[key] = Output(block, name)
        return self._outputs[key]

    def _leaf(self, system: ArrayBlock, name: str, level: Level) -> Source | None:
        if system.HasInputPort(name):
            fed = level.feed(system.GetInputPort(name))
            if fed is not None and isinstance(fed.system, MultibodyPlant) and fed.level.diagram is None:
                return self._log(fed.system, fed.output_index, fed.input)
            return None if fed is None else self._trace(fed.output, fed.level)
        shown = level.exported(system.GetOutputPort(name))
        return None if shown is None else self._logged(shown)


class Samples(Mapping[str, Array]):
    """Signals at all samples of a run, (T, size) each, by name; those of blocks are computed when they are read.

    A warning is logged if an estimator left joint angles NaN, as it does without readings, when they, or other signals
    of the estimate that are NaN, are first read.
    """

    def __init__(self, sources: Mapping[str, Source], time: Array, logged: Mapping[int, Any]):
        """
        Args:
            sources: the sources of the signals.
            time: times of the samples, s, (T,).
            logged: contents of the logs, (T, size) each or lists of T, by port number.
        """
        self.time, self._sources, self._logged = time, sources, logged
        self._known: dict[Derived, _KnownSteps] = {}  # of blocks, some of whose outputs are not computed yet
        self._computed: dict[Derived, dict[str, Array]] = {}  # outputs of blocks, by name
        # Names and sources of joint angles that have not been read, by estimate.
        self._unread = {_estimate_of(s): (name, s) for name, s in sources.items() if name.endswith(f".{ANGLES}")}

    def __getitem__(self, name: str) -> Array:
        values: Array = self.values_of(self._sources[name])
        return values

    def __iter__(self) -> Iterator[str]:
        return iter(self._sources)

    def __len__(self) -> int:
        return len(self._sources)

    def is_logged(self, name: str) -> bool:
        """Whether a signal is known without computing it."""
        return isinstance(self._sources[name], Logged)

    def values_of(self, source: Source) -> Any:
        """The values of a source at all samples."""
        values, estimate = self._values_of(source), _estimate_of(source)
        if estimate in self._unread:
            name, angles = self._unread[estimate]
            if source == angles or not np.isfinite(values).all():
                del self._unread[estimate]
                self._note_missing(name, self._values_of(angles))
        return values

    def _note_missing(self, name: str, values: Array) -> None:
        is_missing = ~np.isfinite(values).all(axis=1)
        if is_missing.any():
            first, share = float(self.time[is_missing][0]), f"{is_missing.sum()} of {len(is_missing)}"
            _LOGGER.warning("%s: NaN in %s samples, first at t = %g s", name, share, first)

    def _values_of(self, source: Source) -> Any:
        """Reads or computes them; the steps of a block are kept until its last output is computed."""
        if isinstance(source, Logged):
            return self._logged[source.number]
        computed = self._computed.setdefault(source.of, {})
        if source.name not in computed:
            known = self._known.setdefault(source.of, _KnownSteps(self, source.of.leaves))
            computed[source.name] = source.of.block.output_over_time(source.name, known)
            if len(computed) == len(source.of.outputs):
                del self._known[source.of]
        return computed[source.name]


def _estimate_of(source: Source) -> Any:
    """What the outputs of a block for one finger share; a logged port is by itself."""
    return source if isinstance(source, Logged) else (source.of.block, source.name.rpartition(".")[0])


class _KnownSteps(dict[str, Any]):
    """The steps of a block that have been computed at all samples; leaves are read when a step takes them."""

    def __init__(self, samples: Samples, leaves: Mapping[str, Source]):
        super().__init__({TIME: samples.time[:, None]})
        self._samples, self._leaves = samples, leaves

    def __missing__(self, leaf: str) -> Any:
        self[leaf] = self._samples.values_of(self._leaves[leaf])
        return self[leaf]


class ValueLog(LeafSystem):
    """Logs the values of a port as a VectorLogSink logs vectors: in its context, from the beginning of a run.

    ::

        value (any Python object) ---> ValueLog
    """

    def __init__(self, period: float):
        """Samples a value every `period` s."""
        super().__init__()
        self._value = self.DeclareAbstractInputPort("value", AbstractValue.Make(object()))
        self._log = Cached(self, "log", lambda _, value: value.set_value([]), {self.nothing_ticket()})
        self.DeclarePeriodicPublishEvent(period, 0.0, self._keep)
        self.DeclareForcedPublishEvent(self._keep)

    def values(self, root_context: Context) -> list[Any]:
        """The logged values, from the context of the root diagram."""
        log: list[Any] = self._log.Eval(self.GetMyContextFromRoot(root_context))
        return log

    def _keep(self, context: Context) -> EventStatus:
        self._log.Eval(context).append(self._value.Eval(context))
        return EventStatus.Succeeded()


class SignalLogs(Diagram):
    """Logs the sources of signals, sampled every `period` s; with an input port for each.

    Vectors share one log, because each additional system in a diagram costs time at every step.
    """

    def __init__(self, signals: Mapping[str, OutputPort], sources: SignalSources, period: float):
        """`signals` are vector ports by name in the recording; units and axes are read from the ports."""
        super().__init__()
        builder = DiagramBuilder()
        self.signals: dict[str, Signal] = {name: signal_of(port) for name, port in signals.items()}
        self._sources = {name: sources.find(port) for name, port in signals.items()}
        names = _logged_ports(self._sources, sources.ports)
        ports = {i: sources.ports[i] for i in names}
        self._sizes = {i: p.size() for i, p in ports.items() if p.get_data_type() == PortDataType.kVectorValued}
        self._values: dict[int, ValueLog] = {}
        together = builder.AddNamedSystem("vectors", Multiplexer([*self._sizes.values()]))
        self._sink = builder.AddNamedSystem("log", VectorLogSink(together.get_output_port().size(), period))
        builder.Connect(together.get_output_port(), self._sink.get_input_port())
        for i, number in enumerate(self._sizes):
            builder.ExportInput(together.get_input_port(i), names[number])
        for number, name in names.items():
            if number not in self._sizes:
                self._values[number] = builder.AddNamedSystem(name, ValueLog(period))
                builder.ExportInput(self._values[number].get_input_port(), name)
        builder.BuildInto(self)

    @cached_property
    def labels(self) -> "dict[str, Labels]":
        """The axes of all signals."""
        return labels_of(self.signals)

    @property
    def logged(self) -> list[int]:
        """The logged ports, in the order of the inputs, by their indices among those of the sources."""
        return [*self._sizes, *self._values]

    def samples(self, root_context: Context) -> Samples:
        """All signals, in the context of the root diagram."""
        return self.computed(*self.taken(root_context))

    def taken(self, root_context: Context) -> tuple[Array, dict[int, Any]]:
        """Times, (T,) s, and a copy of the logs, by port number, in the context of the root diagram."""
        log = self._sink.FindLog(root_context)
        ends = np.cumsum([*self._sizes.values()])
        vectors = dict(zip(self._sizes, np.split(log.data().T.copy(), ends[:-1], axis=1), strict=True))
        values = {number: [*sink.values(root_context)] for number, sink in self._values.items()}
        return log.sample_times().copy(), vectors | values

    def computed(self, time: Array, logged: Mapping[int, Any]) -> Samples:
        """The samples in what was `taken`; unlike that, in any thread."""
        return Samples(self._sources, time, logged)

    def clear(self, root_context: Context) -> None:
        """Forgets all samples, in the context of the root diagram."""
        self._sink.FindMutableLog(root_context).Clear()
        for sink in self._values.values():
            sink.values(root_context).clear()


def add_logs(builder: DiagramBuilder, signals: Mapping[str, OutputPort], period: float) -> SignalLogs:
    """Adds `logs` to any diagram; `read_logs` makes a Recording of all their signals after a run.

    Args:
        builder: builder of the diagram, in which the sources of the signals are connected.
        signals: vector ports by name in the recording, such as "left_finger.strain".
        period: sampling period, s.
    """
    sources = SignalSources(builder, period)
    logs = SignalLogs(signals, sources, period)
    builder.AddNamedSystem("logs", logs)
    for i, number in enumerate(logs.logged):
        port = sources.ports[number]
        connect = builder.ConnectToSame if isinstance(port, InputPort) else builder.Connect
        connect(port, logs.get_input_port(i))
    return logs


def _logged_ports(sources: Mapping[str, Source], ports: Sequence[OutputPort | InputPort]) -> dict[int, str]:
    """The ports that need a log, with the name of each log: that of the signal, if the port is a signal."""
    found = {source.number: name for name, source in reversed(list(sources.items())) if isinstance(source, Logged)}
    blocks = [source.of for source in sources.values() if not isinstance(source, Logged)]
    while blocks:
        for source in blocks.pop().leaves.values():
            if isinstance(source, Logged):
                port = ports[source.number]
                found.setdefault(source.number, f"{port.get_system().get_name()}.{port.get_name()}")
            else:
                blocks.append(source.of)
    return found


_NO_UNIT = {"units": "1"}


@dataclass(frozen=True)
class Recording:
    """One variable per named signal, such as `left_finger.strain`, over a common `time` (s).

    Every variable and every coordinate has the attribute `units`, "1" if dimensionless, as in the CF conventions; if
    entries differ, the units along the last axis, "m, m, rad", which are also in the coordinate `{axis}_units`.
    A signal that encodes states as numbers names them in `flag_meanings`. A value at time t is the value of the port at
    t: a sampled signal still has the sample before the one taken at t. The attributes of the recording describe the
    run, see `provenance`. Signals that follow from others are computed when they are first read.
    """

    data: "xr.Dataset"

    @property
    def signals(self) -> list[str]:
        """The names of all signals."""
        return list(map(str, self.data))

    def __contains__(self, signal: str) -> bool:
        return signal in self.data

    def __getitem__(self, signal: str) -> "xr.DataArray":
        """A signal.

        Raises:
            InputError: if it was not recorded.
        """
        if signal not in self:
            expected = "was not recorded; of the ground truth, everything is with record.truth: all"
            raise InputError("recording", "signal", signal, expected)
        return self.data[signal]

    def values(self, signal: str) -> Array:
        """The values of a signal, (T, ...), without their labels; raises as to read it with them."""
        found: Array = self[signal].values
        return found

    def save(self, path: Path | str) -> None:
        """Writes one netCDF 4 file, compressed, which xarray, MATLAB (ncread) and Julia (NCDatasets) open.

        Extras may write other forms, by the ending of the name.
        """
        file = Path(path)
        write = registered("RECORDINGS").get(file.suffix)
        if write is not None:
            write(self.data, file)
            return
        from soft_gripper.diagrams.recording_file import write_netcdf

        with atomic_file(file) as partial:
            write_netcdf(self.data, partial)

    @staticmethod
    def load(path: Path | str) -> "Recording":
        """Reads a file written by `save`.

        Raises:
            InputError: if the file does not exist, is not netCDF 3 or 4, or is damaged.
        """
        from soft_gripper.diagrams.recording_file import read_netcdf

        return Recording(read_netcdf(Path(path)))

    def forces(self) -> ContactForces:
        """The contact force of every finger over time, true and estimated, with the band of the estimate.

        ``print(recording.forces())`` prints those at the end, ``recording.forces().at(3.0)`` gives those at 3 s, and
        ``recording.forces().data["transverse"]`` is the estimate over time.

        Raises:
            InputError: if no contact force was recorded, true or estimated.
        """
        return contact_forces(self.data)

    def plot(self, *signals: str) -> "Figure":
        """Plots signals over time, one below the other, with a line for each entry of a vector.

        Each unit of a signal has a panel, in mm, kPa and degrees; states are bands with their meanings.

        Raises:
            InputError: if a signal was not recorded.
        """
        from soft_gripper.diagrams.recording_figure import signals_figure

        return signals_figure([self[signal] for signal in signals])


def read_logs(logs: SignalLogs, root_context: Context, about: Mapping[str, str] | None = None) -> Recording:
    """Collects the logs of a diagram after a run.

    Args:
        logs: the logs of the diagram.
        root_context: the context of the root diagram.
        about: attributes of the recording, see `provenance`.
    """
    recording = make_recording(logs.labels, logs.samples(root_context), about)
    recording.data.load()  # or the diagram would live as long as its recording
    return recording


@dataclass(frozen=True, eq=False)
class Labels:
    """The axes of a signal in a recording."""

    axes: Mapping[str, Sequence[Any]]  # labels by the names of the axes, without time
    coords: Mapping[str, tuple[str, Array, Mapping[str, str]]]  # of these axes
    attributes: Mapping[str, Any]

    @cached_property
    def indexed(self) -> "xr.Coordinates":
        """The `coords` with their indexes, made once for all recordings that have this signal."""
        import xarray as xr

        return xr.Dataset(coords=self.coords).coords


def labels_of(signals: Mapping[str, Signal]) -> dict[str, Labels]:
    """The axes of signals that are recorded together."""
    names, found = _axis_names(signals), {}
    for name, signal in signals.items():
        axes = {names[name, axis]: list(values) for axis, values in signal.axes.items()}
        coords = {axis: (axis, np.array(entries), _NO_UNIT) for axis, entries in axes.items()}
        if not isinstance(signal.unit, str):
            last = list(axes)[-1]
            coords[f"{last}_units"] = (last, np.array(signal.unit), _NO_UNIT)
        found[name] = Labels(axes, coords, _attributes(signal))
    return found


def make_recording(labels: Mapping[str, Labels], samples: Samples, about: Mapping[str, str] | None = None) -> Recording:
    """Labels the samples of signals, which are computed when they are read; `about` as for `read_logs`."""
    from soft_gripper.diagrams.sampled_recording import SampledRecording

    return SampledRecording(labels, samples, about or {})


def _axis_names(signals: Mapping[str, Signal]) -> dict[tuple[str, str], str]:
    """The name of each axis of each signal, prefixed with that of the owner or the signal if labels differ.

    Two fingers with equally many joints share the axis `joint`; otherwise, each has its own, such as
    `left_finger.joint`.
    """
    axes = [(name, axis, _kind(signal, axis)) for name, signal in signals.items() for axis in signal.axes]
    names: dict[tuple[str, str], str] = {}
    for form in ("{axis}", "{owner}.{axis}", "{name}.{axis}"):
        called = {
            (name, axis): form.format(axis=axis, owner=name.rpartition(".")[0] or name, name=name)
            for name, axis, _ in axes
            if (name, axis) not in names
        }
        found: dict[str, set[Any]] = {}
        for name, axis, kind in axes:
            if (name, axis) in called:
                found.setdefault(called[name, axis], set()).add(kind)
        names |= {key: full for key, full in called.items() if len(found[full]) == 1}
    return names


def _kind(signal: Signal, axis: str) -> tuple[Any, ...]:
    """The labels along an axis, and their units if these differ."""
    are_mixed = not isinstance(signal.unit, str) and axis == list(signal.axes)[-1]
    return tuple(signal.axes[axis]), signal.unit if are_mixed else None


def _attributes(signal: Signal) -> dict[str, Any]:
    unit = {"units": signal.unit if isinstance(signal.unit, str) else ", ".join(signal.unit)}
    if not signal.meanings:
        return unit
    meanings = " ".join(meaning.replace(" ", "_") for meaning in signal.meanings)
    return {**unit, "flag_values": np.arange(len(signal.meanings), dtype=float), "flag_meanings": meanings}


class Span(NamedTuple):
    """A phase as executed."""

    phase: Phase
    begin: float  # s
    end: float


def phase_spans(recording: Recording, phases: Sequence[Phase]) -> list[Span]:
    """The phases in the order of execution, without the time after the last.

    `phases` are those of the TaskMachine, including rescues, by number.
    """
    signal = recording["task.phase"]
    times, numbers = signal["time"].values, signal.values.astype(int)
    bounds = pairwise([0, *(np.flatnonzero(np.diff(numbers)) + 1), len(times) - 1])
    return [
        Span(phases[numbers[begin]], float(times[begin]), float(times[end]))
        for begin, end in bounds
        if numbers[begin] < len(phases) and begin < end
    ]


FRAMES = (
    "SI units. W: the world. B: base of a finger, +z along the straight finger, +x toward the object; positive joint"
    " angles close it. joint_positions and tip_pose are in B, of an estimate in space as seen in the bending plane;"
    " estimated_joint_positions and estimated_tip_position are in B, joint_positions_world, contact_center and the"
    " rows of X_WB in W. A {object}.pose is its first link in W, a quaternion w x y z and a position; a contact_wrench"
    " acts on it about its origin, in W. An external torque is positive if it closes the finger and belongs to two"
    " samples before, or to the current sample if the estimator itself gives it (constant_curvature);"
    " external_torque_error is the difference from the true torque two samples before. true_external_torque belongs to"
    " the current sample. A true_contact_force acts across the finger, positive on the inner side, and the transverse"
    " force at right angles to the line from the base to the contact;"
    " true_contact_arc_length is its location, from the base, and true_contact_side the direction from which it"
    " presses, around the finger: 0 on the inner side, pi/2 on the side toward +y. true_contact_force_world is the sum"
    " of all contact forces on the finger, friction included, in W. true_sideways_torque and true_twist_torque are"
    " external torques about x and z at the joints."
)


_POINTS = (
    "points on either side of every link of a finger; held objects creep faster than under contact over the surface,"
    " the faster, the fewer points: in the box grasp 0.08 mm/s with 4 points, 0.03 mm/s over the surface"
)


@cache
def _versions() -> str:
    return ", ".join(f"{name} {version(name)}" for name in ("soft-gripper", "drake", "numpy"))


def provenance(scenario: Scenario, sensor: str, estimator: str, notes: Iterable[Note] = ()) -> dict[str, str]:
    """Attributes of a recording: description, scenario as YAML, versions, frames, and notes on files, if there are any.

    `sensor` and `estimator` name the blocks, which may be user blocks instead of the scenario's.
    """
    return {
        "description": scenario.description,
        "contact": "surface" if scenario.contact == "surface" else f"{scenario.contact_points} {_POINTS}",
        "scenario": dump_scenario(scenario),
        "sensor": sensor,
        "estimator": estimator,
        "versions": _versions(),
        "frames": FRAMES,
        **({"notes": said} if (said := as_text(notes)) else {}),
    }
