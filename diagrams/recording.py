"""Recording: every named signal of a run over time, as labelled arrays with units."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from pydrake.systems.framework import Context

from soft_gripper.arrays import Array
from soft_gripper.control.task import Phase
from soft_gripper.diagrams.contact_forces import ContactForces, contact_forces
from soft_gripper.diagrams.signal_labels import Labels
from soft_gripper.diagrams.signal_logs import SignalLogs
from soft_gripper.diagrams.signal_sources import Samples
from soft_gripper.errors import InputError
from soft_gripper.files.output import atomic_file
from soft_gripper.registry import registered

if TYPE_CHECKING:  # imported when a signal is read or plotted
    import xarray as xr
    from matplotlib.figure import Figure

_TIME = "time"


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
        """Reads a signal with its labels.

        Raises:
            InputError: if it was not recorded.
        """
        self._require(signal)
        return self.data[signal]

    def values(self, signal: str) -> Array:
        """The values of a signal, (T, ...), without their labels, which take longer; raises as to read it with them."""
        self._require(signal)
        values: Array = self.data.variables[signal].values
        return values

    def samples(self, signal: str) -> Array:
        """The samples of a signal that is sampled every period, each once, (T - 1, ...); raises as to read it.

        The first is recorded twice: at its own time too, as there is none before it.
        """
        return self.values(signal)[1:]

    @property
    def sample_numbers(self) -> NDArray[np.int_]:
        """The number in `samples` of the sample that is recorded at each time, (T,)."""
        return np.maximum(np.arange(self.data.sizes["time"]) - 1, 0)

    def _require(self, signal: str) -> None:
        if signal not in self:
            expected = "was not recorded; record.truth: all records all truth"
            raise InputError("recording", "signal", signal, expected)

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


def make_recording(labels: Labels, samples: Samples, about: Mapping[str, str] | None = None) -> Recording:
    """Labels the samples of signals, which are computed when they are first read; `about` as for `read_logs`."""
    return _SampledRecording(labels, samples, about or {})


class _SampledRecording(Recording):
    """Reads values from samples, and labels them once `data` is read: labelling a hundred signals takes long."""

    def __init__(self, labels: Labels, samples: Samples, about: Mapping[str, str]):
        vars(self)["_unlabelled"] = labels, samples, about

    @cached_property
    def data(self) -> "xr.Dataset":
        from soft_gripper.diagrams.signal_dataset import signal_dataset

        dataset = signal_dataset(*vars(self)["_unlabelled"])
        del vars(self)["_unlabelled"]  # samples that were all read are freed, with the diagram
        return dataset

    def __contains__(self, signal: str) -> bool:
        if "data" in vars(self):
            return super().__contains__(signal)
        labels: Labels = vars(self)["_unlabelled"][0]
        return signal == _TIME or signal in labels.axes or signal in labels.coords

    def values(self, signal: str) -> Array:
        labels, samples, _ = vars(self).get("_unlabelled", (None, None, None))
        if labels is None or signal not in (_TIME, *labels.axes):
            return super().values(signal)
        if signal == _TIME:
            return samples.time
        return samples[signal].reshape(len(samples.time), *labels.shape(signal))

    def __reduce__(self) -> Any:
        """A copy, in another process too, has the values."""
        return Recording, (self.data,)


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
