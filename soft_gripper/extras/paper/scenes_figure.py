"""Fig. 8 of the paper: scenarios side by side, at the start and at their largest pressure."""

from collections.abc import Mapping, Sequence
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure

from soft_gripper.diagrams.recording import Recording
from soft_gripper.diagrams.view.torque_colors import add_torque_bar, recorded_limit
from soft_gripper.diagrams.wiring.drive import pressure_steps
from soft_gripper.pictures.rendering import SceneRenderer
from soft_gripper.scenario.schema import Scenario

# Inches.
HEIGHT, TITLE = 2.3, 0.3  # of a picture; of the title above it
GAP, INNER = 0.15, 0.06  # between pairs of pictures, across and down; between the two of a pair
MAX_ROW_WIDTH = 9.6  # maximum width of a row with several pairs
BAR = 1.1  # space to the right of the pictures
STYLE: dict[Any, Any] = {"font.size": 11}


def scenes_figure(runs: Mapping[str, tuple[Scenario, Recording]], height: int = 700) -> Figure:
    """Two pictures of each scenario in `runs`, by name, side by side; each is rendered `height` pixels high.

    The fingers are coloured by the true external torque, on one scale for all.
    """
    limit = recorded_limit(*(recording for _, recording in runs.values()))
    renderers = [SceneRenderer(*run, height, torque_limit=limit) for run in runs.values()]
    places = pair_places([2 * HEIGHT * renderer.camera.width / height + INNER for renderer in renderers])
    total_width = max(x + width for x, _, width in places)
    down = max(top for _, top, _ in places) + TITLE + HEIGHT
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(total_width + BAR, down))
        for place, label, name, renderer in zip(places, "abcdefgh", runs, renderers, strict=False):
            time, pressure = largest_pressure(runs[name][0])
            titles = (f"({label}) {name.replace('_', ' ')}", f"{pressure / 1e3:.0f} kPa".replace("-", "−"))
            x, top, pair = place
            width = (pair - INNER) / 2
            for i, (moment, title) in enumerate(zip((0.0, time), titles, strict=True)):
                begin, bottom = x + i * (width + INNER), down - top - TITLE - HEIGHT
                corner = (begin / (total_width + BAR), bottom / down, width / (total_width + BAR), HEIGHT / down)
                axes = figure.add_axes(corner)
                axes.imshow(renderer.render(moment))
                axes.set_title(title, pad=4)
                axes.set_axis_off()
        bar = figure.add_axes(((total_width + 0.12) / (total_width + BAR), 0.15, 0.15 / (total_width + BAR), 0.7))
        add_torque_bar(figure, limit, cax=bar)
    return figure


def pair_places(widths: Sequence[float]) -> list[tuple[float, float, float]]:
    """Left, top and width, inches, of pairs of pictures that fill one row after another, each row centred."""
    rows: list[list[float]] = []
    for width in widths:
        if rows and sum(rows[-1]) + len(rows[-1]) * GAP + width <= MAX_ROW_WIDTH:
            rows[-1].append(width)
        else:
            rows.append([width])
    spans = [sum(row) + (len(row) - 1) * GAP for row in rows]
    places = []
    for number, (row, span) in enumerate(zip(rows, spans, strict=True)):
        x = (max(spans) - span) / 2
        for width in row:
            places.append((x, number * (TITLE + HEIGHT + GAP), width))
            x += width + GAP
    return places


def largest_pressure(scenario: Scenario) -> tuple[float, float]:
    """The end of the step with the largest pressure or vacuum, s, and that pressure, Pa."""
    steps = np.array([pressure_steps(scenario.pressure, name) for name in scenario.pressure.steps])
    finger, step = np.unravel_index(np.argmax(np.abs(steps)), steps.shape)
    return float(step + 1) * scenario.step_duration, float(steps[finger, step])
