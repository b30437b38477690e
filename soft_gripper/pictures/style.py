"""The style of the figures in evaluations, and how they are written."""

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
# Colours of estimators, in table order: Okabe and Ito's palette, which is safe for colour-blind readers.
ESTIMATOR_COLORS = ("#555555", "#e69f00", "#0072b2", "#009e73", "#cc79a7", "#d55e00", "#56b4e9", "#f0e442")
ESTIMATOR_MARKERS = "osD^vPX*"


def section_style(sections: int) -> dict[str, Any]:
    """Line style for a number of sections, in all figures."""
    return {"marker": MARKERS[sections], "ms": 4, "lw": 1.3, "color": COLORS[sections], "label": str(sections)}


def estimator_style(place: int, name: str) -> dict[str, Any]:
    """Line style for an estimator, in all figures; `place` counts the estimators from 0.

    The colours repeat with dashed lines, then with dotted ones.
    """
    cycle, place = divmod(place, len(ESTIMATOR_COLORS))
    look = {"ls": ("-", "--", ":", "-.")[cycle % 4], "color": ESTIMATOR_COLORS[place], "label": name}
    return {"marker": ESTIMATOR_MARKERS[place], "ms": 4.5, "lw": 1.5, **look}


def save_figure(figure: Figure, stem: Path) -> None:
    """Writes a figure as PNG and SVG; the same figure always gives the same bytes."""
    for suffix, metadata in ((".png", None), (".svg", {"Date": None})):
        with atomic_file(stem.with_suffix(suffix)) as partial, mpl.rc_context(STYLE):
            figure.savefig(partial, dpi=200, metadata=metadata)
