"""The cross-section of a finger to scale, as it is built: walls, chamber, strain-limiting layer, neutral axis."""

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle

from soft_gripper.fingers.cross_section import CrossSection
from soft_gripper.fingers.finger import Finger

_SILICONE, _LAYER, _AXIS, _SENSOR = "#f2b48f", "#33608c", "#a01c2c", "#3d8f5f"
_INCH = 25.4  # mm
_SCALE = 3.0  # times life size


def section_figure(finger: Finger) -> Figure:
    """Base and tip, three times life size; the inner side, which touches, to the right."""
    sections = {"base": finger.base, "tip": finger.tip}
    extent = 1e3 * max(max(section.width, section.thickness) for section in sections.values()) + 9
    side = _SCALE * extent / _INCH
    figure = Figure(figsize=(2 * side, side + 0.55))
    for column, (name, section) in enumerate(sections.items()):
        axes = figure.add_axes((column / 2, 0.55 / (side + 0.55), 0.5, side / (side + 0.55)))
        axes.set(xlim=(-extent / 2, extent / 2), ylim=(-extent / 2, extent / 2), aspect="equal")
        axes.axis("off")
        _draw(axes, section, finger)
        axes.set_title(f"{name} [mm]: EI = {1e3 * float(section.bending_stiffness):.2f} mN m²", fontsize=9, y=0.93)
    handles, _ = figure.axes[0].get_legend_handles_labels()
    figure.legend(handles=handles, loc="lower center", ncols=4, frameon=False, fontsize=8)
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


def _draw_chamber(axes: Axes, section: CrossSection) -> None:
    """The chamber with its size, and the thickness of the walls round it."""
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
