"""Fig. 8 of the paper: scenarios side by side, at the start and at their largest pressure."""

from collections.abc import Mapping, Sequence
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle

from soft_gripper.diagrams.recording import Recording
from soft_gripper.diagrams.view.torque_colors import add_torque_bar, recorded_limit
from soft_gripper.diagrams.wiring.drive import pressure_steps
from soft_gripper.fingers.cross_section import CrossSection
from soft_gripper.fingers.finger import Finger
from soft_gripper.pictures.rendering import SceneRenderer
from soft_gripper.scenario.schema import Scenario

# Inches.
HEIGHT, TITLE = 2.3, 0.3  # of a picture; of the title above it
GAP, INNER = 0.15, 0.06  # between pairs of pictures, across and down; between the two of a pair
ROW = 9.6  # maximum width of a row with several pairs
BAR = 1.1  # space to the right of the pictures
STYLE: dict[Any, Any] = {"font.size": 11}


def scenes_figure(runs: Mapping[str, tuple[Scenario, Recording]], height: int = 700) -> Figure:
    """Two pictures of each scenario in `runs`, by name, side by side; each is rendered `height` pixels high.

    The fingers are coloured by the true external torque, on one scale for all.
    """
    limit = recorded_limit(*(recording for _, recording in runs.values()))
    renderers = [SceneRenderer(*run, height, torque_limit=limit) for run in runs.values()]
    places = pair_places([2 * HEIGHT * renderer.camera.width / height + INNER for renderer in renderers])
    across = max(left + width for left, _, width in places)
    down = max(top for _, top, _ in places) + TITLE + HEIGHT
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(across + BAR, down))
        for place, label, name, renderer in zip(places, "abcdefgh", runs, renderers, strict=False):
            time, pressure = largest_pressure(runs[name][0])
            titles = (f"({label}) {name.replace('_', ' ')}", f"{pressure / 1e3:.0f} kPa".replace("-", "−"))
            left, top, pair = place
            width = (pair - INNER) / 2
            for i, (moment, title) in enumerate(zip((0.0, time), titles, strict=True)):
                begin, bottom = left + i * (width + INNER), down - top - TITLE - HEIGHT
                corner = (begin / (across + BAR), bottom / down, width / (across + BAR), HEIGHT / down)
                axes = figure.add_axes(corner)
                axes.imshow(renderer.render(moment))
                axes.set_title(title, pad=4)
                axes.set_axis_off()
        bar = figure.add_axes(((across + 0.12) / (across + BAR), 0.15, 0.15 / (across + BAR), 0.7))
        add_torque_bar(figure, limit, cax=bar)
    return figure


def pair_places(widths: Sequence[float]) -> list[tuple[float, float, float]]:
    """Left, top and width, inches, of pairs of pictures that fill one row after another, each row centred."""
    rows: list[list[float]] = []
    for width in widths:
        if rows and sum(rows[-1]) + len(rows[-1]) * GAP + width <= ROW:
            rows[-1].append(width)
        else:
            rows.append([width])
    spans = [sum(row) + (len(row) - 1) * GAP for row in rows]
    places = []
    for number, (row, span) in enumerate(zip(rows, spans, strict=True)):
        left = (max(spans) - span) / 2
        for width in row:
            places.append((left, number * (TITLE + HEIGHT + GAP), width))
            left += width + GAP
    return places


def largest_pressure(scenario: Scenario) -> tuple[float, float]:
    """The end of the step with the largest pressure or vacuum, s, and that pressure, Pa."""
    steps = np.array([pressure_steps(scenario.pressure, name) for name in scenario.pressure.steps])
    finger, step = np.unravel_index(np.argmax(np.abs(steps)), steps.shape)
    return float(step + 1) * scenario.step_duration, float(steps[finger, step])


_SILICONE, _LAYER, _AXIS, _SENSOR = "#f2b48f", "#33608c", "#a01c2c", "#3d8f5f"
_INCH = 25.4  # mm
_SCALE = 3.0  # times life size


