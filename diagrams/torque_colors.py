"""The colours of external torque: one scale for every picture, on screen and on paper."""

import matplotlib as mpl
import numpy as np

from soft_gripper.arrays import Array

# Diverging from a light grey and told apart by colour-blind eyes: blue holds a finger open, red closes it.
COLORMAP = mpl.colormaps["coolwarm"].copy()
COLORMAP.set_bad("0.35")


def color(torque: Array, limit: float) -> Array:
    """Colours of external torques (...) N m, (..., 3) red, green, blue from 0 to 1.

    The scale runs from -`limit` to `limit` N m and holds its end colours beyond; NaN, a torque that is not
    known, is dark grey.
    """
    fraction = np.ma.masked_invalid(0.5 + 0.5 * np.asarray(torque, dtype=float) / limit)
    rgba: Array = np.asarray(COLORMAP(fraction))
    return rgba[..., :3]
