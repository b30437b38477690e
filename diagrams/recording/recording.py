"""Recording: every named signal of a run over time, as labelled arrays with units."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from pydrake.systems.framework import Context

from soft_gripper.diagrams.recording.signal_logs import SignalLogs
from soft_gripper.errors import InputError, first_line, shortened
from soft_gripper.files.document import require
from soft_gripper.files.output import atomic_file
from soft_gripper.files.text import check_regular
from soft_gripper.signals import Signal

_MAGICS = (b"CDF\x01", b"CDF\x02")  # the first bytes of a netCDF 3 file
_LARGEST = 8  # times the size of the file: its arrays in memory, where text takes more

_LEGEND_LINES = 12  # entries; with more there is no legend
_NO_UNIT = {"units": "1"}
_OWN_COLORS = 10  # in Matplotlib's cycle; more lines take their colours from a scale


@dataclass(frozen=True)
class Recording:
    """One variable per named signal, such as `left_finger.strain`, over a common `time` (s).

    Every variable and every coordinate has the attribute `units`, "1" for none, as in the CF conventions; if entries
    differ, the units of those along the last axis, "m, m, rad", which are in the coordinate `{axis}_units` too.
    A signal that numbers states names them in `flag_meanings`. A value at time t is the value of the port at t: a
    sampled signal still has the sample before the one that is taken at t. The attributes of the recording describe the
    run, see `provenance`.
    """

    data: xr.Dataset

    def __getitem__(self, signal: str) -> xr.DataArray:
        return self.data[signal]

    def save(self, path: Path | str) -> None:
        """Writes one netCDF file, which xarray, MATLAB (ncread) and Julia (NCDatasets) open."""
        with atomic_file(Path(path)) as partial:
            self.data.to_netcdf(partial, engine="scipy")

    @staticmethod
    def load(path: Path | str) -> "Recording":
        """Reads a file that `save` wrote.

        Raises:
            InputError: if there is no such file, or it is not a netCDF 3 file, or damaged.
        """
        file = Path(path)
        check_regular(file)
        try:
            with file.open("rb") as opened:
                begin = opened.read(len(_MAGICS[0]))
            require(begin in _MAGICS, file, "file", file.name, "is not a netCDF 3 file")
            with xr.open_dataset(file, engine="scipy") as data:
                fits = data.nbytes <= _LARGEST * file.stat().st_size
                require(fits, file, "size", data.nbytes, "is damaged: its arrays are larger than the file")
                return Recording(data.load())
        except InputError:
            raise
        except Exception as error:  # parsers do not document their exceptions
            expected = f"is a damaged netCDF 3 file: {shortened(first_line(error), 100)}"
            raise InputError(file, "file", file.name, expected) from None

    def plot(self, *signals: str) -> Figure:
        """Plots signals over time, one below the other, with a line for every entry of a vector."""
        figure = Figure(figsize=(8, 2.2 * len(signals)), layout="constrained")
        panels = figure.subplots(len(signals), sharex=True, squeeze=False)[:, 0]
        for axes, signal in zip(panels, signals, strict=True):
            _draw(axes, self.data[signal])
        panels[-1].set_xlabel("time [s]")
        return figure


def _draw(axes: Axes, signal: xr.DataArray) -> None:
    others = [str(dim) for dim in signal.dims if dim != "time"]
    lines = signal.stack(entry=others) if others else signal.expand_dims(entry=[("",)], axis=1)
    count = len(lines["entry"])
    many = mpl.colormaps["viridis"](np.linspace(0, 0.95, count))
    colors = [f"C{i}" for i in range(count)] if count <= _OWN_COLORS else many
    for entry, line, color in zip(lines["entry"].values, lines.transpose("entry", "time"), colors, strict=True):
        axes.plot(signal["time"], line, label=" ".join(map(str, np.atleast_1d(entry).tolist())), color=color)
    if 1 < count <= _LEGEND_LINES:
        axes.legend(title=", ".join(others), fontsize="x-small", ncols=3)
    axes.set_title(str(signal.name), loc="left", fontsize="medium")
    axes.set_ylabel(f"[{', '.join(dict.fromkeys(signal.attrs.get('units', '1').split(', ')))}]")
    axes.grid(alpha=0.3)


def read_logs(logs: SignalLogs, root_context: Context, about: Mapping[str, str] | None = None) -> Recording:
    """Collects the logs of a diagram after a run.

    Args:
        logs: of the diagram.
        root_context: of the whole diagram.
        about: attributes of the recording, see `provenance`.
    """
    names, variables = _axis_names(logs.signals), {}
    coords: dict[str, Any] = {}
    time, samples = logs.samples(root_context)
    for name, signal in logs.signals.items():
        labels = {names[name, axis]: list(values) for axis, values in signal.axes.items()}
        values = samples[name].reshape(-1, *map(len, labels.values()))
        variables[name] = (["time", *labels], values, _attributes(signal))
        coords |= {axis: (axis, np.array(entries), _NO_UNIT) for axis, entries in labels.items()}
        if not isinstance(signal.unit, str):
            last = list(labels)[-1]
            coords[f"{last}_units"] = (last, np.array(signal.unit), _NO_UNIT)
    coords["time"] = ("time", time, {"units": "s"})
    return Recording(xr.Dataset(variables, coords, dict(about or {})))


def _axis_names(signals: Mapping[str, Signal]) -> dict[tuple[str, str], str]:
    """The name of each axis of each signal: its own; prefixed with that of the owner or the signal if kinds differ.

    Two fingers with as many joints share the axis `joint`; else there are `left_finger.joint` and `right_finger.joint`.
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
