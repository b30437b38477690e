"""Figure of a task: the path of the object, the gripper at the end of each phase, and the control signals.

Another plot is an entry of `recorded_plots`, drawn in `draw_grip_plots`.
"""

from collections.abc import Iterable, Sequence
from dataclasses import replace
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patheffects import withStroke
from pydrake.math import RigidTransform

from soft_gripper.arrays import Array
from soft_gripper.control.task import Phase
from soft_gripper.diagrams.contact_forces import ContactForces
from soft_gripper.diagrams.recording import Recording, Span, phase_spans
from soft_gripper.diagrams.view.torque_colors import add_torque_bar, recorded_limit
from soft_gripper.pictures.rendering import Camera, SceneRenderer, framing_camera
from soft_gripper.scenario.schema import Scenario

MEASURED: dict[str, Any] = {"color": "#33608c", "lw": 1.4}
WANTED: dict[str, Any] = {"color": "0.35", "lw": 0.9, "ls": (0, (4, 2))}
THRESHOLD: dict[str, Any] = {"color": "0.35", "lw": 0.9, "ls": (0, (1, 1.5))}
BAND: dict[str, Any] = {"color": "#33608c", "alpha": 0.2, "lw": 0}
SHADES = ("0.93", "0.98")
_CHARACTER_WIDTH = 0.053  # inches per character of a phase name
_FORCE_MARGIN = 0.3  # of the range of the forces, on either side of it
_LEAST_SLIP = 1.0  # mm, of the axis: less is creep, not to be magnified
_LEVEL_AXES, _ALL_AXES = np.array([1.0, 1.0, 0.0]), np.ones(3)
STYLE: dict[Any, Any] = {"font.size": 8, "axes.spines.top": False, "axes.spines.right": False}
DPI = 200
# Inches.
WIDTH = 9.0
COLUMNS, STRIP_LEFT, PANEL_HEIGHT, GAP = 4, 2.71, 2.1, 0.04  # of the strip
TITLE = 0.25  # above a picture
RIGHT, LEGENDS = 0.85, 0.4  # right of the pictures: the torque scale; right of the plots: legends, which take more
LEFT, PLOT_HEIGHT, PLOT_GAP, NAMES, TIME = 0.74, 0.68, 0.1, 0.32, 0.33  # of the plots; above and below them
_PATH_COLOR, _PATH_POINTS = "#b5462f", 200
Place = tuple[float, float, float, float]  # left, top, width and height, inches from the upper left corner


def recorded_plots(recording: Recording, slips: Array | None = None, forces: ContactForces | None = None) -> list[str]:
    """The plots with something to show: forces, slip, opening and torque of a commanded gripper, and the drive."""
    force = [] if forces is None else ["force"]
    slip = ["slip"] if slips is not None and np.isfinite(slips).any() else []
    drive = "pressure" if _finger_signals(recording, "pressure") else "tension"
    return [*force, *slip, *(["opening", "torque"] if "grip.opening" in recording.data else []), drive]


def _finger_signals(recording: Recording, kind: str) -> list[str]:
    return [str(name) for name in recording.data if str(name).endswith(f".{kind}")]


def draw_grip_plots(
    plots: Sequence[Axes],
    scenario: Scenario,
    recording: Recording,
    spans: Sequence[Span],
    slips: Array | None = None,
    forces: ContactForces | None = None,
) -> None:
    """The plots of `recorded_plots`, one below the other, with legends on the right and phase names above."""
    for axes, name in zip(plots, recorded_plots(recording, slips, forces), strict=True):
        if name == "force" and forces is not None:
            _draw_force(axes, forces)
        elif name == "slip" and slips is not None:
            axes.plot(recording.data["time"], 1e3 * slips, label="true, in the fingers", **WANTED)
            axes.set_ylim(0, max(_LEAST_SLIP, 1.12 * float(np.nanmax(1e3 * slips))))
            axes.set_ylabel("slip\n[mm]")
        else:
            _draw_signals(axes, name, scenario, recording)
    plots[-1].set_xlabel("time [s]", labelpad=1)
    for axes in plots:
        axes.set_xlim(0, float(recording.data["time"][-1]))
        axes.margins(y=0.12)
        axes.tick_params(labelbottom=axes is plots[-1])
        axes.legend(loc="center left", bbox_to_anchor=(1.0, 0.5), frameon=False, handlelength=1.4, fontsize="small")
        for i, span in enumerate(spans):
            axes.axvspan(span.begin, span.end, color=SHADES[i % 2], lw=0, zorder=0)
    _name_spans(plots[0], spans)


