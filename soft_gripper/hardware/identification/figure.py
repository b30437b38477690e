"""Measured and simulated motion: the middle of the markers of every recording over time."""

from collections.abc import Sequence
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.figure import Figure

from soft_gripper.arrays import Array, Planar
from soft_gripper.hardware.identification.free_parameters import Model
from soft_gripper.hardware.identification.identification import Identified
from soft_gripper.hardware.identification.measured_motion import MeasuredMotion, turned
from soft_gripper.hardware.identification.simulated_motion import simulated_markers
from soft_gripper.pictures.style import STYLE

MEASURED: dict[str, Any] = {"color": "0.6", "lw": 3.0, "label": "measured", "solid_capstyle": "round"}
SIMULATED: dict[str, Any] = {"color": "#b2182b", "lw": 1.1, "label": "simulated"}
_WIDTH, _HEIGHT = 2.6, 2.1  # inches, of a panel


def identify_figure(found: Identified) -> Figure:
    """A column for every recording: how far the tip is displaced, and how far it has turned."""
    roles = [score.role for score in found.scores]
    with plt.rc_context(STYLE):
        figure, axes = plt.subplots(
            2,
            len(roles),
            figsize=(max(_WIDTH * len(roles), 5.0), 2 * _HEIGHT),
            sharex="col",
            squeeze=False,
            constrained_layout=True,
        )
        for column, motion, role in zip(axes.T, found.motions, roles, strict=True):
            draw_motion(column, found.model, motion)
            column[0].set_title(f"{motion.name}\n{'fitted' if role == 'fit' else 'held out'}")
            column[1].set_xlabel("time [s]")
        axes[0, 0].set_ylabel("displacement of the tip [mm]")
        axes[1, 0].set_ylabel("turn of the tip [degrees]")
        axes[0, 0].legend(frameon=False)
    plt.close(figure)
    return figure


def draw_motion(axes: Sequence[Any], model: Model, motion: MeasuredMotion) -> None:
    """One recording: displacement and turn, measured and simulated."""
    simulated = simulated_markers(model.finger, model.setup, motion)
    for markers, style in ((motion.markers, MEASURED), (simulated, SIMULATED)):
        axes[0].plot(motion.time, 1e3 * displacement(markers, motion), **style)
        axes[1].plot(motion.time, np.degrees(turned(markers, motion.reference)), **style)


def displacement(markers: Planar, motion: MeasuredMotion) -> Array:
    """Of the middle of markers from where it was before the event, m, (T,)."""
    distance: Array = np.abs(np.mean(markers - motion.reference, axis=1))
    return distance
