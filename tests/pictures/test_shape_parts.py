"""Arrows and bands of a drawn finger: where they lie."""

import numpy as np
import pytest
from matplotlib.figure import Figure
from matplotlib.patches import Polygon

from soft_gripper.arrays import Array
from soft_gripper.diagrams.view.finger_drawing import contact_arrow, estimated_contact
from soft_gripper.fingers.finger import Finger
from soft_gripper.pictures.shape_figure import draw_band


def arrow_of(finger: Finger, force: float, s: float) -> Array | None:
    """Of a straight finger: across it is x."""
    ends = np.outer(finger.link_ends, [0.0, 0.0, 1.0])
    signals = {"contact_force": np.array([force]), "contact_arc_length": np.array([s])}
    return contact_arrow(finger, ends, estimated_contact(signals, ends))


@pytest.mark.parametrize(("force", "face"), [(0.5, "inner_face"), (-0.5, "outer_face")])
def test_an_arrow_begins_at_the_face_and_is_25_mm_a_newton(shipped_finger: Finger, force: float, face: str) -> None:
    arrow = arrow_of(shipped_finger, force, 0.08)
    assert arrow is not None
    np.testing.assert_allclose(arrow[0], [float(getattr(shipped_finger.section(0.08), face)), 0.0, 0.08], atol=1e-16)
    np.testing.assert_allclose(arrow[1] - arrow[0], [-0.025 * force, 0.0, 0.0], atol=1e-16)


def test_a_band_is_two_standard_deviations_wide_on_either_side(shipped_finger: Finger) -> None:
    axes, std = Figure().subplots(), np.linspace(0.1e-3, 1e-3, 13)
    draw_band(axes, np.stack([np.zeros(14), shipped_finger.link_ends], axis=-1), std)
    (band,) = (patch for patch in axes.patches if isinstance(patch, Polygon))
    inner, outer = np.split(band.get_xy(), 2)  # it ends where it begins
    np.testing.assert_allclose(inner[:, 0], 2e3 * np.concatenate([[0], std]))
    np.testing.assert_allclose(outer[::-1, 0], -inner[:, 0])
    np.testing.assert_allclose(inner[:, 1], 1e3 * shipped_finger.link_ends)
