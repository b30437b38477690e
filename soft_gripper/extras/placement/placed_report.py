"""Designs of sensors as rows of tables, as a figure, and as part of a scenario."""

from dataclasses import asdict, dataclass
from typing import Annotated, Any

import matplotlib as mpl
import numpy as np
import yaml
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import FuncFormatter, LogLocator, MaxNLocator, NullFormatter

from soft_gripper.extras.placement.catalogue import KINDS, Design
from soft_gripper.extras.placement.errors import RANKING, Assumptions, Errors
from soft_gripper.extras.placement.place_sensors import Placed, Verified
from soft_gripper.pictures.style import STYLE
from soft_gripper.scenario.schema import SensorConfig

UNITS = np.array([1e3, 180 / np.pi, 1.0, 1e3])  # of `Errors`: mm, degrees, N, mm


@dataclass(frozen=True)
class DesignRow:
    """One design, and the errors that are predicted; NaN where nothing is touched, and of a twist in the plane."""

    sensors: int
    kind: str
    borders: str  # shares of the length
    paths: str
    pose_mm: Annotated[float, ".2f"]
    twist_deg: Annotated[float, ".2f"]
    force_n: Annotated[float, ".3f"]
    place_mm: Annotated[float, ".1f"]
    score: float  # geometric mean of the errors in SI units


@dataclass(frozen=True)
class MadeRow:
    """One design in one run, and the errors that an estimator makes."""

    sections: str  # "best" or "equal"
    sensors: int
    kind: str
    borders: str
    paths: str
    run: str  # or the mean over all
    pose_mm: Annotated[float, ".2f"]
    twist_deg: Annotated[float, ".2f"]
    force_n: Annotated[float, ".3f"]
    place_mm: Annotated[float, ".1f"]


MEAN = "mean"


def design_rows(placed: Placed) -> list[DesignRow]:
    """All designs that were tried, by number of sensors and score."""
    tried = placed.tried
    order = sorted(tried, key=lambda design: (design.sensors, tried[design].score, design))
    return [design_row(design, tried[design]) for design in order]


def design_row(design: Design, errors: Errors) -> DesignRow:
    """The row of a design."""
    pose, twist, force, place = _in_units(errors)
    return DesignRow(*_named(design), pose, twist, force, place, errors.score)


def made_rows(placed: Placed) -> list[MadeRow]:
    """The best of every number of sensors, and equal sections, in every run and in the mean."""
    return [
        MadeRow(sections, *_named(one.design), run, *_in_units(errors))
        for sections, verified in (("best", placed.best), ("equal", placed.equal))
        for one in verified
        for run, errors in {**one.made, MEAN: mean_errors(one)}.items()
    ]


def mean_errors(verified: Verified) -> Errors:
    """The errors made, every run counting alike."""
    each = np.array(list(verified.made.values()))
    known = np.isfinite(each).any(axis=0)
    return Errors(*(float(np.nanmean(values)) if some else np.nan for values, some in zip(each.T, known, strict=True)))


def _named(design: Design) -> tuple[int, str, str, str]:
    return design.sensors, design.kind, design.where, " ".join(design.paths)


def _in_units(errors: Errors) -> list[float]:
    return [float(value) for value in UNITS * errors]


def scenario_part(placed: Placed, kind: str, like: SensorConfig, assumptions: Assumptions) -> str:
    """The part of a scenario that has the best design of a kind, and an estimator with these assumptions."""
    config = placed.best_of(kind).config(placed.finger, like, assumptions.errors(kind))
    sensor: dict[str, Any] = {"type": config.type, "sections": config.sections} | _given(config)
    sensor["paths"] = [_given(path, "name", "x", "y", "at") for path in config.paths]
    if config.errors is not None:
        sensor["errors"] = _given(config.errors)
    sensor = {name: value for name, value in sensor.items() if value != []}
    assumed = _given(assumptions.uncertainty(kind)).items()
    estimator = {"type": RANKING, "uncertainty": {name: float(f"{value:.3g}") for name, value in assumed}}
    return yaml.safe_dump({"sensor": sensor, "estimator": estimator}, sort_keys=False, default_flow_style=None)


def _given(config: Any, *always: str) -> dict[str, Any]:
    """The fields that differ from their defaults."""
    default = asdict(type(config)())
    return {name: value for name, value in asdict(config).items() if name in always or value != default[name]}


_COLORS = dict(zip(KINDS, ("#0072b2", "#d55e00", "#009e73"), strict=True))
_MARKERS = dict(zip(KINDS, "osD", strict=True))
_LABELS = ("joints and tip [mm]", "twist [degrees]", "force [N]", "place of the force [mm]")


def placement_figure(placed: Placed) -> Figure:
    """Errors against the number of sensors: of the best designs, as predicted and as made, and of equal sections."""
    shown = [i for i in range(len(_LABELS)) if np.isfinite([errors[i] for errors in placed.tried.values()]).any()]
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(3.5 * len(shown), 3.6), layout="constrained")
        for i, axes in zip(shown, figure.subplots(1, len(shown), squeeze=False)[0], strict=True):
            for kind in placed.kinds:
                _draw_kind(axes, placed, kind, i)
            axes.set_title(_LABELS[i], loc="left", fontsize=9)
            axes.set(yscale="log", xlabel="sensors")
            axes.xaxis.set_major_locator(MaxNLocator(integer=True))
            axes.yaxis.set_major_locator(LogLocator(subs=(1, 2, 5)))
            axes.yaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
            axes.yaxis.set_minor_formatter(NullFormatter())
        figure.legend(handles=_legend(placed.kinds), loc="outside lower center", ncols=6, frameon=False)
    return figure


def _draw_kind(axes: Axes, placed: Placed, kind: str, quantity: int) -> None:
    looks: tuple[dict[str, Any], ...] = {"lw": 1.5, "mfc": "none"}, {"lw": 0, "mfc": "0.8"}
    for verified, look in zip((placed.best, placed.equal), looks, strict=True):
        some = [one for one in verified if one.design.kind == kind]
        sensors = [one.design.sensors for one in some]
        if verified is placed.best:
            predicted = [UNITS[quantity] * one.predicted[quantity] for one in some]
            axes.plot(sensors, predicted, color=_COLORS[kind], lw=0.8, ls=":")
        made = [UNITS[quantity] * mean_errors(one)[quantity] for one in some]
        axes.plot(sensors, made, color=_COLORS[kind], marker=_MARKERS[kind], ms=5, **look)


def _legend(kinds: list[str]) -> list[Line2D]:
    lines = [Line2D([], [], color=_COLORS[kind], marker=_MARKERS[kind], mfc="none", label=kind) for kind in kinds]
    return [
        *lines,
        Line2D([], [], color="0.3", marker="o", mfc="0.8", lw=0, label="equal sections"),
        Line2D([], [], color="0.3", lw=0.8, ls=":", label="predicted"),
    ]
