"""Claims about the best estimator with sensor errors, wrong nominal models and other plants, and the map of errors.

In: the rows of robustness. Out: claims and a figure. Another claim is a function named in `robustness_claims`.
"""

from collections.abc import Sequence

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import LogNorm
from matplotlib.figure import Figure
from matplotlib.image import AxesImage

from soft_gripper.arrays import Array
from soft_gripper.extras.paper.bars import ARCS, BARS, BEST, Bar
from soft_gripper.extras.paper.claims import Claim
from soft_gripper.pictures.style import STYLE
from studies.estimator_setup import REALISTIC
from studies.robustness.plants import RUBBER
from studies.robustness.rows import PlantRow, RobustnessRow

COLOR_RANGE = 0.03, 10.0  # mm
_WHITE_ABOVE = 0.8  # mm, where the colours are dark


def map_figure(rows: Sequence[RobustnessRow]) -> Figure:
    """Mean pose error in the scenario where it is largest: a panel per nominal model and number of sensors."""
    nominals, counts, estimators, noises = (
        list(dict.fromkeys(getattr(row, name) for row in rows))
        for name in ("nominal", "sections", "estimator", "noise")
    )
    with mpl.rc_context({**STYLE, "axes.grid": False}):
        figure = Figure(figsize=(9.5, 2.15 * len(nominals) + 0.6), layout="constrained")
        panels = figure.subplots(len(nominals), len(counts), sharex=True, sharey=True, squeeze=False)
        for line, nominal in zip(panels, nominals, strict=True):
            for axes, count in zip(line, counts, strict=True):
                panel_rows = [row for row in rows if (row.nominal, row.sections) == (nominal, count)]
                image = _draw(axes, _largest_errors(panel_rows, estimators, noises))
                axes.set_xticks(range(len(noises)), ["0" if n == 0 else f"{n:g}×" for n in noises])
                axes.set_yticks(range(len(estimators)), estimators)
            line[0].set_ylabel(f"nominal model:\n{nominal}")
        for axes, count in zip(panels[0], counts, strict=True):
            axes.set_title(f"{count} sensor{'s' * (count > 1)} per side")
        for axes in panels[-1]:
            axes.set_xlabel("errors of the sensors")
        figure.colorbar(image, ax=panels, label="mean pose error, worst scenario [mm]", format="{x:g}", shrink=0.7)
    return figure


def _largest_errors(rows: Sequence[RobustnessRow], estimators: Sequence[str], noises: Sequence[float]) -> Array:
    """Largest errors of all scenarios, mm, (estimators, noises)."""

    def largest(estimator: str, noise: float) -> float:
        return float(np.max([row.mean_mm for row in rows if (row.estimator, row.noise) == (estimator, noise)]))

    return np.array([[largest(estimator, noise) for noise in noises] for estimator in estimators])


def _draw(axes: Axes, errors: Array) -> AxesImage:
    image = axes.imshow(np.maximum(errors, COLOR_RANGE[0]), norm=LogNorm(*COLOR_RANGE), cmap="YlGnBu", aspect="auto")
    axes.tick_params(length=0)
    for (line, column), error in np.ndenumerate(errors):
        color = "white" if error > _WHITE_ABOVE else "0.15"
        axes.text(column, line, f"{error:.2f}", ha="center", va="center", fontsize=8, color=color)
    for spine in axes.spines.values():
        spine.set_visible(False)
    return image


SENSORS, MORE = 2, 4
MEAN, P95 = 1.0, 2.5  # mm
COVERED = 0.90, 0.99  # fraction of positions in 95 % bands
HIGHER = 1.5  # times the bars of the shipped finger, for others with an exact nominal model


def robustness_claims(rows: Sequence[RobustnessRow], plants: Sequence[PlantRow]) -> list[Claim]:
    """Checks all claims against the rows."""
    other_plants = [name for name in dict.fromkeys(row.plant for row in plants) if name != RUBBER.name]
    return [
        _error_claim(rows),
        _arcs_claim(rows),
        _coverage_claim(rows),
        *(
            _bar_claim([row for row in plants if row.plant == name], bar.times(HIGHER), name)
            for name in other_plants
            for bar in BARS
        ),
    ]


def realistic_rows(rows: Sequence[RobustnessRow], estimator: str, sections: int) -> list[RobustnessRow]:
    """The rows of an estimator with the errors of the preset, of all scenarios and nominal models, in order."""
    return [row for row in rows if (row.estimator, row.sections, row.noise) == (estimator, sections, 1.0)]


def _error_claim(rows: Sequence[RobustnessRow]) -> Claim:
    best_rows = realistic_rows(rows, BEST, SENSORS)
    mean, p95 = (float(np.max([getattr(row, name) for row in best_rows])) for name in ("mean_mm", "p95_mm"))
    text = f"{BEST}, {SENSORS} {REALISTIC} sensors per side: within {MEAN:g} mm (mean) and {P95:g} mm (95th percentile)"
    return Claim("ours", text, mean <= MEAN and p95 <= P95, f"{mean:.2f} and {p95:.2f} mm")


def _arcs_claim(rows: Sequence[RobustnessRow]) -> Claim:
    own_rows, arcs_rows = realistic_rows(rows, BEST, SENSORS), realistic_rows(rows, ARCS, MORE)
    ratios = np.array([own.mean_mm / other.mean_mm for own, other in zip(own_rows, arcs_rows, strict=True)])
    worst = own_rows[int(np.argmax(ratios))]
    text = f"{BEST}, {SENSORS} {REALISTIC} sensors per side: better than {ARCS} with {MORE}"
    number = f"{ratios.min():.2f} to {ratios.max():.2f} times the mean error; worst: {worst.scenario}, {worst.nominal}"
    return Claim("ours", text, bool(ratios.max() < 1), number)


def _coverage_claim(rows: Sequence[RobustnessRow]) -> Claim:
    coverage = np.array([row.coverage for row in realistic_rows(rows, BEST, SENSORS)])
    bounds = " to ".join(f"{100 * bound:.0f}" for bound in COVERED)
    text = f"{BEST}, {SENSORS} {REALISTIC} sensors per side: 95 % bands cover {bounds} %"
    holds = bool(coverage.min() >= COVERED[0] and coverage.max() <= COVERED[1])
    return Claim("ours", text, holds, f"{100 * coverage.min():.1f} to {100 * coverage.max():.1f} %")


def _bar_claim(rows: Sequence[PlantRow], bar: Bar, plant: str) -> Claim:
    best = [row for row in rows if (row.plant, row.estimator) == (plant, BEST) and row.sections in bar.sections]
    bar_rows = [row for row in best if row.scenario in (bar.scenarios or (row.scenario,))]
    columns = ("mean_mm", "worst_mm", "tip_mm")
    mean, largest, tip = (float(np.max([getattr(row, column) for row in bar_rows])) for column in columns)
    holds = mean <= bar.mean and tip <= 2 * bar.mean and (bar.worst is None or largest <= bar.worst)
    return Claim("ours", f"{plant}: {BEST}, {bar.text}", holds, f"{mean:.2f} and {largest:.2f} mm; tip {tip:.2f} mm")
