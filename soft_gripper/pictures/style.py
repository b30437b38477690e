"""How the figures of the evaluations look, and how they are written."""

from pathlib import Path
from typing import Any

import matplotlib as mpl
from matplotlib.figure import Figure

from soft_gripper.files.output import atomic_file

STYLE: dict[Any, Any] = {
    "font.size": 9,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "grid.alpha": 0.25,
    "svg.hashsalt": "soft-gripper",
}
COLORS = {1: "#b2182b", 2: "#ef8a62", 3: "#67a9cf", 4: "#2166ac"}
MARKERS = {1: "o", 2: "s", 3: "^", 4: "D"}
# Of estimators, in the order in which they are tabulated: Okabe and Ito's colours, which the colour-blind tell apart.
ESTIMATOR_COLORS = ("#555555", "#e69f00", "#0072b2", "#009e73", "#cc79a7", "#d55e00", "#56b4e9", "#f0e442")
ESTIMATOR_MARKERS = "osD^vPX*"


def section_style(sections: int) -> dict[str, Any]:
    """How the line of a number of sections looks, in every figure."""
    return {"marker": MARKERS[sections], "ms": 4, "lw": 1.3, "color": COLORS[sections], "label": str(sections)}


def estimator_style(place: int, name: str) -> dict[str, Any]:
    """How the line of an estimator looks, in every figure; `place` counts the estimators from 0.

    Colours begin anew after the last, with dashed lines, then dotted ones.
    """
    again, place = divmod(place, len(ESTIMATOR_COLORS))
    look = {"ls": ("-", "--", ":", "-.")[again % 4], "color": ESTIMATOR_COLORS[place], "label": name}
    return {"marker": ESTIMATOR_MARKERS[place], "ms": 4.5, "lw": 1.5, **look}


def save_figure(figure: Figure, stem: Path) -> None:
    """Writes a figure as PNG and SVG, the same bytes for the same figure."""
    for suffix, metadata in ((".png", None), (".svg", {"Date": None})):
        with atomic_file(stem.with_suffix(suffix)) as partial, mpl.rc_context(STYLE):
            figure.savefig(partial, dpi=200, metadata=metadata)