def section_figure(finger: Finger) -> Figure:
    """All sections from base to tip, three times life size; the inner (contact) side on the right."""
    names = ["base", *(f"at {section.at:g}" for section in finger.sections), "tip"]
    extent = 1e3 * max(max(section.width, section.thickness) for section in finger.cross_sections) + 9
    side, count = _SCALE * extent / _INCH, len(names)
    figure = Figure(figsize=(count * side, side + 0.55))
    for column, (name, place, section) in enumerate(zip(names, finger.places, finger.cross_sections, strict=True)):
        axes = figure.add_axes((column / count, 0.55 / (side + 0.55), 1 / count, side / (side + 0.55)))
        axes.set(xlim=(-extent / 2, extent / 2), ylim=(-extent / 2, extent / 2), aspect="equal")
        axes.axis("off")
        section = finger.section(place * finger.length) if finger.chambers else section
        _draw(axes, section, finger)
        _draw_paths(axes, section, finger, place)
        axes.set_title(f"{name} [mm]: EI = {1e3 * float(section.bending_stiffness):.2f} mN m²", fontsize=9, y=0.93)
    named = [axes.get_legend_handles_labels() for axes in figure.axes]
    handles = {label: handle for each in named for handle, label in zip(*each, strict=True)}
    figure.legend(handles=list(handles.values()), loc="lower center", ncols=4, frameon=False, fontsize=8)
    return figure


def _draw(axes: Axes, section: CrossSection, finger: Finger) -> None:
    t, w = 1e3 * section.thickness, 1e3 * section.width
    axes.add_patch(Rectangle((-t / 2, -w / 2), t, w, fc=_SILICONE, ec="0.3", lw=0.8, label="silicone"))
    layer = 1e3 * section.layer_thickness
    if layer:
        place = (t / 2 - layer, -w / 2)
        axes.add_patch(Rectangle(place, layer, w, color=_LAYER, lw=0.8, label="strain-limiting layer"))
    if section.chamber_area:
        _draw_chamber(axes, section)
    axis = 1e3 * float(section.neutral_axis)
    axes.plot([axis, axis], [-w / 2 - 2, w / 2 + 2], "-.", color=_AXIS, lw=1.1, label="neutral axis")
    sensors = [axis + 1e3 * offset for offset in finger.sensor_offsets]
    axes.plot(sensors, [0, 0], "o", color=_SENSOR, ms=4.5, ls="none", label="sensor paths")
    _dimension(axes, (-t / 2, -w / 2 - 3), (t / 2, -w / 2 - 3), t)
    _dimension(axes, (-t / 2 - 3, -w / 2), (-t / 2 - 3, w / 2), w)


def _draw_paths(axes: Axes, section: CrossSection, finger: Finger, place: float) -> None:
    """The chambers and tendons that are listed, at a share of the length, with their names."""
    for chamber, hole in zip(finger.chambers, section.holes, strict=False):
        h, b, x, y = (1e3 * float(v) for v in (hole.thickness, hole.width, hole.x, hole.y))
        if h > 0:
            axes.add_patch(Rectangle((x - h / 2, y - b / 2), h, b, fc="white", ec="0.3", lw=0.8))
            axes.text(x, y, chamber.name, ha="center", va="center", fontsize=8)
    for tendon in (tendon for tendon in finger.tendons if tendon.at[0] <= place <= tendon.at[-1]):
        x, y = (1e3 * float(tendon.along(name, place * finger.length, finger.length)) for name in "xy")
        axes.plot(x, y, "x", color="0.2", ms=5, ls="none", label="tendons")
        axes.annotate(tendon.name, (x, y), (0, 4), textcoords="offset points", ha="center", fontsize=8)


def _draw_chamber(axes: Axes, section: CrossSection) -> None:
    """The chamber with its size, and the thickness of the walls around it."""
    h, b, x = (1e3 * v for v in (section.chamber_thickness, section.chamber_width, section.chamber_center))
    t, w = 1e3 * section.thickness, 1e3 * section.width
    walls = {name: 1e3 * float(wall) for name, wall in section.walls.items()}
    axes.add_patch(Rectangle((x - h / 2, -b / 2), h, b, fc="white", ec="0.3", lw=0.8))
    axes.text(x, -0.2 * b, f"chamber\n{h:.3g} x {b:.3g} mm", ha="center", va="center", fontsize=8)
    _dimension(axes, (-t / 2, 0.25 * b), (x - h / 2, 0.25 * b), walls["outer"])
    _dimension(axes, (x + h / 2, 0.25 * b), (x + h / 2 + walls["inner"], 0.25 * b), walls["inner"])
    _dimension(axes, (x, b / 2), (x, w / 2), walls["side"])


def _dimension(axes: Axes, begin: tuple[float, float], end: tuple[float, float], value: float) -> None:
    """An arrow from end to end, with its length in mm."""
    axes.annotate("", begin, end, arrowprops={"arrowstyle": "<->", "lw": 0.8, "shrinkA": 0, "shrinkB": 0})
    upright = begin[0] == end[0]
    x, y = (begin[0] + end[0]) / 2, (begin[1] + end[1]) / 2
    axes.text(x - 0.4 * upright, y + 0.3 * (not upright), f"{value:.3g}", fontsize=8, rotation=90 * upright,
              ha="right" if upright else "center", va="center" if upright else "bottom")  # fmt: skip
