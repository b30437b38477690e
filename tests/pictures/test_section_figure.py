"""The figure of a section: everything to scale and where it is built."""

from dataclasses import replace

import pytest
from matplotlib.patches import Rectangle

from soft_gripper.fingers.urdf import expand_urdf
from soft_gripper.models import DIRECTORY
from soft_gripper.pictures.section_figure import section_figure


def rectangles(axes):
    """Left, bottom, width and height of all rectangles, mm."""
    patches = [patch for patch in axes.patches if isinstance(patch, Rectangle)]
    return [(*patch.get_xy(), patch.get_width(), patch.get_height()) for patch in patches]


def test_both_ends_are_drawn_as_built(shipped_finger):
    figure = section_figure(shipped_finger)
    assert len(figure.axes) == 2
    for axes, section in zip(figure.axes, (shipped_finger.base, shipped_finger.tip), strict=True):
        block, layer, chamber = rectangles(axes)
        walls = {name: 1e3 * float(wall) for name, wall in section.walls.items()}
        assert block[2:] == pytest.approx((1e3 * section.thickness, 1e3 * section.width))
        assert layer[2:] == pytest.approx((0.2, 1e3 * section.width))
        assert layer[0] + layer[2] == pytest.approx(block[0] + block[2])
        assert chamber[0] - block[0] == pytest.approx(walls["outer"])
        assert layer[0] - (chamber[0] + chamber[2]) == pytest.approx(walls["inner"])
        assert chamber[1] - block[1] == pytest.approx(walls["side"])
        written = {text.get_text() for text in axes.texts}
        assert {f"{wall:.3g}" for wall in walls.values()} <= written


def test_all_sections_are_drawn_side_by_side():
    finger = expand_urdf(DIRECTORY / "grippers/conforming.urdf").fingers[0]
    figure = section_figure(finger)
    assert [len(rectangles(axes)) for axes in figure.axes] == [3, 3, 2, 2]
    assert [axes.get_title().partition(" [")[0] for axes in figure.axes] == ["base", "at 0.4", "at 0.4", "tip"]
    places = [axes.get_position().x0 for axes in figure.axes]
    assert places == pytest.approx([0, 0.25, 0.5, 0.75])


def test_a_millimetre_is_three_on_paper(shipped_finger):
    figure = section_figure(shipped_finger)
    axes = figure.axes[0]
    width = axes.get_position().width * figure.get_figwidth() * 25.4
    assert width / (axes.get_xlim()[1] - axes.get_xlim()[0]) == pytest.approx(3.0)


def test_the_neutral_axis_and_the_sensors_are_where_the_finger_has_them(shipped_finger):
    axes = section_figure(shipped_finger).axes[1]
    axis, sensors = (line.get_xdata() for line in axes.lines)
    assert axis == pytest.approx(1e3 * float(shipped_finger.tip.neutral_axis))
    assert sensors - axis == pytest.approx([1e3 * offset for offset in shipped_finger.sensor_offsets])


def test_a_solid_section_has_no_chamber_and_no_layer(shipped_finger):
    solid = {
        "chamber_width": 0.0,
        "chamber_thickness": 0.0,
        "chamber_center": 0.0,
        "layer_thickness": 0.0,
        "layer_modulus": 0.0,
    }
    ends = {end: replace(getattr(shipped_finger, end), **solid) for end in ("base", "tip")}
    assert [len(rectangles(axes)) for axes in section_figure(replace(shipped_finger, **ends)).axes] == [1, 1]
