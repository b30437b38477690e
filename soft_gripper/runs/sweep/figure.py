"""What a sweep of one or two keys came to, as a figure."""

from collections.abc import Mapping, Sequence
from contextlib import suppress

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.figure import Figure

from soft_gripper.arrays import Array
from soft_gripper.pictures.style import STYLE

PANELS = 4  # measures that are drawn, at most
Column = Sequence[str]


def sweep_figure(varied: Mapping[str, Column], measured: Mapping[str, Column], title: str) -> Figure | None:
    """Measures against one key as lines of points, against two as maps; None for more keys, or if nothing is a number.

    Args:
        varied: cells of the keys that vary.
        measured: cells of the measures; empty where a run failed.
        title: of the figure.
    """
    numbers = {name: _numbers(cells) for name, cells in measured.items()}
    drawn = {name: values for name, values in numbers.items() if np.isfinite(values).any()}
    if len(varied) not in (1, 2) or not drawn:
        return None
    with mpl.rc_context(STYLE):
        drawn = dict(list(drawn.items())[:PANELS])
        figure = Figure(figsize=(4.2 * len(drawn), 3.6), layout="constrained")
        figure.suptitle(title, x=0.01, ha="left")
        for axes, (name, values) in zip(figure.subplots(1, len(drawn), squeeze=False)[0], drawn.items(), strict=True):
            places = [_place(axes, axis, cells) for axis, cells in zip("xy", varied.values(), strict=False)]
            for axis, key in zip("xy", varied, strict=False):
                axes.set(**{f"{axis}label": key})
            if len(places) == 1:
                _draw_line(axes, places[0], values, name)
            else:
                _draw_map(figure, axes, places, values, name)
    return figure


def _numbers(cells: Column) -> Array:
    """Cells as numbers; NaN for those that are none."""
    found = np.full(len(cells), np.nan)
    for i, text in enumerate(cells):
        with suppress(ValueError):
            found[i] = {"True": 1.0, "False": 0.0}.get(text) or float(text.removesuffix("%"))
    return found


def _place(axes: Axes, axis: str, cells: Column) -> Array:
    """Where cells lie along an axis; in the order in which they appear if they are no numbers."""
    numbers = _numbers(cells)
    if np.isfinite(numbers).all():
        return numbers
    labels = list(dict.fromkeys(cells))
    axes.set(**{f"{axis}ticks": range(len(labels)), f"{axis}ticklabels": labels})
    return np.array([float(labels.index(text)) for text in cells])


def _draw_line(axes: Axes, place: Array, values: Array, name: str) -> None:
    order = np.argsort(place, kind="stable")
    axes.plot(place[order], values[order], "o-", ms=4)
    axes.set_ylabel(name)
    axes.grid(alpha=0.3)


def _draw_map(figure: Figure, axes: Axes, places: Sequence[Array], values: Array, name: str) -> None:
    """A field a point where they lie on a grid, a dot a point where not; failed runs are crosses."""
    (x, y), failed = places, ~np.isfinite(values)
    columns, rows = np.unique(x), np.unique(y)
    if len(columns) * len(rows) == len(x) and min(len(columns), len(rows)) > 1:
        grid = np.full((len(rows), len(columns)), np.nan)
        grid[np.searchsorted(rows, y), np.searchsorted(columns, x)] = values
        drawn: ScalarMappable = axes.pcolormesh(columns, rows, grid, shading="nearest")
    else:
        drawn = axes.scatter(x[~failed], y[~failed], c=values[~failed], s=20)
    axes.grid(False)
    axes.plot(x[failed], y[failed], "x", color="#b2182b")
    figure.colorbar(drawn, ax=axes, label=name)
