"""What was held, and what was recognized, as a figure."""

from collections.abc import Mapping, Sequence

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from soft_gripper.arrays import Array
from soft_gripper.evaluation.figure_style import STYLE

DARK = 0.55  # share of a shape's grasps, above which its number is white


def confusion_figure(shapes: Sequence[str], matrices: Mapping[int, Array], number: int) -> Figure:
    """A confusion matrix (C, C) of counts for each number of sections, of `number` grasps of each shape."""
    with mpl.rc_context({**STYLE, "axes.grid": False}):
        figure = Figure(figsize=(3.9 * len(matrices), 3.9), layout="constrained")
        panels = figure.subplots(1, len(matrices), squeeze=False)[0]
        for axes, (sections, matrix) in zip(panels, matrices.items(), strict=True):
            _draw(axes, shapes, matrix, number)
            right = np.trace(matrix) / (number * len(shapes))
            axes.set_title(f"{sections} sections: {100 * right:.1f} % right")
        panels[0].set_ylabel("held")
    return figure


def _draw(axes: Axes, shapes: Sequence[str], matrix: Array, number: int) -> None:
    shares = matrix / number
    axes.imshow(shares, cmap="Blues", vmin=0, vmax=1)
    for (row, column), count in np.ndenumerate(matrix):
        color = "white" if shares[row, column] > DARK else "0.2" if count else "0.7"
        axes.text(column, row, str(count), ha="center", va="center", color=color, fontsize=12)
    axes.set_xticks(range(len(shapes)), shapes)
    axes.set_yticks(range(len(shapes)), shapes)
    axes.set_xticks(np.arange(0.5, len(shapes) - 1), minor=True)
    axes.set_yticks(np.arange(0.5, len(shapes) - 1), minor=True)
    axes.grid(which="minor", color="white", lw=2, alpha=1)
    axes.tick_params(which="both", length=0)
    axes.spines[:].set_visible(False)
    axes.set_xlabel("recognized")
