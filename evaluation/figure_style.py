"""How the figures of the evaluations look, and how they are written."""

from pathlib import Path
from typing import Any

import matplotlib as mpl
from matplotlib.figure import Figure

from soft_gripper.files import atomic_file

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


def section_style(sections: int) -> dict[str, Any]:
    """How the line of a number of sections looks, in every figure."""
    return {"marker": MARKERS[sections], "ms": 4, "lw": 1.3, "color": COLORS[sections], "label": str(sections)}


def save_figure(figure: Figure, stem: Path) -> None:
    """Writes a figure as PNG and SVG, the same bytes for the same figure."""
    for suffix, metadata in ((".png", None), (".svg", {"Date": None})):
        with atomic_file(stem.with_suffix(suffix)) as partial, mpl.rc_context(STYLE):
            figure.savefig(partial, dpi=200, metadata=metadata)
