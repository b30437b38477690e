"""The axes of signals that are recorded together, with their labels and units."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from soft_gripper.arrays import Array
from soft_gripper.signals import Signal

if TYPE_CHECKING:  # imported when a signal is read
    import xarray as xr

NO_UNIT = {"units": "1"}


@dataclass(frozen=True, eq=False)
class Labels:
    """Names and labels of the axes of signals, except time; one set serves all recordings of these signals."""

    axes: Mapping[str, Sequence[str]]  # names of the axes of each signal
    attributes: Mapping[str, Mapping[str, Any]]  # of each signal
    coords: "xr.Coordinates"  # of all axes

    def shape(self, signal: str) -> tuple[int, ...]:
        """The numbers of entries along the axes of a signal."""
        return tuple(self.coords.sizes[axis] for axis in self.axes[signal])


def labels_of(signals: Mapping[str, Signal]) -> Labels:
    """The labels of signals that are recorded together."""
    import xarray as xr

    names = _axis_names(signals)
    axes = dict[str, list[str]]()
    coords: dict[str, tuple[str, Array, Mapping[str, str]]] = {}
    for name, signal in signals.items():
        axes[name] = [names[name, axis] for axis in signal.axes]
        labels = zip(axes[name], signal.axes.values(), strict=True)
        coords |= {axis: (axis, np.array([*entries]), NO_UNIT) for axis, entries in labels}
        if not isinstance(signal.unit, str):
            coords[f"{axes[name][-1]}_units"] = (axes[name][-1], np.array(signal.unit), NO_UNIT)
    attributes = {name: _attributes(signal) for name, signal in signals.items()}
    return Labels(axes, attributes, xr.Dataset(coords=coords).coords)


def _axis_names(signals: Mapping[str, Signal]) -> dict[tuple[str, str], str]:
    """The name of each axis of each signal, with the owner or signal as prefix if labels differ.

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
        kinds: dict[str, set[Any]] = {}
        for name, axis, kind in axes:
            if (name, axis) in called:
                kinds.setdefault(called[name, axis], set()).add(kind)
        names |= {key: full for key, full in called.items() if len(kinds[full]) == 1}
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
