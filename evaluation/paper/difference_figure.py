"""The figure of what separates this project's free bending from the paper's."""

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure

from soft_gripper.arrays import Array
from soft_gripper.evaluation.figure_style import STYLE, section_style
from soft_gripper.evaluation.paper.why_the_paper_differs import TipErrors

TITLES = {
    "middles": "joints in the middles\nof the segments (here)",
    "starts": "joints where\nthe segments begin",
    "noisy": "joints in the middles,\nreadings with 0.1 % noise",
}


def difference_figure(bend: Array, errors: TipErrors) -> Figure:
    """Fingertip error in free bending against the bend angle, on one scale, for three chains, 1 to 4 sensors.

    `bend` are the bend angles of the steps of `errors`, rad; of steps with equal bend the first is drawn.
    """
    degrees, first = np.unique(np.degrees(bend).round(1), return_index=True)
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(8, 3.2), layout="constrained")
        panels = figure.subplots(1, 3, sharex=True, sharey=True)
        for axes, (name, title) in zip(panels, TITLES.items(), strict=True):
            for sections, error in zip(errors.sections, 1e3 * getattr(errors, name)[:, first], strict=True):
                axes.plot(degrees, error, **section_style(sections))
            axes.set(title=title, xlabel="bend angle [degrees]")
        panels[0].set(ylabel="fingertip error [mm]", ylim=(0, None))
        panels[0].legend(title="sensors a side", frameon=False)
    return figure
