"""The figure of a section: everything to scale and where it is built."""

import pytest
from matplotlib.patches import Rectangle

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


def test_the_neutral_axis_and_the_sensors_are_where_the_finger_has_them(shipped_finger):
    axes = section_figure(shipped_finger).axes[1]
    axis, sensors = (line.get_xdata() for line in axes.lines)
    assert axis == pytest.approx(1e3 * float(shipped_finger.tip.neutral_axis))
    assert sensors - axis == pytest.approx([1e3 * offset for offset in shipped_finger.sensor_offsets])