def _draw_force(axes: Axes, forces: ContactForces) -> None:
    """The transverse force on each finger, true and estimated with its band, which may end beyond the plot.

    Where no contact is detected, the band is that of a force too small to be detected, and would look like one.
    """
    data = forces.data
    for i, finger in enumerate(data["finger"].values):
        force, time = data.sel(finger=finger), data["time"]
        touches, label = force["transverse"] != 0, "" if i else "95 % band"
        axes.fill_between(time, force["least"], force["most"], where=touches, label=label, **BAND)
        axes.plot(time, force["true_transverse"], label="" if i else "true, of a finger", **WANTED)
        axes.plot(time, force["transverse"], label="" if i else "estimated", **MEASURED)
    drawn_forces = np.concatenate([data[name].values.ravel() for name in ("true_transverse", "transverse")])
    low, high = np.nanmin(drawn_forces), np.nanmax(drawn_forces)
    axes.set_ylim(low - _FORCE_MARGIN * (high - low), high + _FORCE_MARGIN * (high - low))
    axes.set_ylabel("transverse\nforce [N]")


def _draw_signals(axes: Axes, name: str, scenario: Scenario, recording: Recording) -> None:
    """Opening or torque of the gripper, or what drives the fingers."""

    def plot(unit: float, signal: str, label: str, look: dict[str, Any]) -> None:
        axes.plot(recording.data["time"], unit * recording[signal], label=label, **look)

    fingers = _finger_signals(recording, name)
    if name == "opening":
        plot(1e3, "grip.set_point", "set point", WANTED)
        plot(1e3, "grip.opening", "estimated", MEASURED)
        axes.set_ylabel("opening\n[mm]")
    elif name == "torque":
        if scenario.control.torque_limit is not None:
            axes.axhline(1e3 * scenario.control.torque_limit, label="limit", **WANTED)
        plot(1e3, "grip.torque", "estimated", MEASURED)
        assert scenario.task is not None
        axes.axhline(1e3 * scenario.task.grip_threshold, label="grip threshold", **THRESHOLD)
        axes.set_ylabel("grip torque\n[mN m]")
    elif name == "pressure":
        plot(1e-3, f"{fingers[0]}_command", "command", WANTED)
        for i, signal in enumerate(fingers):
            plot(1e-3, signal, "" if i else "in the fingers", MEASURED)
        axes.set_ylabel("pressure\n[kPa]")
    else:
        for i, signal in enumerate(fingers):
            plot(1.0, signal, "" if i else "of the tendons", MEASURED)
        axes.set_ylabel("tension\n[N]")


def _name_spans(axes: Axes, spans: Sequence[Span]) -> None:
    """Number and name above each phase; only the number if there is no room for the name."""
    (begin, end), width = axes.get_xlim(), axes.get_window_extent().width / axes.figure.dpi
    for i, span in enumerate(spans, 1):
        text = f"{i} {span.phase.name}"
        fits = _CHARACTER_WIDTH * len(text) < width * (span.end - span.begin) / (end - begin)
        middle, transform = ((span.begin + span.end) / 2, 1.04), axes.get_xaxis_transform()
        axes.annotate(text if fits else str(i), middle, xycoords=transform, ha="center", fontsize="small")


class CloseUp:
    """A camera on the gripper of a scene that shows it as large as possible at all given times, s.

    A `level` camera stays at one height, so that the gripper visibly descends and rises.
    """

    def __init__(self, renderer: SceneRenderer, times: Iterable[float], height: int, width: int, level: bool = False):
        self._scene, self._follows = renderer.scene, _LEVEL_AXES if level else _ALL_AXES
        corners = [self._scene.gripper_corners(time) - self._shift(time) for time in times]
        self._camera = framing_camera(np.concatenate(corners), height, width, renderer.direction)

    def camera(self, time: float) -> Camera:
        X_WC = RigidTransform(self._shift(time)) @ self._camera.X_WC
        return replace(self._camera, X_WC=X_WC)

    def _shift(self, time: float) -> Array:
        return self._follows * self._scene.gripper_position(time)


