"""The cross-sections of a finger, drawn to scale."""

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle

from soft_gripper.fingers.cross_section import CrossSection
from soft_gripper.fingers.finger import Finger

_SILICONE_COLOR, _LAYER_COLOR, _AXIS_COLOR, _SENSOR_COLOR = "#f2b48f", "#33608c", "#a01c2c", "#3d8f5f"
_MM_PER_INCH = 25.4  # mm
_LIFE_SIZE_SCALE = 3.0  # times life size


def section_figure(finger: Finger) -> Figure:
    """Figure of all sections from base to tip, three times life size; the inner (contact) side on the right."""
    names = ["base", *(f"at {section.at:g}" for section in finger.sections), "tip"]
    extent = 1e3 * max(max(section.width, section.thickness) for section in finger.cross_sections) + 9
    side, count = _LIFE_SIZE_SCALE * extent / _MM_PER_INCH, len(names)
    figure = Figure(figsize=(count * side, side + 0.55))
    for column, (name, place, section) in enumerate(zip(names, finger.places, finger.cross_sections, strict=True)):
        axes = figure.add_axes((column / count, 0.55 / (side + 0.55), 1 / count, side / (side + 0.55)))
        axes.set(xlim=(-extent / 2, extent / 2), ylim=(-extent / 2, extent / 2), aspect="equal")
        axes.axis("off")
        section = finger.section(place * finger.length) if finger.chambers else section
        _draw(axes, section, finger)
        _draw_paths(axes, section, finger, place)
        axes.set_title(f"{name} [mm]: EI = {1e3 * float(section.bending_stiffness):.2f} mN m²", fontsize=9, y=0.93)
    entries = [axes.get_legend_handles_labels() for axes in figure.axes]
    handles = {label: handle for legend_entries in entries for handle, label in zip(*legend_entries, strict=True)}
    figure.legend(handles=list(handles.values()), loc="lower center", ncols=4, frameon=False, fontsize=8)
    return figure


def _draw(axes: Axes, section: CrossSection, finger: Finger) -> None:
    t, w = 1e3 * section.thickness, 1e3 * section.width
    axes.add_patch(Rectangle((-t / 2, -w / 2), t, w, fc=_SILICONE_COLOR, ec="0.3", lw=0.8, label="silicone"))
    layer = 1e3 * section.layer_thickness
    if layer:
        place = (t / 2 - layer, -w / 2)
        axes.add_patch(Rectangle(place, layer, w, color=_LAYER_COLOR, lw=0.8, label="strain-limiting layer"))
    if section.chamber_area:
        _draw_chamber(axes, section)
    axis = 1e3 * float(section.neutral_axis)
    axes.plot([axis, axis], [-w / 2 - 2, w / 2 + 2], "-.", color=_AXIS_COLOR, lw=1.1, label="neutral axis")
    sensors = [axis + 1e3 * offset for offset in finger.sensor_offsets]
    axes.plot(sensors, [0, 0], "o", color=_SENSOR_COLOR, ms=4.5, ls="none", label="sensor paths")
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
        x, y = (1e3 * float(tendon.value_at(name, place * finger.length, finger.length)) for name in "xy")
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
