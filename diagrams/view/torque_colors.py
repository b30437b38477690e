"""The colours of external torque: one scale for every picture, on screen and on paper."""

from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.cm import ScalarMappable
from matplotlib.colorbar import Colorbar
from matplotlib.colors import Normalize
from matplotlib.figure import Figure

from soft_gripper.arrays import Array

# Diverging from a light grey and distinct to colour-blind eyes: blue holds a finger open, red closes it.
COLORMAP = mpl.colormaps["coolwarm"].with_extremes(bad="0.35")


def color(torque: Array, limit: float) -> Array:
    """Colours of external torques (...) N m, (..., 3) red, green, blue from 0 to 1.

    The scale runs from -`limit` to `limit` N m and holds its end colours beyond; NaN, a torque that is not
    known, is dark grey.
    """
    fraction = np.ma.masked_invalid(0.5 + 0.5 * np.asarray(torque, dtype=float) / limit)
    rgba: Array = np.asarray(COLORMAP(fraction))
    return rgba[..., :3]


def round_limit(torque: float) -> float:
    """A round end for the scale: the least of 1, 2, 3 and 5 times a power of ten that holds `torque`, N m."""
    power = 10.0 ** np.floor(np.log10(torque))
    return float(next(power * step for step in (1, 2, 3, 5, 10) if torque <= power * step * (1 + 1e-9)))


def add_torque_bar(figure: Figure, limit: float, label: str = "external torque", **where: Any) -> Colorbar:
    """Draws the scale from -`limit` to `limit` N m, in mN m; `where` as for `Figure.colorbar`."""
    scale = ScalarMappable(Normalize(-1e3 * limit, 1e3 * limit), COLORMAP)
    bar = figure.colorbar(scale, **where)
    bar.set_label(f"holds open  ←  {label} [mN m]  →  closes")
    bar.outline.set_visible(False)
    return bar
