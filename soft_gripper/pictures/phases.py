"""A task at a glance: the path of the object, the gripper at the end of every phase, and the signals that lead it."""

from collections.abc import Sequence
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patheffects import withStroke

from soft_gripper.control.task_phases import Phase
from soft_gripper.diagrams.recording.phase_spans import Span, phase_spans
from soft_gripper.diagrams.recording.recording import Recording
from soft_gripper.diagrams.view.torque_colors import add_torque_bar
from soft_gripper.pictures.close_up import CloseUp
from soft_gripper.pictures.grip_plots import draw_grip_plots, recorded_plots
from soft_gripper.pictures.rendering import SceneRenderer
from soft_gripper.pictures.torque_bar import recorded_limit
from soft_gripper.scenario.scenario import Scenario

STYLE: dict[Any, Any] = {"font.size": 8, "axes.spines.top": False, "axes.spines.right": False}
DPI = 200
# Inches.
WIDTH = 9.0
COLUMNS, PANEL_WIDTH, PANEL_HEIGHT, GAP = 4, 1.33, 2.1, 0.04  # of the strip
TITLE = 0.25  # above a picture
RIGHT = 0.85  # of the pictures: the scale of torques; of the plots: legends
LEFT, PLOT_HEIGHT, PLOT_GAP, NAMES, TIME = 0.74, 0.68, 0.1, 0.32, 0.33  # of the plots; above and below them
_PATH_COLOR, _PATH_POINTS = "#b5462f", 200

Place = tuple[float, float, float, float]  # left, top, width and height, inches from the upper left corner


def phases_figure(scenario: Scenario, recording: Recording, phases: Sequence[Phase]) -> Figure:
    """The scene with the path of what is carried, a close-up of every phase's end, and the signals of the grip below.

    The motions to the arm's home are not in the strip. The fingers have the colours of the true external torque;
    opening and torque in the plots are estimated, and left out where the task does not command the gripper.

    Args:
        scenario: with a task.
        recording: of all that it did.
        phases: of the task, as the TaskMachine numbers them.
    """
    spans = phase_spans(recording, phases)
    numbered = list(enumerate(spans, 1))
    shown = [(i, span) for i, span in numbered if not _goes_home(span.phase, scenario)] or numbered
    strip_height = -(-len(shown) // COLUMNS) * (TITLE + PANEL_HEIGHT)
    plots_top = strip_height + NAMES
    limit, rows = recorded_limit(recording), len(recorded_plots(recording))
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(WIDTH, plots_top + rows * PLOT_HEIGHT + (rows - 1) * PLOT_GAP + TIME), dpi=DPI)
        overview = (0.0, TITLE, _panel_left(0) - GAP, strip_height - TITLE)
        renderer = SceneRenderer(scenario, recording, *_pixels(overview), limit)
        _draw_overview(_axes(figure, overview), scenario, renderer)
        _draw_strip(figure, renderer, shown)
        bar = _axes(figure, (WIDTH - RIGHT + 0.08, TITLE + 0.1, 0.11, strip_height - TITLE - 0.2))
        add_torque_bar(figure, limit, cax=bar)
        tops = plots_top + (PLOT_HEIGHT + PLOT_GAP) * np.arange(rows)
        plots = [_axes(figure, (LEFT, top, WIDTH - LEFT - RIGHT - 0.15, PLOT_HEIGHT)) for top in tops]
        draw_grip_plots(plots, scenario, recording, spans)
        figure.align_ylabels(plots)
    return figure


def _goes_home(phase: Phase, scenario: Scenario) -> bool:
    assert scenario.arm is not None
    return np.allclose(phase.motion.value(phase.duration)[:, 0], scenario.arm.home)


def _panel_left(column: int) -> float:
    """Where the pictures of a column of the strip begin, inches; the strip ends at the right."""
    return WIDTH - RIGHT - (COLUMNS - column) * (PANEL_WIDTH + GAP) + GAP


def _axes(figure: Figure, place: Place) -> Axes:
    (across, down), (left, top, width, height) = figure.get_size_inches(), place
    return figure.add_axes((left / across, 1 - (top + height) / down, width / across, height / down))


def _pixels(place: Place) -> tuple[int, int]:
    """Height and width of the picture that fills a place."""
    _, _, width, height = place
    return round(height * DPI), round(width * DPI)


def _draw_overview(axes: Axes, scenario: Scenario, renderer: SceneRenderer) -> None:
    """The scene when the object, or without one the gripper, is half-way, and its path."""
    assert scenario.task is not None
    scene, name = renderer.scene, scenario.task.object
    times = scene.times[np.linspace(0, len(scene.times) - 1, _PATH_POINTS).astype(int)]
    path = np.array([scene.model_position(name, time) if name else scene.gripper_position(time) for time in times])
    gone = np.cumsum(np.linalg.norm(np.diff(path, axis=0, prepend=path[:1]), axis=1))
    axes.imshow(renderer.render(times[np.searchsorted(gone, gone[-1] / 2)]))
    right, down = renderer.camera.project(path).T
    axes.plot(right, down, color=_PATH_COLOR, lw=1.6, path_effects=[withStroke(linewidth=3.2, foreground="white")])
    axes.plot(right[0], down[0], "o", ms=5, color=_PATH_COLOR, mfc="white", mew=1.6)
    axes.plot(right[-1], down[-1], "o", ms=6, color=_PATH_COLOR)
    axes.set_title(f"path of the {'object' if name else 'gripper'}", fontsize="medium")
    axes.set_axis_off()


def _draw_strip(figure: Figure, renderer: SceneRenderer, shown: Sequence[tuple[int, Span]]) -> None:
    """The gripper at the end of every span, with the span's number."""
    size = _pixels((0.0, 0.0, PANEL_WIDTH, PANEL_HEIGHT))
    close_up = CloseUp(renderer, [span.end for _, span in shown], *size, level=True)
    for i, (number, span) in enumerate(shown):
        row, column = divmod(i, COLUMNS)
        top = row * (TITLE + PANEL_HEIGHT) + TITLE
        axes = _axes(figure, (_panel_left(column), top, PANEL_WIDTH, PANEL_HEIGHT))
        axes.imshow(renderer.render(span.end, close_up.camera(span.end)))
        axes.set_title(f"{number} {span.phase.name}  {span.end:.1f} s", fontsize="medium")
        axes.set_axis_off()
