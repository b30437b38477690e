"""A figure of recorded signals: a panel for each signal and unit, in the units of figures, and states as bands."""

from collections.abc import Iterator, Sequence
from itertools import pairwise
from typing import NamedTuple

import matplotlib as mpl
import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from soft_gripper.arrays import Array

# Unit in a recording: unit in a figure, its factor, and the minimum span of an axis, so that rounding errors and
# negligible noise are not magnified.
SHOWN = {
    "m": ("mm", 1e3, 0.1),
    "Pa": ("kPa", 1e-3, 0.1),
    "rad": ("degrees", np.degrees(1.0), 0.1),
    "m/s": ("mm/s", 1e3, 0.1),
    "rad/s": ("degrees/s", np.degrees(1.0), 0.1),
    "N m": ("mN m", 1e3, 0.1),
    "m^2": ("mm^2", 1e6, 0.1),
    "N": ("N", 1.0, 0.01),
    "1/m": ("1/m", 1.0, 0.1),
    "s": ("s", 1.0, 0.01),
    "1": ("1", 1.0, 1e-3),
}
_MIN_SPAN_FRACTION = 0.02  # of the largest value, spanned by an axis
_MAX_LEGEND_LINES = 12  # lines that are all named
_SHORT_LEGEND_LINES = 5  # named lines among more
_MAX_COLUMN_LINES = 8  # lines of a legend in one column; more are in two
_CYCLE_COLORS = 10  # in Matplotlib's cycle; with more lines, colours come from a colormap
_PANEL_HEIGHT = 1.9  # inches
_BAND_HEIGHT = 0.55  # inches, of a band of states beside its title


class SignalPanel(NamedTuple):
    """Lines of one signal and unit over time, for one panel."""

    title: str
    unit: str
    least: float  # span of an axis, in the unit
    lines: Array  # (T, L), in the unit
    names: list[str]  # of the lines
    axis: str  # what the names count
    meanings: list[str]  # of the states 0, 1, 2 ...; empty: it is a quantity


def signals_figure(signals: Sequence[xr.DataArray]) -> Figure:
    """The panels of recorded signals over their common time, one below the other."""
    panels = [panel for signal in signals for panel in _panels(signal)]
    heights = [_BAND_HEIGHT * (1 + len(panel.names)) if panel.meanings else _PANEL_HEIGHT for panel in panels]
    figure = Figure(figsize=(8, sum(heights) + 0.3), layout="constrained")
    axes = figure.subplots(len(panels), sharex=True, squeeze=False, height_ratios=heights)[:, 0]
    time = signals[0]["time"].values
    for panel_axes, panel in zip(axes, panels, strict=True):
        _draw_states(panel_axes, time, panel) if panel.meanings else _draw_lines(panel_axes, time, panel)
        panel_axes.set_title(panel.title, loc="left", fontsize="medium")
        _add_legend(panel_axes, panel)
    axes[-1].set_xlabel("time [s]")
    if len(time) > 1:
        axes[-1].set_xlim(time[0], time[-1])
    figure.align_ylabels(axes)
    return figure


def _add_legend(axes: Axes, panel: SignalPanel) -> None:
    handles, labels = axes.get_legend_handles_labels()
    if handles:
        axes.legend(
            title=panel.axis,
            fontsize="x-small",
            title_fontsize="small",
            frameon=False,
            loc="center left",
            bbox_to_anchor=(1.0, 0.5),
            ncols=1 + (len(labels) > _MAX_COLUMN_LINES),
        )


def _panels(signal: xr.DataArray) -> Iterator[SignalPanel]:
    """The lines of a signal by their units."""
    axes = [str(dim) for dim in signal.dims if dim != "time"]
    stacked = signal.stack(entry=axes) if axes else signal.expand_dims("entry", axis=1)
    values = stacked.transpose("time", "entry").values
    labels = stacked["entry"].values if axes else [""]
    names = [" ".join(map(str, np.atleast_1d(label).tolist())) for label in labels]
    units = np.resize(signal.attrs.get("units", "1").split(", "), len(names))  # of the last axis, which varies fastest
    words = [word.replace("_", " ") for word in signal.attrs.get("flag_meanings", "").split()]
    for unit in dict.fromkeys(units.tolist()):
        indices = np.flatnonzero(units == unit)
        display_unit, scale, min_span = SHOWN.get(unit, (unit, 1.0, 0.0))
        lines = values[:, indices]
        if unit == "N m" and _largest(lines) >= 1.0:  # of an arm, not of a finger
            display_unit, scale = unit, 1.0
        unit_names = [names[i] for i in indices]
        title = f"{signal.name}: {unit_names[0]}" if len(indices) == 1 < len(names) else str(signal.name)
        yield SignalPanel(title, display_unit, min_span, scale * lines, unit_names, ", ".join(axes), words)


def _largest(values: Array) -> float:
    return float(np.abs(values[np.isfinite(values)]).max(initial=0.0))


def _draw_lines(axes: Axes, time: Array, panel: SignalPanel) -> None:
    count = len(panel.names)
    map_colors = mpl.colormaps["viridis"](np.linspace(0, 0.95, count))
    colors = [f"C{i}" for i in range(count)] if count <= _CYCLE_COLORS else map_colors
    entries = np.linspace(0, count - 1, count if count <= _MAX_LEGEND_LINES else _SHORT_LEGEND_LINES)
    labelled_entries = entries.round().astype(int)
    for i, (name, color) in enumerate(zip(panel.names, colors, strict=True)):
        axes.plot(time, panel.lines[:, i], color=color, label=name if count > 1 and i in labelled_entries else None)
    finite = panel.lines[np.isfinite(panel.lines)]
    if len(finite):
        min_span = max(_MIN_SPAN_FRACTION * _largest(finite), panel.least)
        if np.ptp(finite) < min_span:
            middle = float(finite.min() + finite.max()) / 2
            axes.set_ylim(middle - min_span, middle + min_span)
    axes.ticklabel_format(axis="y", useOffset=False)
    axes.set_ylabel(f"[{panel.unit}]")
    axes.grid(alpha=0.3)


def _draw_states(axes: Axes, time: Array, panel: SignalPanel) -> None:
    """A band for each entry, in the colours of the states that it is in, from each sample to the next."""
    labelled_states = set[int]()
    ends = np.append(time[1:], time[-1:])
    for row, states in enumerate(panel.lines.T):
        state_numbers = np.where(np.isfinite(states), states, -1.0).astype(int)
        bounds = np.unique([0, *(np.flatnonzero(np.diff(state_numbers)) + 1), len(state_numbers)])
        for begin, end in pairwise(bounds.tolist()):
            state = int(state_numbers[begin])
            if 0 <= state < len(panel.meanings):
                label = None if state in labelled_states else panel.meanings[state]
                labelled_states.add(state)
                span = (time[begin], ends[end - 1] - time[begin])
                axes.broken_barh([span], (row - 0.4, 0.8), color=_state_color(state), label=label, lw=0)
    axes.set_yticks(range(len(panel.names)), panel.names)
    axes.set_ylim(len(panel.names) - 0.5, -0.5)


def _state_color(state: int) -> tuple[float, ...]:
    """Colour of a state; the first, which needs no attention, is pale."""
    return (0.9, 0.9, 0.9, 1.0) if state == 0 else mpl.colormaps["tab20"]((2 * (state - 1) + (state > 10)) % 20)
