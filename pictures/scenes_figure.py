"""Fig. 8 of the paper: scenarios side by side, as they begin and at their largest pressure."""

from collections.abc import Mapping

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure

from soft_gripper.diagrams.recording.recording import Recording
from soft_gripper.diagrams.schema.scenario import Scenario
from soft_gripper.diagrams.view.torque_colors import add_torque_bar
from soft_gripper.diagrams.wiring.pressure_steps import pressure_steps
from soft_gripper.pictures.rendering import SceneRenderer
from soft_gripper.pictures.torque_bar import recorded_limit

PANEL_HEIGHT = 2.2  # inches, of the pictures at the largest pressure


def scenes_figure(runs: Mapping[str, tuple[Scenario, Recording]], height: int = 700) -> Figure:
    """A column for every scenario of `runs`, by name; each picture is rendered `height` pixels high.

    The fingers have the colours of the true external torque, on one scale for all.
    """
    limit = recorded_limit(*(recording for _, recording in runs.values()))
    renderers = [SceneRenderer(*run, height, torque_limit=limit) for run in runs.values()]
    widths = [renderer.camera.width / height for renderer in renderers]
    with mpl.rc_context({"font.size": 9}):
        figure = Figure(figsize=(PANEL_HEIGHT * sum(widths) + 1.1, 1.75 * PANEL_HEIGHT))
        right = 1 - 1.1 / figure.get_figwidth()
        panels = figure.subplots(
            2,
            len(runs),
            squeeze=False,
            width_ratios=widths,
            height_ratios=[0.5, 1],
            gridspec_kw={"left": 0, "right": right, "bottom": 0, "top": 0.92, "wspace": 0, "hspace": 0.18},
        )
        for (start, end), label, name, renderer in zip(panels.T, "abcdefgh", runs, renderers, strict=False):
            time, pressure = largest_pressure(runs[name][0])
            start.imshow(renderer.render(0.0))
            end.imshow(renderer.render(time))
            start.set_title(f"({label}) {name.replace('_', ' ')}")
            end.set_title(f"{pressure / 1e3:.0f} kPa".replace("-", "−"))
        for axes in panels.flat:
            axes.set_axis_off()
        bar = figure.add_axes((right + 0.01, 0.1, 0.012, 0.75))
        add_torque_bar(figure, limit, cax=bar)
    return figure


def largest_pressure(scenario: Scenario) -> tuple[float, float]:
    """When the step of the largest pressure or vacuum ends, s, and that pressure, Pa."""
    steps = np.array([pressure_steps(scenario.pressure, name) for name in scenario.pressure.steps])
    finger, step = np.unravel_index(np.argmax(np.abs(steps)), steps.shape)
    return float(step + 1) * scenario.step_duration, float(steps[finger, step])
