"""Designs of sensors in space as rows of tables, as a figure, and as part of a scenario."""

from dataclasses import asdict, dataclass
from typing import Any

import matplotlib as mpl
import numpy as np
import yaml
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import FuncFormatter, LogLocator, MaxNLocator, NullFormatter

from soft_gripper.extras.placement.catalogue import KINDS, Design
from soft_gripper.extras.placement.place_in_space import PlacedInSpace, SpatialAssumptions
from soft_gripper.extras.placement.spatial_scores import Errors
from soft_gripper.pictures.style import STYLE

UNITS = np.array([1e3, 180 / np.pi, 1.0, 1e3])  # of `Errors`: mm, degrees, N, mm


@dataclass(frozen=True)
class DesignRow:
    """One design, and the errors that are predicted."""

    sensors: int
    kind: str
    borders: str  # shares of the length
    paths: str
    tip_mm: float
    twist_deg: float
    force_n: float
    place_mm: float
    score: float  # geometric mean of the errors in SI units


@dataclass(frozen=True)
class VerifiedRow(DesignRow):
    """And those that were made in simulated statics."""

    made_tip_mm: float
    made_twist_deg: float
    made_force_n: float
    made_place_mm: float


def design_rows(placed: PlacedInSpace) -> list[DesignRow]:
    """All designs that were tried, by number of sensors and score."""
    tried = placed.tried
    order = sorted(tried, key=lambda design: (design.sensors, tried[design].score, design))
    return [DesignRow(*_cells(design, tried[design])) for design in order]


def verified_rows(placed: PlacedInSpace) -> list[VerifiedRow]:
    """The best of every number of sensors."""
    return [VerifiedRow(*_cells(one.design, one.predicted), *(UNITS * one.made)) for one in placed.best]


def _cells(design: Design, errors: Errors) -> tuple[Any, ...]:
    borders = " ".join(f"{border:.4g}" for border in design.borders) or "none"
    return design.sensors, design.kind, borders, " ".join(design.paths), *map(float, UNITS * errors), errors.score


def scenario_part(placed: PlacedInSpace, kind: str, assumptions: SpatialAssumptions) -> str:
    """The part of a scenario that has the best design of a kind, and an estimator with these assumptions."""
    best = placed.best_of(kind).design
    config = best.config(placed.finger, assumptions.errors(kind))
    sensor: dict[str, Any] = {"type": config.type, "sections": config.sections}
    if config.borders is not None:
        sensor["borders"] = config.borders
    if config.paths:
        sensor["paths"] = [_given(path, "name", "x", "y", "at") for path in config.paths]
    if config.errors is not None:
        sensor["errors"] = _given(config.errors)
    assumed = _given(assumptions.uncertainty(kind)).items()
    estimator = {"type": "gaussian", "uncertainty": {name: float(f"{value:.3g}") for name, value in assumed}}
    return yaml.safe_dump({"sensor": sensor, "estimator": estimator}, sort_keys=False, default_flow_style=None)


def _given(config: Any, *always: str) -> dict[str, Any]:
    """The fields that differ from their defaults."""
    default = asdict(type(config)())
    return {name: value for name, value in asdict(config).items() if name in always or value != default[name]}


_COLORS = dict(zip(KINDS, ("#0072b2", "#d55e00", "#009e73"), strict=True))
_MARKERS = dict(zip(KINDS, "osD", strict=True))
_LABELS = ("tip [mm]", "twist [degrees]", "force across the finger [N]", "place of the force [mm]")


def pareto_figure(placed: PlacedInSpace) -> Figure:
    """Errors against the number of sensors: of the best designs, as predicted and as made, and the least of each."""
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(7.5, 6.2), layout="constrained")
        for i, (axes, label) in enumerate(zip(figure.subplots(2, 2).ravel(), _LABELS, strict=True)):
            for kind in KINDS:
                _draw_kind(axes, placed, kind, i)
            axes.set_title(label, loc="left", fontsize=9)
            axes.set(yscale="log", xlabel="sensors")
            axes.xaxis.set_major_locator(MaxNLocator(integer=True))
            axes.yaxis.set_major_locator(LogLocator(subs=(1, 2, 5)))
            axes.yaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
            axes.yaxis.set_minor_formatter(NullFormatter())
        figure.legend(handles=_legend(), loc="outside lower center", ncols=3, frameon=False)
    return figure


def _draw_kind(axes: Axes, placed: PlacedInSpace, kind: str, quantity: int) -> None:
    best, color = [one for one in placed.best if one.design.kind == kind], _COLORS[kind]
    sensors = [one.design.sensors for one in best]
    predicted, made = (
        [UNITS[quantity] * errors[quantity] for errors in each]
        for each in ([one.predicted for one in best], [one.made for one in best])
    )
    least = _least(placed, kind, quantity)
    axes.plot(*zip(*least.items(), strict=True), color=color, lw=0.8, ls=":")
    axes.plot(sensors, predicted, color=color, marker=_MARKERS[kind], ms=4.5, lw=1.5)
    axes.plot(sensors, made, color=color, marker=_MARKERS[kind], ms=6, lw=0, mfc="none")


def _least(placed: PlacedInSpace, kind: str, quantity: int) -> dict[int, float]:
    """The least error of any design with so many sensors or fewer."""
    least: dict[int, float] = {}
    for design in sorted(placed.tried, key=lambda design: design.sensors):
        if design.kind == kind:
            error = float(UNITS[quantity] * placed.tried[design][quantity])
            before = least.get(design.sensors, min(least.values(), default=np.inf))
            least[design.sensors] = min(before, error)
    return least


def _legend() -> list[Line2D]:
    kinds = [Line2D([], [], color=_COLORS[kind], marker=_MARKERS[kind], ms=4.5, label=kind) for kind in KINDS]
    lines = [
        Line2D([], [], color="0.3", marker="o", ms=4.5, label="best score, predicted"),
        Line2D([], [], color="0.3", marker="o", ms=6, lw=0, mfc="none", label="the same, made in statics"),
        Line2D([], [], color="0.3", lw=0.8, ls=":", label="least of all, predicted"),
    ]
    return [line for pair in zip(kinds, lines, strict=True) for line in pair]
