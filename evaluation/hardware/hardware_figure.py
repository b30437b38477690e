"""Hardware beside what is computed of it: a beam let go, a segment under pressure, the tip of an arm."""

from collections.abc import Callable

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from soft_gripper.arrays import Array, Planar
from soft_gripper.evaluation.figure_style import ESTIMATOR_COLORS, STYLE
from soft_gripper.evaluation.hardware.experiments import Arm
from soft_gripper.evaluation.identify.identify import Identified
from soft_gripper.evaluation.identify.identify_figure import MEASURED, displacement
from soft_gripper.evaluation.identify.measured_motion import MeasuredMotion, turned
from soft_gripper.evaluation.identify.simulated_motion import simulated_markers

_COLORS = {"fit": "#2166ac", "test": "#b2182b"}
_LABELS = {"fit": "simulated, fitted to it", "test": "simulated, not given to the fit"}
_TRIAL = "trial_2"  # its sections bend in opposite directions
_DRAWN = {"arcs 2": "arcs, 2 sensors a side", "gaussian 1": "gaussian, 1 sensor a side"}
_TURNS = (1, 2, 5, 10, 20, 50, 100)  # degrees


def hardware_figure(beam: Identified, segment: Identified, arm: Arm) -> Figure:
    """Three panels: displacement of the beam's tip, turn of the segment's, place of the arm's."""
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(12.5, 3.9), layout="constrained")
        panels = figure.subplots(1, 3)
        _draw_beam(panels[0], beam)
        _draw_segment(panels[1], segment)
        _draw_arm(panels[2], arm)
        for axes in panels:
            axes.margins(x=0)
            axes.title.set_fontsize(10)
        panels[0].legend(frameon=False, fontsize=8, loc="upper right")  # of the segment too
        panels[2].legend(frameon=False, fontsize=8, loc="upper right")

    return figure


def _draw_beam(axes: Axes, found: Identified) -> None:
    for motion, row in zip(found.motions, found.scores, strict=True):
        mass = "own weight" if motion.load is None else f"{1e3 * motion.load.mass:.0f} g"
        _draw(axes, found, motion, row.role, lambda markers, m: 1e3 * displacement(markers, m), (1.45, mass))
    axes.set(xlim=(-0.1, 2.0), ylim=(-2, 58), xlabel="time since release [s]")
    axes.set_ylabel("displacement of the tip [mm]")
    axes.set_title("Silicone beam, let go", loc="left")


def _draw_segment(axes: Axes, found: Identified) -> None:
    for motion, row in zip(found.motions, found.scores, strict=True):
        assert motion.pressure is not None
        pressure = f"{1e-3 * motion.pressure:.0f} kPa"
        _draw(
            axes, found, motion, row.role, lambda markers, m: np.degrees(turned(markers, m.reference)), (1.2, pressure)
        )
    axes.set(yscale="log", ylim=(_TURNS[0], _TURNS[-1]), xlim=(-0.1, 5.0), xlabel="time since the valve opened [s]")
    axes.set_yticks(_TURNS, [str(turn) for turn in _TURNS])
    axes.minorticks_off()
    axes.set_ylabel("turn of the tip [degrees]")
    axes.set_title("Pneumatic segment, pressure steps", loc="left")


def _draw(
    axes: Axes,
    found: Identified,
    motion: MeasuredMotion,
    role: str,
    value: Callable[[Planar, MeasuredMotion], Array],
    label: tuple[float, str],
) -> None:
    """A value of one recording since its event, measured and simulated, with a label that stands at a time."""
    time, (at, text) = motion.time - motion.events[0], label
    labelled = axes.get_legend_handles_labels()[1]
    measured, simulated = (
        value(markers, motion)
        for markers in (motion.markers, simulated_markers(found.model.finger, found.model.setup, motion))
    )
    axes.plot(time, measured, **{**MEASURED, "label": "" if labelled else MEASURED["label"]})
    axes.plot(time, simulated, color=_COLORS[role], lw=1.2, label="" if _LABELS[role] in labelled else _LABELS[role])
    place = (at, float(np.interp(at, time, measured)))
    axes.annotate(text, place, (0, 9), textcoords="offset points", color=_COLORS[role], fontsize=8)


def _draw_arm(axes: Axes, arm: Arm) -> None:
    """Where the tip is across the arm."""
    signals = next(one.signals for one in arm.replayed if one.name == _TRIAL)
    tip = 1e3 * signals["measured_bodies"][1:, -1, 0]
    axes.plot(tip["time"], tip, **MEASURED)
    for (row, label), color in zip(_DRAWN.items(), ESTIMATOR_COLORS[1:], strict=False):
        axes.plot(tip["time"], 1e3 * signals[f"{row}.body_positions"][1:, -1, 0], color=color, lw=1.2, label=label)
    axes.set(xlabel="time [s]", ylabel="tip, across the arm [mm]")
    axes.set_title("Arm of two segments, estimated (trial 2)", loc="left")