def phases_figure(
    scenario: Scenario,
    recording: Recording,
    phases: Sequence[Phase],
    slips: Array | None = None,
    forces: ContactForces | None = None,
) -> Figure:
    """The scene with the path of the object, a close-up at the end of each phase, and the grip signals below.

    The strip omits the motions to the arm's home posture. The fingers are coloured by the true external torque; opening
    and torque in the plots are estimates, and are omitted if the task does not command the gripper.

    Args:
        scenario: a scenario with a task.
        recording: the recording of its run.
        phases: the phases of the task, as numbered by the TaskMachine.
        slips: how far the object has slid in the fingers at every sample, m, NaN where they do not hold it; None: it is
            not shown.
        forces: of the fingers at every sample; None: they are not shown.
    """
    spans = phase_spans(recording, phases)
    numbered = list(enumerate(spans, 1))
    assert scenario.arm is not None
    home, ends = scenario.arm.home, [span.phase.motion.value(span.phase.duration)[:, 0] for span in spans]
    panels = [place for place, end in zip(numbered, ends, strict=True) if not np.allclose(end, home)] or numbered
    count = -(-len(panels) // COLUMNS)
    strip = [panels[len(panels) * row // count : len(panels) * (row + 1) // count] for row in range(count)]
    strip_height = len(strip) * (TITLE + PANEL_HEIGHT)
    plots_top = strip_height + NAMES
    limit, rows = recorded_limit(recording), len(recorded_plots(recording, slips, forces))
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(WIDTH, plots_top + rows * PLOT_HEIGHT + (rows - 1) * PLOT_GAP + TIME), dpi=DPI)
        overview = (0.0, TITLE, STRIP_LEFT - GAP, strip_height - TITLE)
        renderer = SceneRenderer(scenario, recording, *_pixels(overview), limit)
        _draw_overview(_axes(figure, overview), scenario, renderer)
        _draw_strip(figure, renderer, strip)
        bar = _axes(figure, (WIDTH - RIGHT + 0.08, TITLE + 0.1, 0.11, strip_height - TITLE - 0.2))
        add_torque_bar(figure, limit, cax=bar)
        tops = plots_top + (PLOT_HEIGHT + PLOT_GAP) * np.arange(rows)
        plots = [_axes(figure, (LEFT, top, WIDTH - LEFT - RIGHT - LEGENDS, PLOT_HEIGHT)) for top in tops]
        draw_grip_plots(plots, scenario, recording, spans, slips, forces)
        figure.align_ylabels(plots)
    return figure


def _axes(figure: Figure, place: Place) -> Axes:
    (across, down), (left, top, width, height) = figure.get_size_inches(), place
    return figure.add_axes((left / across, 1 - (top + height) / down, width / across, height / down))


def _pixels(place: Place) -> tuple[int, int]:
    """Height and width of the picture that fills a place."""
    _, _, width, height = place
    return round(height * DPI), round(width * DPI)


def _draw_overview(axes: Axes, scenario: Scenario, renderer: SceneRenderer) -> None:
    """The scene with the path of the object (or else of the gripper), at the middle of the path."""
    assert scenario.task is not None
    scene, name = renderer.scene, scenario.task.object
    times = scene.times[np.linspace(0, len(scene.times) - 1, _PATH_POINTS).astype(int)]
    path = np.array([scene.object_position(name, time) if name else scene.gripper_position(time) for time in times])
    travel = np.cumsum(np.linalg.norm(np.diff(path, axis=0, prepend=path[:1]), axis=1))
    axes.imshow(renderer.render(times[np.searchsorted(travel, travel[-1] / 2)]))
    x, y = renderer.camera.project(path).T
    axes.plot(x, y, color=_PATH_COLOR, lw=1.6, path_effects=[withStroke(linewidth=3.2, foreground="white")])
    axes.plot(x[0], y[0], "o", ms=5, color=_PATH_COLOR, mfc="white", mew=1.6)
    axes.plot(x[-1], y[-1], "o", ms=6, color=_PATH_COLOR)
    axes.set_title(f"path of the {'object' if name else 'gripper'}", fontsize="medium")
    axes.set_axis_off()


def _draw_strip(figure: Figure, renderer: SceneRenderer, rows: Sequence[Sequence[tuple[int, Span]]]) -> None:
    """The gripper at the end of each span, with the number of the span; every row fills the width of the strip."""
    times = [span.end for spans in rows for _, span in spans]
    for row, spans in enumerate(rows):
        width = (WIDTH - RIGHT - STRIP_LEFT + GAP) / len(spans) - GAP
        size = _pixels((0.0, 0.0, width, PANEL_HEIGHT))
        close_up = CloseUp(renderer, times, *size, level=True)
        for column, (number, span) in enumerate(spans):
            left, top = STRIP_LEFT + column * (width + GAP), row * (TITLE + PANEL_HEIGHT) + TITLE
            axes = _axes(figure, (left, top, width, PANEL_HEIGHT))
            axes.imshow(renderer.render(span.end, close_up.camera(span.end)))
            axes.set_title(f"{number} {span.phase.name}  {span.end:.1f} s", fontsize="small")
            axes.set_axis_off()
