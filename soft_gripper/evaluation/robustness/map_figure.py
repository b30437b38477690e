"""The map of robustness: errors of every estimator against those of the sensors, by belief and number of sensors."""

from collections.abc import Sequence

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import LogNorm
from matplotlib.figure import Figure
from matplotlib.image import AxesImage

from soft_gripper.arrays import Array
from soft_gripper.evaluation.robustness.table import RobustnessRow
from soft_gripper.pictures.style import STYLE

LEAST, MOST = 0.03, 10.0  # mm, of the colours
_WHITE_ABOVE = 0.8  # mm, where the colours are dark


def map_figure(rows: Sequence[RobustnessRow]) -> Figure:
    """Mean pose error in the scenario where it is largest: a panel a belief and number of sensors."""
    beliefs, counts, estimators, noises = (
        list(dict.fromkeys(getattr(row, name) for row in rows)) for name in ("belief", "sections", "estimator", "noise")
    )
    with mpl.rc_context({**STYLE, "axes.grid": False}):
        figure = Figure(figsize=(9.5, 2.15 * len(beliefs) + 0.6), layout="constrained")
        panels = figure.subplots(len(beliefs), len(counts), sharex=True, sharey=True, squeeze=False)
        for line, belief in zip(panels, beliefs, strict=True):
            for axes, count in zip(line, counts, strict=True):
                of_panel = [row for row in rows if (row.belief, row.sections) == (belief, count)]
                image = _draw(axes, _largest(of_panel, estimators, noises))
                axes.set_xticks(range(len(noises)), ["0" if n == 0 else f"{n:g}×" for n in noises])
                axes.set_yticks(range(len(estimators)), estimators)
            line[0].set_ylabel(f"believed:\n{belief}" if belief != "as simulated" else "believed:\nas it is")
        for axes, count in zip(panels[0], counts, strict=True):
            axes.set_title(f"{count} sensor{'s' * (count > 1)} a side")
        for axes in panels[-1]:
            axes.set_xlabel("errors of the sensors")
        figure.colorbar(image, ax=panels, label="mean pose error, worst scenario [mm]", format="{x:g}", shrink=0.7)
    return figure


def _largest(rows: Sequence[RobustnessRow], estimators: Sequence[str], noises: Sequence[float]) -> Array:
    """Of all scenarios, mm, (estimators, noises)."""

    def largest(estimator: str, noise: float) -> float:
        return float(np.max([row.mean_mm for row in rows if (row.estimator, row.noise) == (estimator, noise)]))

    return np.array([[largest(estimator, noise) for noise in noises] for estimator in estimators])


def _draw(axes: Axes, errors: Array) -> AxesImage:
    image = axes.imshow(np.maximum(errors, LEAST), norm=LogNorm(LEAST, MOST), cmap="YlGnBu", aspect="auto")
    axes.tick_params(length=0)
    for (line, column), error in np.ndenumerate(errors):
        color = "white" if error > _WHITE_ABOVE else "0.15"
        axes.text(column, line, f"{error:.2f}", ha="center", va="center", fontsize=8, color=color)
    for spine in axes.spines.values():
        spine.set_visible(False)
    return image
