"""The paper's three behaviours of the grip control: under-damped, tuned, over-damped."""

from collections.abc import Mapping

import matplotlib as mpl
from matplotlib.figure import Figure

from soft_gripper.diagrams.recording.recording import Recording
from soft_gripper.evaluation.figure_style import STYLE


def step_figure(recordings: Mapping[str, Recording]) -> Figure:
    """The opening of the gripper (above) and the pressure (below) against time, a line a recording."""
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(8, 4.8), layout="constrained")
        distance, pressure = figure.subplots(2, sharex=True, height_ratios=[2, 1])
        for (label, recording), color in zip(recordings.items(), ("#b2182b", "#2166ac", "#5aae61"), strict=False):
            time = recording.data["time"]
            distance.plot(time, 1e3 * recording["grip.opening"], color=color, lw=1.3, label=label)
            finger = next(str(name) for name in recording.data if str(name).endswith(".pressure"))
            pressure.plot(time, recording[finger] / 1e3, color=color, lw=1.3)
        distance.step(time, 1e3 * recording["grip.set_point"], color="black", lw=0.9, ls="--", label="set point")
        distance.set_ylabel("opening [mm]")
        distance.legend(frameon=False, ncols=4, columnspacing=1.2, loc="lower center", bbox_to_anchor=(0.5, 1.0))
        pressure.set(ylabel="pressure [kPa]", xlabel="time [s]")
    return figure
