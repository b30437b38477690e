"""The figure of what separates this project's free bending from the paper's."""

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure

from soft_gripper.diagrams.recording.recording import Recording
from soft_gripper.diagrams.schema.scenario import Scenario
from soft_gripper.evaluation.figure_style import STYLE, section_style
from soft_gripper.evaluation.paper.held_steps import held_samples
from soft_gripper.evaluation.paper.why_the_paper_differs import tip_errors
from soft_gripper.fingers.finger import Finger

TITLES = {
    "middles": "joints in the middles\nof the segments (here)",
    "starts": "joints where\nthe segments begin",
    "noisy": "joints in the middles,\nreadings with 0.1 % noise",
}


def difference_figure(scenario: Scenario, recording: Recording, finger: Finger) -> Figure:
    """Fingertip error in free bending against the bend angle, 1 to 4 sensors, on one scale, for three chains.

    `recording` is of a free bending of `finger`; of steps with equal bend the first is drawn.
    """
    q = held_samples(scenario, recording, f"{finger.name}.sampled_joint_angles").mean(axis=1)
    bend, first = np.unique(np.degrees(q.sum(axis=-1)).round(1), return_index=True)
    errors = tip_errors(finger, q[first])
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(8, 3.2), layout="constrained")
        panels = figure.subplots(1, 3, sharex=True, sharey=True)
        for axes, (name, title) in zip(panels, TITLES.items(), strict=True):
            for sections, error in zip(errors.sections, 1e3 * getattr(errors, name), strict=True):
                axes.plot(bend, error, **section_style(sections))
            axes.set(title=title, xlabel="bend angle [degrees]")
        panels[0].set(ylabel="fingertip error [mm]", ylim=(0, None))
        panels[0].legend(title="sensors a side", frameon=False)
    return figure
