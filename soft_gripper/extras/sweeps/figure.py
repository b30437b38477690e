"""The figure of a sweep over one or two keys."""

from collections.abc import Mapping, Sequence

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.figure import Figure

from soft_gripper.arrays import Array
from soft_gripper.extras.sweeps.cells import Column, numbers_in
from soft_gripper.extras.sweeps.measured_runs import GRASP
from soft_gripper.pictures.style import STYLE
from soft_gripper.runs.scores.grasp import HELD

PANELS = 4  # maximum number of measures drawn
_MAX_TICKS = 9  # values of a key that each have a tick
_MAX_VECTORS = 5_000  # points that an SVG has as such; more are an image in it


def sweep_figure(varied: Mapping[str, Column], measures: Mapping[str, Column], title: str) -> Figure | None:
    """Plots measures over one key as lines, over two keys as maps; None for more keys, or if no measure is numeric.

    The first few measures that vary are drawn; runs whose object is not held are crossed out.

    Args:
        varied: cells of the varied keys.
        measures: cells of the measures; empty if a run failed.
        title: title of the figure.
    """
    numbers = {name: numbers_in(cells) for name, cells in measures.items()}
    panels = {name: values for name, values in numbers.items() if np.isfinite(values).any()}
    panels = {name: values for name, values in panels.items() if _varies(values)} or panels
    if len(varied) not in (1, 2) or not panels:
        return None
    with mpl.rc_context(STYLE):
        panels = dict(list(panels.items())[:PANELS])
        is_lost = np.array([cell not in ("", HELD) for cell in measures.get(GRASP, ())], bool)
        title += ", crosses: not held" if is_lost.any() else ""
        figure = Figure(figsize=(4.2 * len(panels), 3.6), layout="constrained")
        figure.suptitle(title, x=0.01, ha="left")
        for axes, (name, values) in zip(figure.subplots(1, len(panels), squeeze=False)[0], panels.items(), strict=True):
            places = [axis_positions(axes, axis, cells) for axis, cells in zip("xy", varied.values(), strict=False)]
            for axis, (key, cells) in zip("xy", varied.items(), strict=False):
                axes.set(**{f"{axis}label": f"{key} [%]" if cells[0].endswith("%") else key})
            if len(places) == 1:
                _draw_line(axes, places[0], values, name)
            else:
                _draw_map(figure, axes, places, values, name)
            if is_lost.any():
                y = places[1] if len(places) > 1 else values
                axes.plot(places[0][is_lost], y[is_lost], "x", color="#b2182b", ms=7, rasterized=len(y) > _MAX_VECTORS)
    return figure


def _varies(values: Array) -> bool:
    """Whether numbers, of which some may be NaN, differ by more than a thousandth."""
    return bool(np.ptp(values[np.isfinite(values)]) > 1e-3 * np.nanmax(np.abs(values)))


def axis_positions(axes: Axes, axis: str, cells: Column) -> Array:
    """Positions of cells along an axis, with a tick at each if there are few; numbers, or in order of appearance."""
    numbers = numbers_in(cells)
    if np.isfinite(numbers).all():
        if len(values := np.unique(numbers)) <= _MAX_TICKS:
            axes.set(**{f"{axis}ticks": values})
        return numbers
    labels = list(dict.fromkeys(cells))
    axes.set(**{f"{axis}ticks": range(len(labels)), f"{axis}ticklabels": labels})
    return np.array([float(labels.index(text)) for text in cells])


def _draw_line(axes: Axes, place: Array, values: Array, name: str) -> None:
    order = np.argsort(place, kind="stable")
    axes.plot(place[order], values[order], "o-", ms=4, rasterized=len(values) > _MAX_VECTORS)
    axes.set_ylabel(name)
    axes.grid(alpha=0.3)


def _draw_map(figure: Figure, axes: Axes, places: Sequence[Array], values: Array, name: str) -> None:
    """Draws coloured cells if the points form a grid, otherwise dots; failed runs are crosses."""
    (x, y), failed = places, ~np.isfinite(values)
    columns, rows = np.unique(x), np.unique(y)
    if len(columns) * len(rows) == len(x) and min(len(columns), len(rows)) > 1:
        grid = np.full((len(rows), len(columns)), np.nan)
        grid[np.searchsorted(rows, y), np.searchsorted(columns, x)] = values
        image: ScalarMappable = axes.pcolormesh(
            columns, rows, grid, shading="nearest", rasterized=len(x) > _MAX_VECTORS
        )
    else:
        image = axes.scatter(x[~failed], y[~failed], c=values[~failed], s=20, rasterized=len(x) > _MAX_VECTORS)
    axes.grid(False)
    axes.plot(x[failed], y[failed], "x", color="#b2182b", rasterized=len(x) > _MAX_VECTORS)
    figure.colorbar(image, ax=axes, label=name)
